// A sample plan: a file with the sample count of each pixel of a frame. `emberline plan` writes it,
// and the setting `plan` names it. The setting can also name a finished frame (.exr), whose channel
// `samples` has the counts.
//
// A plan is a record file (io/files/record_file.h). Its head is that of a checkpoint
// (checkpoint_head.h) with one more member in "settings", which marks the file as a plan. Its
// records are those of a frame with one film (checkpoint.h), and hold the counts: one u32 per pixel
// of the crop, in rows from the top.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "io/json/value.h"
#include "renderer/core/load_progress.h"
#include "renderer/core/memory_budget.h"
#include "renderer/drivers/sample_plan.h"
#include "renderer/output/render_options.h"

namespace emberline {

// Throws UsageError if the path is not writable or names a file that is not a plan.
void check_plan_output(const std::string& path);

// Writes a plan. `head` is the checkpoint_head() of the planned frame. Throws RenderError.
void write_sample_plan(const std::string& path, const nlohmann::json& head, const SamplePlan& plan);

class SamplePlanFile {
 public:
  // Reads the file that the options name, and reserves the memory of the counts. Throws InputError
  // if the file is not a plan, is damaged, exceeds the limits, or was made for a frame of another
  // size or for other pixels. If the file is a finished frame, also throws InputError if a setting
  // that defines its samples differs.
  SamplePlanFile(const RenderOptions& options, const LoadLimits& limits);

  const std::shared_ptr<const SamplePlan>& plan() const { return plan_; }
  // Throws an InputError that lists the differences if the plan was made for a frame other than the
  // one with the head `now`. The frame may be a crop or a part of the planned frame, and may have
  // other channels. Does nothing if the file is a finished frame, which has no head.
  void check(const nlohmann::json& now) const;

 private:
  void read_plan(const RenderOptions& options, const LoadLimits& limits);
  void read_picture(const RenderOptions& options, const LoadLimits& limits);
  std::shared_ptr<SamplePlan> reserve_counts(const RenderOptions& options, const Rect& crop,
                                             int width, int height, const LoadLimits& limits);
  void check_counts(const SamplePlan& plan) const;

  const std::string path_;
  JsonValue head_;  // null if the counts are those of a finished frame
  MemoryReservation memory_;
  std::shared_ptr<const SamplePlan> plan_;
};

}  // namespace emberline
