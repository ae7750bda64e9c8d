#include "renderer/output/frame_checkpoint.h"

#include <nlohmann/json.hpp>

#include "renderer/core/log.h"

namespace emberline {

void FrameCheckpoint::open(const nlohmann::json& head, bool is_default,
                           const std::function<bool()>& save_now, uint64_t max_bytes,
                           RenderJob& job) {
  const CheckpointOptions kept = {.path = checkpoint_path(options_),
                                  .is_tiled = job.is_tiled(),
                                  .resume = options_.resume,
                                  .interval_s = options_.checkpoint_interval_s,
                                  .is_default = is_default,
                                  .finished = options_.extended,
                                  .save_now = save_now};
  checkpoint_.emplace(kept, head);
  if (options_.resume && options_.extended.empty() && !checkpoint_->is_resumed()) {
    log_info(kept.path + " has nothing to resume; the frame starts over");
  }
  checkpoint_->begin(job, max_bytes);
}

void FrameCheckpoint::save_if_retained(bool stopped, PixelStop cause, RenderJob& job) {
  if (!checkpoint_ || job.is_tiled() || stopped || !retains_checkpoint(options_)) return;
  job.end(cause);
  checkpoint_->save(job);
}

void FrameCheckpoint::save_if_unwritten(bool stopped, RenderJob& job) {
  if (!checkpoint_ || job.is_tiled() || stopped || retains_checkpoint(options_)) return;
  checkpoint_->save(job);
}

CheckpointReport FrameCheckpoint::finish(bool stopped, bool written, RenderJob& job) {
  if (!checkpoint_) return {};
  if (!written) save_if_unwritten(stopped, job);
  const bool done = !stopped && written;
  return checkpoint_->finish(done, !done || retains_checkpoint(options_));
}

void FrameCheckpoint::log_failure(const CheckpointReport& report) const {
  if (report.error.empty()) return;
  if (retains_checkpoint(options_)) {
    log_error(report.error);
  } else if (report.kept) {
    log_warning(report.error + "; the work so far is not saved");
  }
}

}  // namespace emberline
