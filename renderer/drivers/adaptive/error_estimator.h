// Error estimators compute each pixel's error from the state of the film. They are pure functions,
// each in its own pair of files.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "renderer/core/display_error.h"
#include "renderer/core/names.h"
#include "renderer/drivers/adaptive/pixel_statistics.h"
#include "renderer/drivers/driver_choices.h"
#include "samplers/sampler.h"

namespace emberline {

// The planes have one entry per pixel, in the order of the statistics.
struct ErrorMap {
  // This error is compared with --noise-threshold: a pixel is finished if its error is at most the
  // threshold. For most estimators this is the expected RMS error of the pixel in display units
  // (sRGB, [0, 1]), as the root mean square over the channels. Where a paper uses another measure,
  // the estimator's header says so.
  std::vector<float> error;
  // Standard deviation of one sample in the allocation's metric, as the root mean square over the
  // channels. The planner uses it to distribute the next samples. It is empty for estimators with
  // EstimatorEntry::batch > 0: these estimators only tell which pixels are unfinished, and every
  // unfinished pixel gets the same number of samples.
  std::vector<float> deviation;
};

// The table of error metrics, used for --allocation, its --help and its error message. A metric
// weights a channel's squared error by a function of the channel's value. The expected error is a
// sum of weight x variance. The weight is 1 for mse, 1 / (mean^2 + epsilon) for relmse
// (rel_mse_epsilon()), and display_error_weight() for display.
std::span<const NamedValue<ErrorMetric>> error_metric_table();

struct EstimatorSettings {
  float threshold = 0.0f;  // --noise-threshold; 0: none
  ErrorMetric allocation = ErrorMetric::kDisplay;
};

// A row of the table of estimators, which the planner, --help, error messages and the study use.
struct EstimatorEntry {
  std::string_view name;
  std::string_view summary;
  // Fills `out` completely. No value is NaN or negative, whatever the statistics hold. This is a
  // pure function, independent of threads and time.
  void (*estimate)(const PixelStatistics& pixels, const EstimatorSettings& settings, ErrorMap* out);
  StreamCount streams = StreamCount::kOne;  // streams that the estimate requires
  uint32_t first_samples = 0;               // samples per pixel before the first estimate
  uint32_t batch = 0;  // samples that an unfinished pixel gets at a time; 0: `deviation` decides
  bool rms_error = false;   // whether `error` is the displayed pixel's expected RMS error
  bool halves = false;      // whether the statistics hold halves (SampleHalves) instead of streams
  bool whole_tree = false;  // whether the refinement tree orders the first samples of all pixels
};
std::span<const EstimatorEntry> estimator_table();
const EstimatorEntry& find_estimator(std::string_view name);  // throws UsageError

}  // namespace emberline
