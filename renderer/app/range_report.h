// Outcomes of the frames of a range.
#pragma once

#include <string>
#include <vector>

#include "renderer/output/render_options.h"
#include "renderer/output/report.h"

namespace emberline {

enum class FrameFate : uint8_t { kDone, kSkipped, kStopped, kFailed };

struct FrameOutcome {
  int frame = 0;
  FrameFate fate = FrameFate::kDone;
  int exit_code = 0;
  std::string error;                 // that ended it; else empty
  std::vector<std::string> outputs;  // pictures
  std::vector<std::string> failed_outputs;
  RenderTimes times;
  uint64_t samples = 0, rays = 0;
};

struct RangeReport {
  std::vector<FrameOutcome> frames;  // those that were reached, in order
  std::vector<int> left;             // the others
  double wall_s = 0, cpu_s = 0;
  int exit_code = 0;

  std::vector<int> of_fate(FrameFate fate) const;
};

// A line for the log: "97 frames rendered, 2 skipped, 1 failed: 37".
std::string describe(const RangeReport& report);
// --range-report: {"frames": [{"frame", "state", ...}], "done", "skipped", "stopped", "failed",
// "left", "time", "settings", "machine", "versions", "exit_code"}; lists of frames as --frames
// takes them.
std::string range_report_json(const RenderOptions& options, const RangeReport& report);

}  // namespace emberline
