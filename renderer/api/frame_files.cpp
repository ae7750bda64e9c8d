#include "renderer/api/frame_files.h"

#include <nlohmann/json.hpp>

#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/output/checkpoint_head.h"

namespace emberline::api {
namespace {

nlohmann::json head_of(const RenderOptions& options, const RenderPlan& plan,
                       const FrameParts& parts, const Access::SceneState& scene,
                       const std::stop_token& give_up) {
  LoadProgress progress({}, give_up, scene.limits);
  nlohmann::json inputs = input_fingerprints(options, progress);
  if (scene.edited && !scene.edited->empty()) inputs["the program's edits"] = *scene.edited;
  return checkpoint_head(options, plan, parts.layers, inputs);
}

}  // namespace

FrameFiles::FrameFiles(const RenderOptions& options, const RenderPlan& plan,
                       const FrameParts& parts, const Access::SceneState& scene,
                       const std::stop_token& give_up)
    : options_(options) {
  if (options.checkpoint.empty()) return;
  const CheckpointOptions kept = {.path = options.checkpoint,
                                  .by_tiles = plan.driver->tiles,
                                  .resume = options.resume,
                                  .interval_s = options.checkpoint_interval_s,
                                  .own = false,
                                  .finished = options.extended};
  checkpoint_.emplace(kept, head_of(options, plan, parts, scene, give_up));
}

void FrameFiles::prepare(uint64_t most, RenderJob& job) {
  if (checkpoint_) checkpoint_->begin(job, most);
}

void FrameFiles::rendered(bool stopped, PixelStop cause, RenderJob& job) {
  if (!checkpoint_ || job.by_tiles() || stopped || !keeps_checkpoint(options_)) return;
  job.end(cause);
  checkpoint_->save(job);
}

void FrameFiles::no_picture(bool stopped, RenderJob& job) {
  if (!checkpoint_ || job.by_tiles() || stopped || keeps_checkpoint(options_)) return;
  checkpoint_->save(job);
}

void FrameFiles::finish(bool stopped) {
  if (!checkpoint_) return;
  const bool keep = keeps_checkpoint(options_);
  const CheckpointReport report = checkpoint_->finish(!stopped, stopped || keep);
  if (report.error.empty()) return;
  if (is_part(options_)) throw RenderError(report.error);  // its picture is of no use alone
  if (keep) {
    log_error(report.error);
  } else if (report.kept) {
    log_warning(report.error + "; what is done is not saved");
  }
}

}  // namespace emberline::api
