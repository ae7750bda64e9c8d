// What became of the frames of a range: --range-report.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "renderer/output/render_options.h"
#include "renderer/output/report.h"

namespace emberline {

enum class FrameStatus : uint8_t { kDone, kSkipped, kStopped, kFailed };

struct FrameOutcome {
  int frame = 0;
  FrameStatus status = FrameStatus::kDone;
  int exit_code = 0;
  std::string error;                 // empty unless an error ended the frame
  std::vector<std::string> outputs;  // pictures
  std::vector<std::string> failed_outputs;
  RenderTimes times;
  uint64_t samples = 0, rays = 0;
};

struct RangeReport {
  std::vector<FrameOutcome> frames;  // the frames that were begun or skipped, in order
  std::vector<int> remaining;        // frames that were neither begun nor skipped
  double wall_s = 0, cpu_s = 0;
  int exit_code = 0;

  std::vector<int> frames_with_status(FrameStatus status) const;
};

// Returns text for the log, such as "frames: 97 rendered, 2 skipped, 1 failed (37)".
std::string describe(const RangeReport& report);

// Returns {"frames": [{"frame", "state", ...}], "done", "skipped", "stopped", "failed", "left",
// "time", "settings", "machine", "versions", "exit_code"}. Lists of frames have the syntax of
// --frames.
std::string range_report_json(const RenderOptions& options, const RangeReport& report);

// Returns a self-contained HTML file with an animation, charts and a table of the frames. The
// animation is made from the .exr files, if there are any and the range was not stopped.
std::string range_report_page(const RenderOptions& options, const RangeReport& report);

}  // namespace emberline
