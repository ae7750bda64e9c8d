#include "renderer/frame/scene_file.h"

#include "io/image_input.h"
#include "renderer/core/parallel.h"
#include "renderer/description/clear_sky.h"
#include "renderer/frame/frame_scene.h"
#include "renderer/shading/lobes/specular_albedo.h"

namespace emberline {
namespace {

constexpr std::array kParts = {MemoryPart::kGeometry, MemoryPart::kTextures, MemoryPart::kLights};
constexpr size_t kGeometryPart = 0, kTexturesPart = 1;

}  // namespace

SceneFile::SceneFile(const FrameSettings& settings, LoadProgress& progress, bool variants,
                     bool tangents) {
  GltfOptions options = load_options(settings);
  options.variants |= variants;
  options.tangents = tangents;
  gltf_ = std::make_unique<GltfFile>(settings.scene, options, progress);
}

// After the file's own images, once.
void SceneFile::read_environment(const FrameSettings& settings, LoadProgress& progress) {
  if (environment_ || (settings.environment.empty() && !settings.sun)) return;
  progress.begin(LoadStage::kEnvironment);
  EnvironmentDescription environment;
  if (settings.sun) {
    environment = clear_sky({settings.sun->elevation, settings.sun->azimuth});
    progress.budget()->reserve(MemoryPart::kTextures, environment.image->byte_count(), "--sun");
  } else {
    environment.file = settings.environment;
    environment.image =
        emberline::read_environment(settings.environment, &repaired_texels_, progress);
    warn_of_repaired(settings.environment, repaired_texels_);
  }
  environment.strength = settings.environment_strength;
  environment.rotation_degrees = settings.environment_rotation;
  environment_ = std::move(environment);
}

SceneDescription SceneFile::pose(const FrameSettings& settings, std::span<const uint64_t> held,
                                 LoadProgress& progress) {
  SceneDescription scene = gltf_->pose(load_options(settings), held, progress);
  // A picture's decoder leaves threads idle; every first hit would wait for the tables.
  parallel_tasks(2, [&](size_t task) {
    if (task == 0) return read_environment(settings, progress);
    if (!scene.materials.empty()) SpecularAlbedo::prepare();
  });
  if (environment_) scene.environment = environment_;
  scene.to_working = to_working_space(settings.working_space);
  scene.repairs.non_finite_texels += repaired_texels_;
  return scene;
}

PosedMemory::Use PosedMemory::reserved() const {
  Use use;
  for (size_t i = 0; i < use.size(); ++i) use[i] = budget_->reserved(kParts[i]);
  return use;
}

void PosedMemory::begin(const SceneFile& file) {
  before_ = reserved();
  images_before_ = file.gltf().image_bytes();
}

PosedMemory::Use PosedMemory::since_begin(const SceneFile& file) const {
  Use use = reserved();
  for (size_t i = 0; i < use.size(); ++i) use[i] -= before_[i];
  use[kTexturesPart] -= file.gltf().image_bytes() - images_before_;
  return use;
}

void PosedMemory::give_back(const Use& use) {
  for (size_t i = 0; i < use.size(); ++i) budget_->give_back(kParts[i], use[i]);
}

void PosedMemory::end(const SceneFile& file) {
  Use now = since_begin(file);
  const uint64_t read = file.gltf().read_bytes(), resting = file.gltf().resting_bytes();
  now[kGeometryPart] -= read;
  // Meshes that rest and are in this pose no more.
  of_pose_[kGeometryPart] += resting_ + read - resting;
  give_back(of_pose_);
  of_pose_ = now;
  resting_ = resting;
}

}  // namespace emberline
