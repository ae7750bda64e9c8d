// The checkpoint of a frame of the library: as the command's, which goes on with it and it with the
// command's.
#pragma once

#include <optional>

#include "renderer/api/frame_parts.h"
#include "renderer/engine/render_job.h"
#include "renderer/output/checkpoint.h"

namespace emberline::api {

class FrameFiles {
 public:
  // Takes the checkpoint that the options name, if they do. Reads the scene's files again, to know
  // what the frame is made of. Throws what the options' names and what is there deserve.
  FrameFiles(const RenderOptions& options, const RenderPlan& plan, const FrameParts& parts,
             const Access::SceneState& scene);

  // Before it renders. `most` bytes are what its state takes.
  void prepare(uint64_t most, RenderJob& job);
  bool wanted() const { return checkpoint_ && checkpoint_->wanted(); }
  void save(RenderJob& job) {
    if (checkpoint_) checkpoint_->save(job);
  }
  // After it has rendered: saves what is to be kept of a frame that is done.
  void rendered(bool stopped, PixelStop cause, RenderJob& job);
  // Once there is a picture. Throws RenderError where what is to be kept is not saved.
  void finish(bool stopped);

 private:
  const RenderOptions& options_;
  std::optional<Checkpoint> checkpoint_;
};

}  // namespace emberline::api
