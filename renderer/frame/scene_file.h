// A scene's file that is posed for one frame after another.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>

#include "io/gltf.h"
#include "renderer/core/load_progress.h"
#include "renderer/core/memory_budget.h"
#include "renderer/description/scene_description.h"
#include "renderer/frame/frame_settings.h"

namespace emberline {

// load_scene (frame_scene.h) at one time after another.
class SceneFile {
 public:
  // Of the settings all but animation, time and shutter count. `variants` and `tangents` as there.
  SceneFile(const FrameSettings& settings, LoadProgress& progress, bool variants, bool tangents);

  // The scene as the settings have it animated; `held` as in GltfFile::pose. Throws as that does.
  SceneDescription pose(const FrameSettings& settings, std::span<const uint64_t> held,
                        LoadProgress& progress);
  const GltfFile& gltf() const { return *gltf_; }

 private:
  void read_environment(const FrameSettings& settings, LoadProgress& progress);

  std::unique_ptr<GltfFile> gltf_;
  std::optional<EnvironmentDescription> environment_;  // the settings'
  uint64_t repaired_texels_ = 0;                       // of it
};

// What poses reserve and nobody gives back by itself (Embree does, for the BVH): given back when
// the next one stands.
class PosedMemory {
 public:
  explicit PosedMemory(std::shared_ptr<MemoryBudget> budget) : budget_(std::move(budget)) {}

  // Around the pose and what is built of it: `end` where that stands, `fail` where it does not.
  void begin(const SceneFile& file);
  void end(const SceneFile& file);
  void fail(const SceneFile& file) { give_back(since_begin(file)); }

 private:
  using Use = std::array<uint64_t, 3>;

  Use reserved() const;
  Use since_begin(const SceneFile& file) const;  // without what the file keeps
  void give_back(const Use& use);

  const std::shared_ptr<MemoryBudget> budget_;
  Use before_ = {};
  uint64_t images_before_ = 0;
  Use of_pose_ = {};      // of the scene that stands: what the next will have of its own,
  uint64_t resting_ = 0;  // and what it may take over
};

}  // namespace emberline
