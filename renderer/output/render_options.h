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

// The window's default driver, which uses bisection until every pixel has a sample, and then
// adaptive sampling. It is not in driver_table().
inline constexpr const char* kLiveDriver = "live";

struct RenderOptions : FrameSettings {
  std::string command_line;   // recorded in outputs
  std::string settings_file;  // source of the settings; empty: none

  std::vector<std::string> outputs;
  std::vector<std::string> heatmaps;    // file paths
  std::vector<std::string> heatmap_of;  // quantity of the n-th heatmap; default: samples
  HeatmapStyle heatmap_style;
  std::vector<std::string> reports;  // .html: a page; other suffixes: JSON
  std::string snapshots;             // folder; empty: none
  std::optional<std::string> snapshot_at;
  std::string snapshot_format = "png";
  std::string reference;
  DisplaySettings display;
  std::optional<TevAddress> viewer;   // receives the frame while it renders
  std::optional<std::string> replay;  // X,Y,SAMPLE
  std::optional<Vec2i> explained;     // pixel of the frame
  std::vector<std::string> trees;     // refinement tree files
  std::string save_settings;          // file; empty: none
  std::string checkpoint;             // file; empty: checkpoint_path()
  bool resumable = false;             // keep the checkpoint after the frame is done
  bool resume = false;                // resume from a checkpoint if there is one
  double checkpoint_interval_s = 300;
  std::string extended;       // checkpoint of the frame to extend; empty: none
  std::string progress_file;  // file; empty: none
  std::vector<int> frames;    // frame numbers, in order; empty: a single frame
  int across = 0;             // neighbours on each side that denoising uses
  bool skip_existing = false;
  bool strict = false;         // fail if a time limit leaves pixels black
  bool stop_on_error = false;  // default: the range continues after a failed frame
  std::string range_report;    // file; empty: none
  int threads = 0;             // 0: all cores
  LimitOptions limits;
};

bool is_part(const FrameSettings& settings);
// Whether the checkpoint is kept when the frame is done.
bool retains_checkpoint(const RenderOptions& options);
// Returns the path of the checkpoint, which is beside the first output unless the options name
// another path. Returns "" if there is no checkpoint.
std::string checkpoint_path(const RenderOptions& options);

}  // namespace emberline
