#include "io/gltf/gltf_file.h"

#include <algorithm>
#include <new>
#include <nlohmann/json.hpp>
#include <utility>

#include "io/gltf/animation/animated_values.h"
#include "io/gltf/animation/animation.h"
#include "io/gltf/document/document.h"
#include "io/gltf/document/extensions.h"
#include "io/gltf/document/tiny_gltf_renamed.h"
#include "io/gltf/geometry/scene.h"
#include "io/gltf/materials/images.h"
#include "io/gltf/materials/material.h"
#include "io/gltf/materials/variants.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/readable.h"

namespace emberline {
namespace {

void report_faults(const GltfDocument& document, CoverageReport& coverage) {
  for (const std::string& line : document.faults->lines()) {
    log_warning(line);
    const bool names_file = line.starts_with(document.file);
    coverage.ignored.push_back(names_file ? line.substr(document.file.size()) : line);
  }
}

// Converts internal exceptions to an InputError, which the user sees.
template <class Read>
auto convert_exceptions(const std::string& path, const Read& read) try {
  return read();
} catch (const std::bad_alloc&) {
  throw InputError(path, "not enough memory to load the file");
} catch (const nlohmann::json::exception& error) {
  // check_schema() should have found this fault. Even so, it is a fault of the file.
  throw InputError(path, std::string("unexpected structure: ") + error.what());
}

GltfDocument open_and_check(const std::string& path, const GltfOptions& options,
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
class ScopedProgress {
 public:
  ScopedProgress(GltfDocument& document, LoadProgress& progress) : document_(document) {
    document.progress = &progress;
  }
  ~ScopedProgress() { document_.progress = &LoadProgress::none(); }
  ScopedProgress(const ScopedProgress&) = delete;
  ScopedProgress& operator=(const ScopedProgress&) = delete;

 private:
  GltfDocument& document_;
};

}  // namespace

struct GltfFile::State {
  State(const std::string& path, const GltfOptions& loading, LoadProgress& progress);

  void select_animation(const GltfOptions& pose_options);
  SceneDescription read(std::span<const uint64_t> held);

  const GltfOptions options;
  GltfDocument document;
  std::vector<AnimationDescription> animations;
  size_t faults = 0;  // number of faults before any animation was read
  size_t selection_faults = 0;
  // The chosen animations, and whether a time was chosen. All members below depend on this choice.
  std::optional<std::pair<std::string, bool>> selection;
  GltfAnimation animation;
  nlohmann::json original_members =
      nlohmann::json::object();  // original root members, which animation pointers overwrite
  MemoryReservation original_members_memory;
  GltfCache cache;
};

GltfFile::State::State(const std::string& path, const GltfOptions& loading, LoadProgress& progress)
    : options(loading), document(open_and_check(path, loading, progress)) {
  const ScopedProgress scoped_progress(document, progress);
  animations = describe_animations(document);
  faults = document.faults->count();
}

// If the choice of animations changes, discards everything that was read for the previous choice.
void GltfFile::State::select_animation(const GltfOptions& pose_options) {
  const std::pair wanted(pose_options.animation, pose_options.time.has_value());
  if (selection != wanted) {
    document.faults->forget(faults);
    selection.reset();
    document.json->update(original_members);
    original_members = nlohmann::json::object();
    document.model.reset();
    cache.meshes.clear();
    cache.instancing.clear();
    cache.memory = MemoryReservation(document.progress->budget(), MemoryPart::kGeometry);
    animation = read_animation(document, pose_options, animations);
    if (!animation.pointers.empty()) {
      original_members_memory = MemoryReservation(document.progress->budget(), MemoryPart::kFile,
                                                  document.json_memory.bytes(), document.file);
    }
    for (const PointerTrack& track : animation.pointers) {
      const std::string path = track.pointer.substr(1);
      const std::string member = path.substr(0, path.find('/'));
      if (!original_members.contains(member)) original_members[member] = document.json->at(member);
    }
    selection_faults = document.faults->count();
    selection = wanted;
  }
  document.faults->forget(selection_faults);
  set_time(document, pose_options, animation);
  write_values_at(animation, std::max(animation.open, std::min(animation.time, animation.close)),
                  *document.json);
}

SceneDescription GltfFile::State::read(std::span<const uint64_t> held) {
  MemoryBudget& memory = *document.progress->budget();
  SceneDescription scene;
  const GltfAnimatedValues changes(document, animation, scene.coverage);
  scene.file = document.file;
  scene.animations = animations;
  scene.generator = document.model->asset.generator;
  report_extensions(document, scene.coverage);
  report_unknown_members(document, scene.coverage);
  if (animation.at_rest && !animations.empty()) {
    scene.coverage.not_played =
        animations.size() == 1
            ? "1 animation; set `time` or `frame` to play it"
            : readable_count(animations.size()) + " animations; choose one with `animation`";
    log_warning(document.file + ": not played: " + scene.coverage.not_played);
  }
  memory.reserve(MemoryPart::kGeometry,
                 bytes_of(document.array("materials").size(), sizeof(MaterialDescription)),
                 document.file);
  scene.materials = read_materials(document, options, scene.coverage);
  changes.apply(scene.materials);
  scene.variants = read_variants(document);
  scene.variants_read = options.variants;
  scene.tangents_read = options.tangents;
  load_scene_graph(document, animation, changes, held, cache, scene);
  if (options.nodes) scene.nodes = read_nodes(document);
  const uint64_t before = memory.reserved(MemoryPart::kTextures);
  load_images(document, options, cache.images, cache.textures, scene);
  cache.image_bytes += memory.reserved(MemoryPart::kTextures) - before;
  report_clamped_values(document, animation);
  report_faults(document, scene.coverage);
  scene.files = document.files();
  if (!cache.deforms) {
    for (const auto& buffer : document.buffers) {
      if (buffer) buffer->forget();
    }
  }
  return scene;
}

GltfFile::GltfFile(const std::string& path, const GltfOptions& options, LoadProgress& progress)
    : state_(convert_exceptions(
          path, [&] { return std::make_unique<State>(path, options, progress); })) {}

GltfFile::~GltfFile() = default;

SceneDescription GltfFile::pose(const GltfOptions& pose_options, std::span<const uint64_t> held,
                                LoadProgress& progress) {
  return convert_exceptions(state_->document.file, [&] {
    const ScopedProgress scoped_progress(state_->document, progress);
    state_->select_animation(pose_options);
    // The model is parsed again if animation pointers may have changed the JSON.
    if (!state_->document.model || !state_->animation.pointers.empty()) {
      parse_gltf_model(state_->document);
    }
    return state_->read(held);
  });
}

uint64_t GltfFile::image_bytes() const { return state_->cache.image_bytes; }
uint64_t GltfFile::static_bytes() const { return state_->cache.static_bytes; }
uint64_t GltfFile::new_static_bytes() const { return state_->cache.new_static_bytes; }

SceneDescription load_gltf(const std::string& path, const GltfOptions& options,
                           LoadProgress& progress) {
  return GltfFile(path, options, progress).pose(options, {}, progress);
}

}  // namespace emberline
