// What `emberline render` is told.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/display.h"
#include "io/tev_protocol.h"
#include "renderer/app/run_limits.h"
#include "renderer/core/rect.h"
#include "renderer/core/vector.h"
#include "renderer/statistics/heatmap_quantity.h"

namespace emberline {

// The most samples of a pixel. The film's sums are exact beyond it, and the `samples` channel, a
// float on its way to the file, counts to 2^24 exactly.
inline constexpr uint32_t kMaxSamples = 1u << 24;

// The driver that a window begins with, beside those of driver_table(): bisection until every pixel
// has a sample, then adaptive.
inline constexpr const char* kLiveDriver = "live";

struct RenderOptions {
  std::string scene;
  std::string resource_root;  // what the scene may refer to; empty: its own folder
  std::string edits;          // a file of them; empty: none
  std::string variant;        // name or index; empty: the file's own materials
  std::vector<std::string> outputs;
  std::string command_line;  // for the records

  // Schedule and estimator.
  std::string driver = "bucket";
  std::string integrator = "path";
  std::string sampler = "sobol";
  std::string filter;  // one of filter_table()
  std::optional<float> filter_radius;
  std::optional<uint32_t> spp;  // 64, if nothing else limits the samples
  std::optional<uint32_t> min_spp, max_spp;
  std::optional<float> noise_threshold;
  std::string estimator;   // one of estimator_table()
  std::string allocation;  // one of error_metric_table()
  bool unbiased = false;
  std::optional<double> time_limit_s;
  int max_depth = 16;
  uint32_t seed = 0;
  std::optional<int> streams;  // 1, or what the estimator needs
  int bucket_size = 64;
  std::string bucket_order = "hilbert";
  std::string bisection_axis = "both";
  std::string reconstruction = "duplicate";

  // Frame and view.
  int width = 1280, height = 720;
  std::optional<Rect> crop;
  std::string camera;  // name or index; empty: the file's first, or one that frames the scene
  std::optional<Vec3d> look_from, look_at;
  std::optional<double> fov_y;                   // degrees
  std::optional<double> f_stop, focus_distance;  // metres; absent: a pinhole

  // Surroundings.
  std::string environment;
  float environment_strength = 1.0f;
  float environment_rotation = 0.0f;
  bool transparent = false;
  bool show_backfaces = false;
  bool lenient = false;

  // Results.
  std::string aovs;
  bool light_groups = false;            // layers of the EXR
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
  int threads = 0;                    // 0: all
  LimitOptions limits;
};

}  // namespace emberline
