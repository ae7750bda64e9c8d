// The scene's file, posed for one frame after another, and the memory that a scene reserves.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>

#include "io/gltf/gltf_file.h"
#include "renderer/core/load_progress.h"
#include "renderer/core/memory_budget.h"
#include "renderer/description/scene_description.h"
#include "renderer/engine/frame_settings.h"

namespace emberline {

// A scene's file and the environment of the settings, posed for one time after another.
class SceneFile {
 public:
  // Ignores animation, time and shutter of the settings. `variants` and `tangents` are those of
  // GltfOptions, which edits may need (need_tangents() in scene_edits.h); variants are also read if
  // the settings choose one. Throws InputError, and Cancelled.
  SceneFile(const FrameSettings& settings, LoadProgress& progress, bool variants, bool tangents);

  // The scene as the settings have it animated; `held` as in GltfFile::pose. Throws as that does.
  SceneDescription pose(const FrameSettings& settings, std::span<const uint64_t> held,
                        LoadProgress& progress);
  const GltfFile& gltf() const { return *gltf_; }
  // Bytes of all images read so far, including the settings' environment.
  uint64_t image_bytes() const { return gltf_->image_bytes() + environment_bytes_; }

 private:
  void read_environment(const FrameSettings& settings, LoadProgress& progress);

  std::unique_ptr<GltfFile> gltf_;
  std::optional<EnvironmentDescription> environment_;     // the settings'
  uint64_t repaired_texels_ = 0, environment_bytes_ = 0;  // of it
};

// An open scene's file, and the scene's reservations that nothing else releases. (Embree releases
// those of its BVHs, the file its own.)
class SceneSource {
 public:
  explicit SceneSource(std::shared_ptr<MemoryBudget> budget) : budget_(std::move(budget)) {}
  // Must come after the scene's destructor.
  ~SceneSource();

  // As the constructor of SceneFile.
  void open(const FrameSettings& settings, LoadProgress& progress, bool variants, bool tangents);
  bool is_open() const { return file_ != nullptr; }
  SceneFile& file() { return *file_; }
  // Call when no other pose will be read.
  void close() { file_.reset(); }

  // Bracket reading and building a pose: stand() releases the previous scene's reservations, fail()
  // those made since begin().
  void begin();
  void stand();
  void fail();

 private:
  using Use = std::array<uint64_t, 4>;

  Use reserved() const;
  // Since begin(), without what the file keeps; that is counted as held.
  Use take_use();
  void give_back(const Use& use);

  const std::shared_ptr<MemoryBudget> budget_;
  std::unique_ptr<SceneFile> file_;
  Use before_ = {};
  uint64_t images_before_ = 0;
  Use held_ = {};         // as long as the scene is open
  Use of_pose_ = {};      // of the scene that stands: what the next will have of its own,
  uint64_t resting_ = 0;  // and what it may take over
};

}  // namespace emberline
