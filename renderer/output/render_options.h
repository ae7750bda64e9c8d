// The options of `emberline render`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/display/display.h"
#include "io/viewer/tev_protocol.h"
#include "renderer/core/vector.h"
#include "renderer/engine/frame_settings.h"
#include "renderer/engine/run_limits.h"
#include "renderer/statistics/heatmap_quantity.h"

namespace emberline {

// The driver that a window begins with, beside those of driver_table(): bisection until every pixel
// has a sample, then adaptive.
inline constexpr const char* kLiveDriver = "live";

struct RenderOptions : FrameSettings {
  std::string command_line;   // for the records
  std::string settings_file;  // that the settings were read from; empty: none

  // Results.
  std::vector<std::string> outputs;
  std::vector<std::string> heatmaps;    // files
  std::vector<std::string> heatmap_of;  // of the n-th; samples if there are fewer
  HeatmapStyle heatmap_style;
  std::vector<std::string> reports;  // .html: a page; any other name: JSON
  std::string snapshots;             // a folder; empty: none
  std::optional<std::string> snapshot_at;
  std::string snapshot_format = "png";
  std::string reference;
  DisplaySettings display;
  std::optional<TevAddress> viewer;   // that watches
  std::optional<std::string> replay;  // X,Y,SAMPLE
  std::optional<Vec2i> explained;     // a pixel of the frame
  std::vector<std::string> trees;     // files of the refinement tree
  std::string save_settings;          // a file; empty: none
  std::string checkpoint;             // a file; empty: checkpoint_path()
  bool resumable = false;             // the checkpoint stays when the frame is done
  bool resume = false;                // goes on with what is there
  double checkpoint_interval_s = 300;
  std::string extended;       // the checkpoint of a frame that goes on; empty: none
  std::string progress_file;  // a file; empty: none
  std::vector<int> frames;    // numbers, in order; empty: one frame, which these options say
  bool skip_existing = false;
  bool stop_on_error = false;  // else the range goes on behind a bad frame
  std::string range_report;    // a file; empty: none
  int threads = 0;             // 0: all
  LimitOptions limits;
};

bool is_part(const FrameSettings& settings);
// The checkpoint stays when the frame is done.
bool keeps_checkpoint(const RenderOptions& options);
// Where the checkpoint is: beside the first output unless it was named. Empty: there is none.
std::string checkpoint_path(const RenderOptions& options);

}  // namespace emberline
