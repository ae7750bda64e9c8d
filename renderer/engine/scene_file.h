// Reads a scene's file once and poses it for many frames. Keeps track of the memory that the scene
// reserves.
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

// Parts of the file that are read even if the settings do not need them; see GltfOptions. Edits may
// need variants and tangents (need_tangents() in scene_edits.h).
struct AdditionalParts {
  bool variants = false, tangents = false, nodes = false;
};

// A scene file with the settings' environment, which can be posed repeatedly.
class SceneFile {
 public:
  // Ignores animation, time and shutter of the settings. Throws InputError and Cancelled.
  SceneFile(const FrameSettings& settings, LoadProgress& progress, const AdditionalParts& parts);

  // Returns the scene in the settings' pose. GltfFile::pose() explains `held` and the exceptions.
  SceneDescription pose(const FrameSettings& settings, std::span<const uint64_t> held,
                        LoadProgress& progress);
  const GltfFile& gltf() const { return *gltf_; }
  // Bytes of all images read so far, including the settings' environment.
  uint64_t image_bytes() const { return gltf_->image_bytes() + environment_bytes_; }

 private:
  void read_environment(const FrameSettings& settings, LoadProgress& progress);

  std::unique_ptr<GltfFile> gltf_;
  std::optional<EnvironmentDescription> environment_;     // from the settings
  uint64_t repaired_texels_ = 0, environment_bytes_ = 0;  // of the environment
};

// Holds an open scene's file and the memory reservations that this class must release. (Embree and
// the file release their own reservations.)
class SceneSource {
 public:
  explicit SceneSource(std::shared_ptr<MemoryBudget> budget) : budget_(std::move(budget)) {}
  // Must be destroyed after the scene.
  ~SceneSource();

  // See SceneFile::SceneFile().
  void open(const FrameSettings& settings, LoadProgress& progress, const AdditionalParts& parts);
  bool is_open() const { return file_ != nullptr; }
  SceneFile& file() { return *file_; }
  const std::shared_ptr<MemoryBudget>& budget() const { return budget_; }
  // Closes the file. No further pose can be read afterwards.
  void close() { file_.reset(); }

  // begin() must be called before reading and building a pose. Afterwards, commit() releases the
  // reservations of the previous pose, or roll_back() releases those made since begin().
  void begin();
  void commit();
  void roll_back();

 private:
  using Reservations = std::array<uint64_t, 4>;

  Reservations reserved() const;
  // Returns the reservations made since begin() for data of the pose. Adds those for data that the
  // file keeps to scene_reservations_.
  Reservations take_reservations();
  void release(const Reservations& use);

  const std::shared_ptr<MemoryBudget> budget_;
  std::unique_ptr<SceneFile> file_;
  Reservations before_ = {};
  uint64_t images_before_ = 0;
  Reservations scene_reservations_ = {};  // for as long as the scene is open
  Reservations pose_reservations_ = {};   // only for the current pose
  uint64_t reusable_bytes_ = 0;           // geometry that the next pose may reuse
};

}  // namespace emberline
