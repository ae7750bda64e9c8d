#include "io/gltf/gltf_file.h"

#include <algorithm>
#include <new>
#include <nlohmann/json.hpp>
#include <utility>

#include "io/gltf/animation/animation.h"
#include "io/gltf/animation/changes.h"
#include "io/gltf/document/document.h"
#include "io/gltf/document/extensions.h"
#include "io/gltf/document/tiny_gltf_renamed.h"
#include "io/gltf/geometry/scene.h"
#include "io/gltf/materials/images.h"
#include "io/gltf/materials/material.h"
#include "io/gltf/materials/variants.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/setting_names.h"

namespace emberline {
namespace {

void report_faults(const GltfDocument& document, CoverageReport& coverage) {
  for (const std::string& line : document.faults->lines()) {
    log_warning(line);
    const bool names_file = line.starts_with(document.file);
    coverage.ignored.push_back(names_file ? line.substr(document.file.size()) : line);
  }
}

// Converts internal exceptions to the InputError that the user sees.
template <class Read>
auto reading(const std::string& path, const Read& read) try {
  return read();
} catch (const std::bad_alloc&) {
  throw InputError(path, "there is not enough memory to load it");
} catch (const nlohmann::json::exception& error) {
  // check_schema rules these out; if one occurs anyway, it is still the file's fault.
  throw InputError(path, std::string("unexpected structure: ") + error.what());
}

GltfDocument open_checked(const std::string& path, const GltfOptions& options,
                          LoadProgress& progress) {
  progress.begin(LoadStage::kReading);
  GltfDocument document = open_gltf_document(path, options.resource_root, progress);
  load_gltf_buffers(document);
  check_gltf_accessors(document);
  check_gltf_nodes(document);
  check_gltf_skins(document);
  check_gltf_cameras_and_lights(document);
  check_gltf_animations(document);
  return document;
}

// Attaches the caller's progress to the document during a call.
class Watched {
 public:
  Watched(GltfDocument& document, LoadProgress& progress) : document_(document) {
    document.progress = &progress;
  }
  ~Watched() { document_.progress = &LoadProgress::unwatched(); }
  Watched(const Watched&) = delete;
  Watched& operator=(const Watched&) = delete;

 private:
  GltfDocument& document_;
};

}  // namespace

struct GltfFile::State {
  State(const std::string& path, const GltfOptions& loading, LoadProgress& progress);

  void choose(const GltfOptions& when);
  SceneDescription read(std::span<const uint64_t> held);

  const GltfOptions options;
  GltfDocument document;
  std::vector<AnimationDescription> animations;
  size_t faults = 0;  // faults of the file without animations
  size_t faults_of_choice = 0;
  // The chosen animations, and whether they pose the scene; everything below depends on it.
  std::optional<std::pair<std::string, bool>> choice;
  GltfAnimation animation;
  nlohmann::json unwritten = nlohmann::json::object();  // original members that pointers write to
  MemoryReservation unwritten_memory;
  GltfRest rest;
};

GltfFile::State::State(const std::string& path, const GltfOptions& loading, LoadProgress& progress)
    : options(loading), document(open_checked(path, loading, progress)) {
  const Watched watched(document, progress);
  animations = describe_animations(document);
  faults = document.faults->count();
}

// Discards what was read for other animations.
void GltfFile::State::choose(const GltfOptions& when) {
  const std::pair wanted(when.animation, when.time.has_value());
  if (choice != wanted) {
    document.faults->forget(faults);
    choice.reset();
    document.json->update(unwritten);
    unwritten = nlohmann::json::object();
    document.model.reset();
    rest.meshes.clear();
    rest.instancing.clear();
    rest.memory = MemoryReservation(document.progress->budget(), MemoryPart::kGeometry);
    animation = read_animation(document, when, animations);
    if (!animation.pointers.empty()) {
      unwritten_memory = MemoryReservation(document.progress->budget(), MemoryPart::kFile,
                                           document.json_memory.bytes(), document.file);
    }
    for (const PointerTrack& track : animation.pointers) {
      const std::string path = track.pointer.substr(1);
      const std::string member = path.substr(0, path.find('/'));
      if (!unwritten.contains(member)) unwritten[member] = document.json->at(member);
    }
    faults_of_choice = document.faults->count();
    choice = wanted;
  }
  document.faults->forget(faults_of_choice);
  set_time(document, when, animation);
  write_values_at(animation, std::max(animation.open, std::min(animation.time, animation.close)),
                  *document.json);
}

SceneDescription GltfFile::State::read(std::span<const uint64_t> held) {
  MemoryBudget& memory = *document.progress->budget();
  SceneDescription scene;
  const GltfChanges changes(document, animation, scene.coverage);
  scene.file = document.file;
  scene.animations = animations;
  scene.generator = document.model->asset.generator;
  report_extensions(document, scene.coverage);
  report_unknown_members(document, scene.coverage);
  if (animation.at_rest && !animations.empty()) {
    report_ignored(document.file, spelled("animations (not played; choose one with `animation`)"),
                   scene.coverage);
  }
  memory.reserve(MemoryPart::kGeometry,
                 bytes_of(document.array("materials").size(), sizeof(MaterialDescription)),
                 document.file);
  scene.materials = read_materials(document, options, scene.coverage);
  changes.apply(scene.materials);
  scene.variants = read_variants(document);
  scene.variants_read = options.variants;
  scene.tangents_read = options.tangents;
  load_scene_graph(document, animation, changes, held, rest, scene);
  if (options.nodes) scene.nodes = read_nodes(document);
  const uint64_t before = memory.reserved(MemoryPart::kTextures);
  load_images(document, options, rest.images, rest.textures, scene);
  rest.image_bytes += memory.reserved(MemoryPart::kTextures) - before;
  report_clamped_values(document, animation);
  report_faults(document, scene.coverage);
  scene.files = document.files();
  if (!rest.deforms) {
    for (const auto& buffer : document.buffers) {
      if (buffer) buffer->forget();
    }
  }
  return scene;
}

GltfFile::GltfFile(const std::string& path, const GltfOptions& options, LoadProgress& progress)
    : state_(reading(path, [&] { return std::make_unique<State>(path, options, progress); })) {}

GltfFile::~GltfFile() = default;

SceneDescription GltfFile::pose(const GltfOptions& when, std::span<const uint64_t> held,
                                LoadProgress& progress) {
  return reading(state_->document.file, [&] {
    const Watched watched(state_->document, progress);
    state_->choose(when);
    // Parsed again if animation pointers may have changed the JSON.
    if (!state_->document.model || !state_->animation.pointers.empty()) {
      parse_gltf_model(state_->document);
    }
    return state_->read(held);
  });
}

uint64_t GltfFile::image_bytes() const { return state_->rest.image_bytes; }
uint64_t GltfFile::resting_bytes() const { return state_->rest.resting_bytes; }
uint64_t GltfFile::read_bytes() const { return state_->rest.read_bytes; }

SceneDescription load_gltf(const std::string& path, const GltfOptions& options,
                           LoadProgress& progress) {
  return GltfFile(path, options, progress).pose(options, {}, progress);
}

}  // namespace emberline
