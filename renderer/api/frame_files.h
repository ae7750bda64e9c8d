// The checkpoint of a frame of the library, which is the command's: each goes on with the other's.
#pragma once

#include <optional>

#include "renderer/api/frame_parts.h"
#include "renderer/engine/render_job.h"
#include "renderer/output/checkpoint.h"

namespace emberline::api {

class FrameFiles {
 public:
  // Takes the checkpoint that the options name, if they do. Reads the scene's files again, to know
  // what the frame is made of. Throws what Checkpoint does, and Stopped.
  FrameFiles(const RenderOptions& options, const RenderPlan& plan, const FrameParts& parts,
             const Access::SceneState& scene, const std::stop_token& give_up);

  // Before it renders. `most` bytes are what its state takes.
  void prepare(uint64_t most, RenderJob& job);
  bool wanted() const { return checkpoint_ && checkpoint_->wanted(); }
  void save(RenderJob& job) {
    if (checkpoint_) checkpoint_->save(job);
  }
  // After it has rendered: saves what is to be kept of a frame that is done.
  void rendered(bool stopped, PixelStop cause, RenderJob& job);
  // Where there is no picture of what was rendered: saves it, unless that is done already.
  void no_picture(bool stopped, RenderJob& job);
  // Once there is a picture. Says in the log what could not be saved.
  void finish(bool stopped);
  bool is_open() const { return checkpoint_.has_value(); }

 private:
  const RenderOptions& options_;
  std::optional<Checkpoint> checkpoint_;
};

}  // namespace emberline::api
