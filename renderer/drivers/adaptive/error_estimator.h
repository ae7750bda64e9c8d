// Error estimators: film state in, per-pixel error out. Pure functions, one pair of files each.
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

// One entry per pixel of the statistics, in their order.
struct ErrorMap {
  // What is compared with --noise-threshold. For most estimators the expected RMS error of the
  // pixel in display units (sRGB, [0, 1]), root of the mean over the channels; an estimator whose
  // paper measures something else says so in its header. At most the threshold: finished.
  std::vector<float> error;
  // Standard deviation of one sample in the allocation's metric, root of the mean over channels, by
  // which the next samples are shared out. Left empty by the historical estimators, which only say
  // who is not finished yet: those share evenly.
  std::vector<float> deviation;
  // Squared displayed error, summed over pixels and channels, of light that pixels seem to have
  // missed, as their neighbours have met it; no part of `error`. 0 of estimators that do not pool.
  double missed = 0.0;
};

// In what units an error counts: the table behind --allocation, its --help and its error message.
// Each metric weighs a channel's squared error by a function of the channel's value; expected
// errors are sums of weight x variance. The weight is 1 for mse, 1 / (mean^2 + epsilon) for relmse
// (rel_mse_epsilon()), display_error_weight() for display, and for denoised, where the errors are
// those that a filter leaves (denoised_error.h).
std::span<const NamedValue<ErrorMetric>> error_metric_table();

struct EstimatorSettings {
  float threshold = 0.0f;  // --noise-threshold; 0: none
  ErrorMetric allocation = ErrorMetric::kDisplay;
};

// The table of estimators: feeds the planner, --help, the "valid names are" message, the study.
struct EstimatorEntry {
  std::string_view name;
  std::string_view summary;
  // Fills `out` completely; no value is NaN or negative, whatever the statistics hold. A pure
  // function: neither threads nor time enter.
  void (*estimate)(const PixelStatistics& pixels, const EstimatorSettings& settings, ErrorMap* out);
  StreamCount streams = StreamCount::kOne;  // what its estimate needs
  uint32_t first_samples = 0;  // of every pixel, before it is asked; its paper's figure
  uint32_t batch = 0;  // samples that an unfinished pixel gets at a time; 0: shared by deviation
  bool rms_error = false;   // its error is the pixel's expected RMS error as displayed
  bool halves = false;      // the statistics hold halves (SampleHalves) in the place of streams
  bool whole_tree = false;  // the refinement tree asks for the first sample of every pixel
};
std::span<const EstimatorEntry> estimator_table();
const EstimatorEntry& find_estimator(std::string_view name);  // throws UsageError

}  // namespace emberline
