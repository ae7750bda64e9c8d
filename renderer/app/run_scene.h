// The scene of a run's frames: opened once, and posed for each frame where an animation moves it.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "io/files/register.h"
#include "io/json/value.h"
#include "renderer/core/errors.h"
#include "renderer/core/load_progress.h"
#include "renderer/description/framing.h"
#include "renderer/description/scene_edits.h"
#include "renderer/engine/open_scene.h"
#include "renderer/output/checkpoint_head.h"
#include "renderer/output/render_options.h"
#include "renderer/output/report.h"

namespace emberline {

// The scene cannot be opened, which ends every frame of the run.
struct UnusableScene : EmberlineError {
  using EmberlineError::EmberlineError;
};

// How a frame has its scene.
struct ScenePose {
  std::optional<double> time;  // seconds; absent: at rest
  CameraDescription camera;    // without a turntable
  WorldBounds bounds;          // for one
};

// The scene of a frame that is read and not built.
struct ReadPose {
  ScenePose pose;
  std::optional<ReadScene> read;  // nothing where the run's scene is in that pose
};

// The scene in the pose of a frame, until the next frame's is built.
struct PosedScene {
  std::unique_ptr<OpenScene> open;
  ScenePose pose;
  size_t warnings = 0;  // when it was built: those of the scene, and of every frame

  CameraDescription camera_of(const FrameSettings& settings) const;
  void report(RenderReport& report) const;
};

class RunScene {
 public:
  // `frames`: more than one will be asked for.
  explicit RunScene(bool frames) : frames_(frames) {}

  // Reads what the frame is made of, of a scene that is there only what an animation poses for
  // another time. Throws UnusableScene the first time.
  ReadPose load(const RenderOptions& options, const SceneBuildOptions& build,
                LoadProgress& progress);
  // Throws UnusableScene the first time.
  const PosedScene& build(ReadPose read, LoadProgress& progress);

  // The pose of the last frame that was built; null before the first.
  const PosedScene* posed() const { return posed_ ? &*posed_ : nullptr; }
  // The fingerprints of the loaded files. Throws what LoadedFiles does.
  const nlohmann::json& inputs(const RenderOptions& options, LoadProgress& progress);
  // Registers the files that the scene reads. Throws UsageError where one would be overwritten.
  void register_inputs(FileRegister& files) const;

 private:
  ReadScene open(const RenderOptions& options, const OpenOptions& asked, LoadProgress& progress);

  const bool frames_;
  std::optional<PosedScene> posed_;
  SceneEdits edits_;
  LoadedFiles loaded_;
  JsonValue inputs_;  // its fingerprints; null: not taken yet
  std::vector<NamedFile> files_;
};

}  // namespace emberline
