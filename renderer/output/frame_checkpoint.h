// The checkpoint of a frame on its way: when it is saved, and whether the file stays.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "renderer/engine/render_job.h"
#include "renderer/output/checkpoint.h"
#include "renderer/output/render_options.h"

namespace emberline {

// Until it is open, its functions do nothing.
class FrameCheckpoint {
 public:
  explicit FrameCheckpoint(const RenderOptions& options) : options_(options) {}

  // Takes the file that the options name, before the job renders: it goes on with what is there,
  // whose state is of at most `most` bytes. `own`: is_own_checkpoint(). `save_now` as
  // CheckpointOptions has it. Throws what Checkpoint does.
  void open(const nlohmann::json& head, bool own, const std::function<bool()>& save_now,
            uint64_t most, RenderJob& job);
  bool is_open() const { return checkpoint_.has_value(); }

  bool wanted() const { return checkpoint_ && checkpoint_->wanted(); }
  void save(RenderJob& job) {
    if (checkpoint_) checkpoint_->save(job);
  }
  // After the job has rendered: saves a frame that is done and whose file stays.
  void rendered(bool stopped, PixelStop cause, RenderJob& job);
  // There is no picture, or not in all files: saves the frame, unless that is done already.
  void not_written(bool stopped, RenderJob& job);
  // Waits until all is on the disk. The file stays where there is something to go on with, a frame
  // that is not done or not written, and where the options say so.
  CheckpointReport finish(bool stopped, bool written, RenderJob& job);
  // Says in the log why not all is saved that was to be.
  void log_failure(const CheckpointReport& report) const;

 private:
  const RenderOptions& options_;
  std::optional<Checkpoint> checkpoint_;
};

}  // namespace emberline
