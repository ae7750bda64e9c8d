// report.json: how long a render took, how much memory it used, and what it counted.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "renderer/description/scene_description.h"
#include "renderer/drivers/frame.h"
#include "renderer/output/checkpoint.h"
#include "renderer/output/cryptomatte_layers.h"
#include "renderer/output/denoise_pass.h"
#include "renderer/output/render_options.h"
#include "renderer/output/snapshots.h"
#include "renderer/scene/scene.h"

namespace emberline {

struct RenderTimes {
  // wall_s is the wall time from the start of the command until the command writes its reports. The
  // other times are phases of wall_s; they add up to more than 98 % of it. The setup phase reads
  // the options and --reference, and opens the outputs.
  double wall_s = 0, setup_s = 0, load_s = 0, build_s = 0, render_s = 0, write_s = 0;
  double snapshots_s = 0;  // copying (not in render_s), encoding and measuring snapshots
  // Time from the start of the process until wall_s begins. In this time, the process and its
  // libraries are loaded.
  std::optional<double> start_s;
  double cpu_s = 0;         // CPU time of the process
  double render_cpu_s = 0;  // CPU time during render_s
  // Time until a worker has finished its first 2048 samples, which take about a millisecond. For
  // the first frame, the time starts with the process (before libraries are loaded). For later
  // frames of a range, it starts with the frame. Absent if no samples were taken.
  std::optional<double> first_sample_s, first_sample_cpu_s;
};

struct PassReport {
  double elapsed_s = 0;                  // render time so far
  uint64_t samples = 0;                  // number so far
  std::optional<double> error_estimate;  // of the picture at the end of this pass
};

// A prediction about an adaptive frame, made soon after its pilot. Most frames end within the
// interval (tests/bench/results/adaptive.md).
struct ForecastReport {
  double after_s = 0;              // render time at which it was made
  double seconds = 0;              // render time of the whole frame
  double least_s = 0, most_s = 0;  // interval
  double samples_per_pixel = 0;    // at the end of the frame
};

struct PartReport {
  std::string file, host, instruction_sets;
};

struct RenderReport {
  RenderTimes times;
  RenderCounters counters;
  SceneMemory memory;
  uint64_t unsampled_pixels = 0;  // in the crop or, if only a part is rendered, in the part
  uint64_t film_bytes = 0;
  std::shared_ptr<const MemoryBudget> budget;  // the limit and what was reserved
  std::vector<std::string> features;
  std::string estimator = "none";
  std::optional<double> error_estimate;
  std::optional<DenoiseReport> denoise;
  std::vector<std::string> warnings;  // as shown to the user, in order
  CoverageReport coverage;
  LoadRepairs repairs;
  std::vector<std::string> light_layers;  // names, with --light-groups
  std::vector<CryptomatteReport> cryptomattes;
  std::string camera;
  std::string display;
  Rect crop;
  int threads = 0;
  std::vector<PassReport> passes;
  std::optional<ForecastReport> forecast;
  std::vector<SnapshotReport> snapshots;
  uint64_t resumed_samples = 0;  // samples from the checkpoint, included in the total
  CheckpointReport checkpoint;
  std::vector<PartReport> parts;
  PixelStop stop_cause = PixelStop::kNone;
  std::vector<std::string> failed_outputs;  // files that could not be written, except reports
  bool complete = true;                     // the frame has no holes and was not stopped
  int exit_code = 0;
};

// Returns an object with the keys time, samples, rays, memory, numerics, error, features, gltf,
// passes, settings, versions, output and others.
std::string report_json(const RenderOptions& options, const RenderReport& report);

// Returns the --replay arguments that recompute the sample. Adds --seed if a frame with these
// settings would use another seed than the sample.
std::string replay_arguments(const NonFiniteSample& sample, const FrameSettings& settings);

// If some samples were not finite, warns and says how to replay the first of them. In the message,
// `how` comes before `replay`. It is "with" and any further options that the replay needs.
void warn_about_non_finite(const RenderCounters& counters, const FrameSettings& settings,
                           const std::string& how = "with");

// Fills in the defaults that a frame uses, so that its reports and headers record them.
FrameSettings with_recorded_defaults(FrameSettings settings);
// Returns the settings, including the seed, and the versions as texts, for the attributes of EXR
// headers.
std::vector<std::pair<std::string, std::string>> settings_attributes(const RenderOptions& options);

// Returns the versions of the libraries in use, such as {"embree", "3.13.5"}.
std::vector<std::pair<std::string, std::string>> library_versions();
// Returns the instruction set for which this binary was compiled and the widest instruction set
// that Embree uses on this machine, for example "x86-64-v3, Embree avx2".
std::string instruction_sets();
// Returns "Intel", "AMD", "ARM" or "other". Embree's reciprocals round differently on processors of
// different makers.
std::string processor_maker();

}  // namespace emberline
