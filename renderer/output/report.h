// report.json: what a render did, in seconds, bytes and counts.
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
  // Wall time from the start of the command until its reports are written, and its parts, which
  // leave less than 2 % unaccounted for. setup: reading options and --reference, opening the
  // outputs.
  double wall_s = 0, setup_s = 0, load_s = 0, build_s = 0, render_s = 0, write_s = 0;
  double snapshots_s = 0;  // copying (not in render_s), encoding and measuring snapshots
  // Before wall_s: loading the process and its libraries.
  std::optional<double> start_s;
  double cpu_s = 0;         // CPU time of the process
  double render_cpu_s = 0;  // CPU time during render_s
  // From process start (library loading included) to the first samples: one worker's first 2048,
  // about a millisecond. Absent if no samples were taken.
  std::optional<double> first_sample_s, first_sample_cpu_s;
};

struct PassReport {
  double elapsed_s = 0;                  // since rendering began
  uint64_t samples = 0;                  // so far
  std::optional<double> error_estimate;  // of the picture at the end of this pass
};

struct PartReport {
  std::string file, host, instruction_sets;
};

struct RenderReport {
  RenderTimes times;
  RenderCounters counters;
  SceneMemory memory;
  uint64_t unsampled_pixels = 0;  // of the crop, or of this part of it
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
  std::vector<SnapshotReport> snapshots;
  uint64_t resumed_samples = 0;  // samples from the checkpoint, included in the total
  CheckpointReport checkpoint;
  std::vector<PartReport> parts;
  PixelStop stop_cause = PixelStop::kNone;
  std::vector<std::string> failed_outputs;  // files that could not be written, except reports
  bool complete = true;                     // the frame has no holes and was not stopped
  int exit_code = 0;
};

// Keys: time, samples, rays, memory, numerics, error, features, gltf, passes, settings, versions,
// output and others.
std::string report_json(const RenderOptions& options, const RenderReport& report);

// Arguments for --replay that recompute the sample, with --seed if it differs from `seed`.
std::string replay_arguments(const NonFiniteSample& sample, uint32_t seed);

// Warns unless all samples were finite. `how`: "with", plus the options needed to reproduce the
// first one.
void warn_about_non_finite(const RenderCounters& counters, uint32_t seed,
                           const std::string& how = "with");

// Fills in the defaults that a frame uses, as its records show them.
FrameSettings with_recorded_defaults(FrameSettings settings);
// Settings, versions and seed as strings, for EXR header attributes.
std::vector<std::pair<std::string, std::string>> settings_attributes(const RenderOptions& options);

// Versions of the libraries in use, such as {"embree", "3.13.5"}.
std::vector<std::pair<std::string, std::string>> library_versions();
// The instruction set this binary was compiled for and the widest that Embree uses here, for
// example "x86-64-v3, Embree avx2".
std::string instruction_sets();
// "Intel", "AMD", "ARM" or "other". Embree's reciprocals round differently between makers.
std::string processor_maker();

}  // namespace emberline
