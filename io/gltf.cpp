#include "io/gltf.h"

#include <new>

#include "io/gltf_animation.h"
#include "io/gltf_changes.h"
#include "io/gltf_document.h"
#include "io/gltf_extensions.h"
#include "io/gltf_images.h"
#include "io/gltf_material.h"
#include "io/gltf_model.h"
#include "io/gltf_scene.h"
#include "io/gltf_variants.h"
#include "io/tiny_gltf_renamed.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"

namespace emberline {
namespace {

void report_faults(const GltfDocument& document, CoverageReport& coverage) {
  for (const std::string& line : document.faults->lines()) {
    log_warning(line);
    const bool names_file = line.starts_with(document.file);
    coverage.ignored.push_back(names_file ? line.substr(document.file.size()) : line);
  }
}

}  // namespace

SceneDescription load_gltf(const std::string& path, const GltfOptions& options,
                           LoadProgress& progress) try {
  progress.begin(LoadStage::kReading);
  GltfDocument document = open_gltf_document(path, options.resource_root, progress);
  load_gltf_buffers(document);
  check_gltf_accessors(document);
  check_gltf_nodes(document);
  check_gltf_skins(document);
  check_gltf_cameras_and_lights(document);
  check_gltf_animations(document);

  SceneDescription scene;
  scene.animations = describe_animations(document);
  const GltfAnimation animation = read_animation(document, options, scene.animations);
  write_values_at(animation, std::max(animation.open, std::min(animation.time, animation.close)),
                  document.json);
  const GltfChanges changes(document, animation, scene.coverage);
  const MemoryReservation model_memory(progress.budget(), MemoryPart::kFile,
                                       gltf_model_bytes(document), path);
  const auto model = parse_gltf_model(document);

  scene.file = path;
  scene.generator = model->asset.generator;
  report_extensions(document, scene.coverage);
  if (animation.at_rest && !document.array("animations").empty()) {
    report_ignored(path, "animations (at rest)", scene.coverage);
  }
  progress.budget()->reserve(
      MemoryPart::kGeometry,
      bytes_of(document.array("materials").size(), sizeof(MaterialDescription)), path);
  scene.materials = read_materials(document, *model, options, scene.coverage);
  changes.apply(scene.materials);
  scene.variants = read_variants(document);
  scene.variants_read = options.variants;
  scene.tangents_read = options.tangents;
  load_scene_graph(document, *model, animation, changes, scene);
  load_images(document, options, scene);
  report_faults(document, scene.coverage);
  scene.files = document.files();
  return scene;
} catch (const std::bad_alloc&) {
  throw InputError(path, "there is not enough memory to load it");
} catch (const nlohmann::json::exception& error) {
  // check_schema leaves nothing to trip over; if something did, it is the file's fault still.
  throw InputError(path, std::string("unexpected structure: ") + error.what());
}

}  // namespace emberline
