// What a study of speed against error found: plain data, written once by `emberline study` and read
// by whatever sums it up (study_summary.h), draws it or writes it down.
//
// A study renders one view of one scene by several methods, each with several seeds, and measures
// the picture at several checkpoints of each run against a reference. Times are of rendering alone:
// loading, building, and the copying and measuring of pictures are left out, denoising is not.
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

// How far a picture is from the reference; reference_error.h says how each is measured. Means are
// over pixels and channels.
struct StudyError {
  double mse = 0;              // of linear radiance
  double rel_mse = 0;          // over (r^2 + epsilon), as error_metrics.h has it
  double rel_mse_trimmed = 0;  // without the worst 0.1 % of pixels
  double display_mse = 0;      // of display values (sRGB, 0 to 1)
  double flip = 0;             // mean FLIP; the reference's own noise is in it
  double signed_bias = 0;      // sum(x - r) / sum(r)
  double p95_absolute = 0;     // 95th percentile over pixels of the RMS over channels of x - r
  double p95_display = 0;      // the same of display values
};

// The errors that fall as a frame gets more samples, for tables, axes and options.
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
  std::string_view name;  // of the column
  std::string_view summary;
  StudyMetric metric;
  double StudyError::*value;
  // A mean of squares, which falls as 1 / N with independent samples; else as 1 / sqrt(N).
  bool squared;
};
std::span<const StudyMetricEntry> study_metric_table();  // in the order of StudyMetric
const StudyMetricEntry& study_metric_entry(StudyMetric metric);

// A way to render the frame.
struct StudyMethod {
  std::string name;  // "bucket", "adaptive/two-stream"; with several samplers "bucket/sobol"
  std::string driver, sampler;
  std::string estimator, allocation;  // of adaptive drivers, else empty
  bool unbiased = false;
  bool denoised = false;  // its pictures are
  // Of the first seed at the largest budget; names of files in the study's folder, empty where
  // there is none. The EXR has R G B A and `samples`, the FLIP picture is against the reference.
  struct Pictures {
    std::string exr, png, flip_png;
    uint32_t seed = 0;
    double mean_samples = 0, wall_s = 0;  // what it took
  } pictures;
};

// What denoising took, and did not change.
struct StudyFilter {
  double cpu_s = 0;
  double kept_share = 0;  // of the pixels, left as they were
};

// A moment of a run: the first at which the frame could be looked at and its budget was spent.
struct StudyCheckpoint {
  double budget = 0;        // one of StudySettings::budgets
  uint64_t samples = 0;     // of the frame
  double mean_samples = 0;  // of a pixel
  double wall_s = 0;        // of rendering
  double cpu_s = 0;         // of all threads, in that time
  StudyError error;
  // The expected RMS error of the displayed picture that the driver, or the filter, claims for this
  // very picture.
  std::optional<double> estimate;
  std::optional<StudyFilter> filter;  // of a denoised picture; its time is in the times above
};

// What the driver claimed of its picture between two rounds, and what was true.
struct CalibrationPoint {
  double mean_samples = 0;  // of a pixel
  double estimate = 0;      // RMS error of the displayed picture
  double true_rms = 0;      // root of StudyError::display_mse; NaN where that is not positive
};

enum class StudyRunStatus : uint8_t { kDone, kFailed };

struct StudyRun {
  size_t method = 0;  // of StudyResults::methods
  uint32_t seed = 0;
  StudyRunStatus status = StudyRunStatus::kDone;
  std::string reason;                        // of a failure, one line
  std::vector<StudyCheckpoint> checkpoints;  // by budget, ascending; none if it failed
  std::vector<CalibrationPoint> calibration;
  uint64_t non_finite_samples = 0;  // that were NaN or infinite, and count as black
};

struct StudyReference {
  std::string file;                // given with --reference; empty: made by the study
  std::string driver, sampler;     // of one that was made
  uint32_t samples_per_pixel = 0;  // of both halves together; 0 if not known
  std::array<uint32_t, 2> seeds = {};
  bool two_halves = false;  // its noise is taken out of mean squares
  // Of the mean of the halves, as far as they show it.
  double noise_mse = 0, noise_rel_mse = 0, noise_display_mse = 0, noise_bias = 0;
  double rel_mse_epsilon = 0;
  std::string exr, png;  // of the mean of the halves, in the study's folder
};

// How much less time any sharing-out of samples could need than the even one, for equal error, if
// samples were independent: mean(v) mean(c) / mean(sqrt(v c))^2 with v the variance of a pixel's
// sample in the metric and c its cost (Neyman 1934; neyman_limit.h). At least 1.
struct NeymanLimits {
  double mse = 0, rel_mse = 0, display = 0;
};

struct StudySettings {
  std::string scene;
  std::string command_line;   // repeats the study
  int width = 0, height = 0;  // of the picture
  // View, light, depth and so on, by option, for people.
  std::vector<std::pair<std::string, std::string>> frame;
  bool by_time = false;         // budgets are seconds of rendering, else samples per pixel
  std::vector<double> budgets;  // ascending
  uint32_t first_seed = 0, seeds = 0;
  int threads = 0;
  std::string baseline;  // a method's name
  std::vector<std::pair<std::string, std::string>> versions;
};

struct StudyResults {
  StudySettings settings;
  StudyReference reference;
  std::optional<NeymanLimits> limits;  // unless the reference was given
  std::vector<StudyMethod> methods;
  std::vector<StudyRun> runs;  // by seed, then method; those that were not begun are not there
  bool complete = true;        // false: stopped before all runs had been made
};

}  // namespace emberline
