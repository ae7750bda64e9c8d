// The results of a study of speed against error, as plain data. `emberline study` produces these
// results. Other code summarizes (study_summary.h), draws or saves them.
//
// A study renders one view of one scene by several methods, each with several seeds. At several
// checkpoints of each run, it compares the picture with a reference. Times include rendering and
// denoising, but not loading and building the scene or copying and measuring pictures.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace emberline {

// Errors of a picture against the reference, as defined in reference_error.h. Means are over pixels
// and channels.
struct StudyError {
  double mse = 0;              // of linear radiance
  double rel_mse = 0;          // over (r^2 + epsilon), as in error_metrics.h
  double rel_mse_trimmed = 0;  // without the worst 0.1 % of pixels
  double display_mse = 0;      // of display values (sRGB, 0 to 1)
  double flip = 0;             // mean FLIP; includes the noise of the reference
  double signed_bias = 0;      // sum(x - r) / sum(r)
  double p95_absolute = 0;     // 95th percentile over pixels of sqrt(mean((x - r)^2))
  double p95_display = 0;      // like p95_absolute, for display values
};

// The errors in StudyError that decrease with more samples. Tables, axes and options use these.
enum class StudyMetric : uint8_t {
  kMse,
  kRelMse,
  kRelMseTrimmed,
  kDisplay,
  kFlip,
  kP95Absolute,
  kP95Display
};
struct StudyMetricEntry {
  std::string_view name;  // column name
  std::string_view summary;
  StudyMetric metric;
  double StudyError::*value;
  // Whether the metric is a mean of squares. With N independent samples, such metrics fall as 1 /
  // N, and others as 1 / sqrt(N).
  bool squared;
};
std::span<const StudyMetricEntry> study_metric_table();  // in the order of StudyMetric
const StudyMetricEntry& study_metric_entry(StudyMetric metric);

// A way to render the frame.
struct StudyMethod {
  std::string name;  // such as "adaptive/two-stream" or, with several samplers, "bucket/sobol"
  std::string driver, sampler;
  std::string estimator, allocation;  // for adaptive drivers, otherwise empty
  bool unbiased = false;
  bool planned = false;   // a pilot decided the sample counts; samples and times include it
  bool denoised = false;  // whether its pictures are denoised
  // Names of the picture files, relative to the study's folder; empty if there is no picture. The
  // pictures come from the first seed and the largest budget. The EXR has the channels R, G, B, A
  // and `samples`. The FLIP picture shows the difference from the reference.
  struct Pictures {
    std::string exr, png, flip_png;
    uint32_t seed = 0;
    double mean_samples = 0, wall_s = 0;  // of the frame shown
  } pictures;
};

// The cost of denoising, and the fraction of pixels that denoising left unchanged.
struct StudyFilter {
  double cpu_s = 0;
  double unchanged_fraction = 0;  // of the pixels
};

// A checkpoint of a run: the first moment at which the budget is spent and a picture is available.
struct StudyCheckpoint {
  double budget = 0;        // one of StudySettings::budgets
  uint64_t samples = 0;     // of the whole frame
  double mean_samples = 0;  // per pixel
  double wall_s = 0;        // of rendering
  double cpu_s = 0;         // of all threads together, during wall_s
  StudyError error;
  // The estimated RMS error of the displayed picture. The driver estimates it; for a denoised
  // picture, the denoiser does.
  std::optional<double> estimate;
  std::optional<StudyFilter> filter;  // for a denoised picture; wall_s and cpu_s include it
};

// The driver's estimate of a picture's error, and the picture's true error. The picture was taken
// after a round or at the end.
struct CalibrationPoint {
  double mean_samples = 0;  // per pixel
  double estimate = 0;      // RMS error of the displayed picture
  double true_rms = 0;      // square root of StudyError::display_mse; NaN if that is not positive
};

enum class StudyRunStatus : uint8_t { kDone, kFailed };

struct StudyRun {
  size_t method = 0;  // index in StudyResults::methods
  uint32_t seed = 0;
  StudyRunStatus status = StudyRunStatus::kDone;
  std::string reason;                        // one line, for a failed run
  std::vector<StudyCheckpoint> checkpoints;  // by budget, ascending; empty for a failed run
  std::vector<CalibrationPoint> calibration;
  uint64_t non_finite_samples = 0;  // NaN or infinite samples, counted as black
};

struct StudyReference {
  std::string file;                // from --reference; empty: rendered by the study
  std::string driver, sampler;     // if rendered by the study
  uint32_t samples_per_pixel = 0;  // of both halves together; 0 if unknown
  std::array<uint32_t, 2> seeds = {};
  bool two_halves = false;  // if true, mean squared errors exclude the reference's noise
  // The noise in the mean of the halves, estimated from the difference between the halves.
  double noise_mse = 0, noise_rel_mse = 0, noise_display_mse = 0, noise_bias = 0;
  double rel_mse_epsilon = 0;
  std::string exr, png;  // of the mean of the halves, in the study's folder
};

// The largest possible speedup, at the same error, over a render that gives every pixel the same
// number of samples. It is mean(v) mean(c) / mean(sqrt(v c))^2, where v is the variance of one
// sample of a pixel in the metric and c is the cost of this sample (Neyman 1934; neyman_limit.h).
// It assumes independent samples and is at least 1.
struct NeymanLimits {
  double mse = 0, rel_mse = 0, display = 0;
};

struct StudySettings {
  std::string scene;
  std::string command_line;   // repeats the study
  int width = 0, height = 0;  // of the picture
  // Settings of the view, light, path depth and so on, by option name, for display.
  std::vector<std::pair<std::string, std::string>> frame;
  bool by_time = false;         // budgets are seconds of rendering; false: samples per pixel
  std::vector<double> budgets;  // ascending
  uint32_t first_seed = 0, seeds = 0;
  int threads = 0;
  std::string baseline;  // name of a method
  std::vector<std::pair<std::string, std::string>> versions;
};

struct StudyResults {
  StudySettings settings;
  StudyReference reference;
  std::optional<NeymanLimits> limits;  // absent if the user gave the reference
  std::vector<StudyMethod> methods;
  std::vector<StudyRun> runs;  // sorted by seed, then method; only runs that were started
  bool complete = true;        // false: stopped before all runs had finished
};

}  // namespace emberline
