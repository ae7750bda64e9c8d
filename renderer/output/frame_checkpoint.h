// Decides when a frame's checkpoint is saved and whether the file is kept.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "renderer/engine/render_job.h"
#include "renderer/output/checkpoint.h"
#include "renderer/output/render_options.h"

namespace emberline {

// Until open() is called, all other functions do nothing.
class FrameCheckpoint {
 public:
  explicit FrameCheckpoint(const RenderOptions& options) : options_(options) {}

  // Locks the file that the options name, and resumes from the state in it. The state must not be
  // larger than `max_bytes` bytes. Call before the job renders. `is_default` is the result of
  // is_default_checkpoint(). For `save_now`, see CheckpointOptions. Throws what Checkpoint throws.
  void open(const nlohmann::json& head, bool is_default, const std::function<bool()>& save_now,
            uint64_t max_bytes, RenderJob& job);
  bool is_open() const { return checkpoint_.has_value(); }

  bool is_due() const { return checkpoint_ && checkpoint_->is_due(); }
  void save(RenderJob& job) {
    if (checkpoint_) checkpoint_->save(job);
  }
  // Call after rendering. Saves the frame if it is finished and its checkpoint is to be kept.
  void save_if_retained(bool stopped, PixelStop cause, RenderJob& job);
  // Call if an output could not be written. Saves the frame unless it is already saved.
  void save_if_unwritten(bool stopped, RenderJob& job);
  // Waits until everything is on disk. Keeps the checkpoint if the frame is unfinished, if not all
  // outputs were written, or if the options require it.
  CheckpointReport finish(bool stopped, bool written, RenderJob& job);
  // If the save is incomplete, logs the reason.
  void log_failure(const CheckpointReport& report) const;

 private:
  const RenderOptions& options_;
  std::optional<Checkpoint> checkpoint_;
};

}  // namespace emberline
