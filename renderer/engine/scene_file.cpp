#include "renderer/engine/scene_file.h"

#include <utility>

#include "io/display/working_space.h"
#include "io/image/input.h"
#include "renderer/core/parallel.h"
#include "renderer/description/clear_sky.h"
#include "renderer/engine/frame_scene.h"
#include "renderer/shading/lobes/specular_albedo.h"

namespace emberline {
namespace {

constexpr std::array kParts = {MemoryPart::kFile, MemoryPart::kGeometry, MemoryPart::kTextures,
                               MemoryPart::kLights};
enum : size_t { kFilePart, kGeometryPart, kTexturesPart };

}  // namespace

SceneFile::SceneFile(const FrameSettings& settings, LoadProgress& progress,
                     const AdditionalParts& parts) {
  GltfOptions options = load_options(settings);
  options.variants |= parts.variants;
  options.tangents = parts.tangents;
  options.nodes |= parts.nodes;
  gltf_ = std::make_unique<GltfFile>(settings.scene, options, progress);
}

// Reads the environment once, after the file's own images.
void SceneFile::read_environment(const FrameSettings& settings, LoadProgress& progress) {
  if (environment_ || (settings.environment.empty() && !settings.sun)) return;
  progress.begin(LoadStage::kEnvironment);
  const uint64_t before = progress.budget()->reserved(MemoryPart::kTextures);
  EnvironmentDescription environment;
  if (settings.sun) {
    environment = clear_sky({settings.sun->elevation, settings.sun->azimuth});
    progress.budget()->reserve(MemoryPart::kTextures, environment.image->byte_count(), "`sun`");
  } else {
    environment.file = settings.environment;
    environment.image =
        emberline::read_environment(settings.environment, &repaired_texels_, progress);
    warn_about_repaired(settings.environment, repaired_texels_);
  }
  environment.strength = settings.environment_strength;
  environment.rotation_degrees = settings.environment_rotation;
  environment_ = std::move(environment);
  environment_bytes_ = progress.budget()->reserved(MemoryPart::kTextures) - before;
}

SceneDescription SceneFile::pose(const FrameSettings& settings, std::span<const uint64_t> held,
                                 LoadProgress& progress) {
  SceneDescription scene = gltf_->pose(load_options(settings), held, progress);
  // Decoding the environment leaves threads idle. They build the tables that every first hit needs.
  parallel_tasks(2, [&](size_t task) {
    if (task == 0) return read_environment(settings, progress);
    if (!scene.materials.empty()) SpecularAlbedo::prepare();
  });
  if (environment_) scene.environment = environment_;
  scene.to_working = to_working_space(settings.working_space);
  scene.repairs.non_finite_texels += repaired_texels_;
  return scene;
}

SceneSource::~SceneSource() {
  const Reservations before = reserved();
  close();
  Reservations left = reserved();
  for (size_t i = 0; i < left.size(); ++i)
    left[i] += scene_reservations_[i] + pose_reservations_[i] - before[i];
  left[kGeometryPart] += reusable_bytes_;
  release(left);
}

void SceneSource::open(const FrameSettings& settings, LoadProgress& progress,
                       const AdditionalParts& parts) {
  file_ = std::make_unique<SceneFile>(settings, progress, parts);
}

SceneSource::Reservations SceneSource::reserved() const {
  Reservations use;
  for (size_t i = 0; i < use.size(); ++i) use[i] = budget_->reserved(kParts[i]);
  return use;
}

void SceneSource::begin() {
  before_ = reserved();
  images_before_ = file_ ? file_->image_bytes() : 0;
}

SceneSource::Reservations SceneSource::take_reservations() {
  Reservations use = reserved();
  for (size_t i = 0; i < use.size(); ++i) use[i] -= before_[i];
  scene_reservations_[kFilePart] += std::exchange(use[kFilePart], 0);
  const uint64_t images = file_ ? file_->image_bytes() - images_before_ : 0;
  scene_reservations_[kTexturesPart] += images;
  use[kTexturesPart] -= images;
  return use;
}

void SceneSource::release(const Reservations& use) {
  for (size_t i = 0; i < use.size(); ++i) budget_->release(kParts[i], use[i]);
}

void SceneSource::roll_back() { release(take_reservations()); }

void SceneSource::commit() {
  Reservations now = take_reservations();
  const uint64_t read = file_ ? file_->gltf().new_static_bytes() : 0;
  const uint64_t reusable_bytes = file_ ? file_->gltf().static_bytes() : 0;
  now[kGeometryPart] -= read;
  // Also releases the memory of meshes that were kept for reuse but that this pose does not use.
  pose_reservations_[kGeometryPart] += reusable_bytes_ + read - reusable_bytes;
  release(pose_reservations_);
  pose_reservations_ = now;
  reusable_bytes_ = reusable_bytes;
}

}  // namespace emberline
