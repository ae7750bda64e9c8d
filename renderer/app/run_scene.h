// The scene of a run's frames: opened once, and posed for each frame where an animation moves it.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/files/register.h"
#include "io/json/value.h"
#include "renderer/core/load_progress.h"
#include "renderer/description/framing.h"
#include "renderer/description/scene_edits.h"
#include "renderer/engine/open_scene.h"
#include "renderer/output/checkpoint_head.h"
#include "renderer/output/render_options.h"
#include "renderer/output/report.h"

namespace emberline {

class RunScene {
 public:
  // `frames`: more than one will be asked for.
  RunScene(const LoadLimits& limits, bool frames) : limits_(limits), frames_(frames) {}

  // For each frame, in this order. What throws in the first frame's is wrong with the scene.
  // Reads what the frame is made of; a scene that is there stays, but what an animation poses for
  // another time.
  void load(const RenderOptions& options, const SceneBuildOptions& build, LoadProgress& progress);
  void build(LoadProgress& progress);
  // The fingerprints of what was loaded. Throws what LoadedFiles does.
  const nlohmann::json& inputs(const RenderOptions& options, LoadProgress& progress);

  bool failed() const { return failed_; }  // to be loaded or built the first time
  bool is_built() const { return scene_ && stands_; }
  const OpenScene& open() const { return *scene_; }
  const Scene& scene() const { return scene_->scene(); }
  // What this frame looks through.
  CameraDescription camera(const RenderOptions& options) const;
  // What it reads. Throws UsageError where that would be overwritten.
  void register_inputs(FileRegister& files) const;
  void report(RenderReport& report) const;
  // How many warnings there were when it was built: those of the scene, and of every frame.
  size_t warnings() const { return warnings_; }

 private:
  void read(const RenderOptions& options, const SceneBuildOptions& build, LoadProgress& progress);

  const LoadLimits& limits_;
  const bool frames_;
  bool failed_ = false, was_built_ = false;
  bool stands_ = false;         // scene_ is of the frame's time
  std::optional<double> time_;  // that it is posed for, or will be
  SceneEdits edits_;
  std::unique_ptr<OpenScene> scene_;
  std::optional<ReadScene> read_;  // the frame's, until it is built
  CameraDescription camera_;       // without a turntable
  WorldBounds bounds_;             // for one
  LoadedFiles loaded_;
  JsonValue inputs_;  // its fingerprints; null: not taken yet
  std::vector<NamedFile> files_;
  size_t warnings_ = 0;
};

}  // namespace emberline
