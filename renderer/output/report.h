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
  // Wall time from the command's beginning until its reports are written, and its parts; what they
  // leave is less than 2 % of it. setup: reading options and --reference, opening the outputs.
  double wall_s = 0, setup_s = 0, load_s = 0, build_s = 0, render_s = 0, write_s = 0;
  double snapshots_s = 0;  // copying them, which render_s leaves out, and encoding and measuring
  // Before wall_s: from the start of the process, the loading of its libraries.
  std::optional<double> start_s;
  double cpu_s = 0;         // processor time of the process
  double render_cpu_s = 0;  // processor time of the render_s
  // From the start of the process (loading the program's libraries included) until the first
  // samples were done: one worker's first 2048, about a millisecond. Absent if none ever were.
  std::optional<double> first_sample_s, first_sample_cpu_s;
};

// One pass over the frame.
struct PassReport {
  double elapsed_s = 0;                  // since rendering began
  uint64_t samples = 0;                  // so far
  std::optional<double> error_estimate;  // of the picture at the end of this pass
};

// A part of a merged frame.
struct PartReport {
  std::string file, host, instruction_sets;
};

struct RenderReport {
  RenderTimes times;
  RenderCounters counters;
  SceneMemory memory;
  uint64_t film_bytes = 0;
  std::shared_ptr<const MemoryBudget> budget;  // what was allowed, and reserved of it
  std::vector<std::string> features;
  std::string estimator = "none";
  std::optional<double> error_estimate;
  std::optional<DenoiseReport> denoise;
  std::vector<std::string> warnings;  // as given to the user, in order
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
  uint64_t earlier_samples = 0;  // of the total, that the checkpoint had
  CheckpointReport checkpoint;
  std::vector<PartReport> parts;
  PixelStop stop_cause = PixelStop::kNone;
  std::vector<std::string> failed_outputs;  // files that could not be written; reports aside
  bool complete = true;                     // the frame has no holes and was not stopped
  int exit_code = 0;
};

// The keys are those of the design: time, samples, rays, memory, numerics, error, features, gltf,
// passes; beside them settings, versions and output.
std::string report_json(const RenderOptions& options, const RenderReport& report);

// The words after --replay that compute the sample again: with --seed where it is not `seed`.
std::string replay_words(const NonFiniteSample& sample, uint32_t seed);

// Nothing where all samples were finite. `how`: "with", and options without which render would not
// meet the first of them again.
void warn_of_non_finite(const RenderCounters& counters, uint32_t seed,
                        const std::string& how = "with");

// The settings with what a frame takes where they say nothing, as its records have them.
FrameSettings recorded_settings(FrameSettings settings);
// Settings, versions and seed as strings: the EXR's header attributes.
std::vector<std::pair<std::string, std::string>> settings_attributes(const RenderOptions& options);

// "embree" -> "3.13.5" and so on, for what this binary runs with.
std::vector<std::pair<std::string, std::string>> library_versions();
// What this binary was compiled for, and the widest that Embree uses on this machine: "x86-64-v3,
// Embree avx2".
std::string instruction_sets();
// "Intel", "AMD", "ARM" or "other". Makers round Embree's reciprocals in ways of their own.
std::string processor_maker();

}  // namespace emberline
