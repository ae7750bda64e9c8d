#include "renderer/app/sampling_plan.h"

#include <fmt/format.h>

#include "renderer/core/errors.h"

namespace emberline {
namespace {

constexpr uint32_t kDefaultSamples = 64;
// Where a threshold alone is given, a pixel that never meets it ends somewhere.
constexpr uint32_t kDefaultMostSamples = 4096;

// Options that only mean something to adaptive sampling.
void refuse_adaptive_options(const RenderOptions& o, const std::string& reason) {
  const auto refuse = [&](const char* option) {
    throw UsageError(std::string(option) + ": " + reason);
  };
  if (o.noise_threshold) refuse("--noise-threshold");
  if (o.min_spp) refuse("--min-spp");
  if (o.max_spp) refuse("--max-spp");
  if (!o.estimator.empty()) refuse("--estimator");
  if (!o.allocation.empty()) refuse("--allocation");
  if (o.unbiased) refuse("--unbiased");
}

// A sampler that has to know a pixel's count beforehand is of no use where the noise decides it.
void refuse_fixed_counts(const std::string& sampler) {
  std::string valid;
  bool refused = false;
  for (const SamplerEntry& entry : sampler_table()) {
    if (entry.counts == SampleCounts::kAny) {
      valid += (valid.empty() ? "" : ", ") + std::string(entry.name);
    } else if (entry.name == sampler) {
      refused = true;
    }
  }
  if (!refused) return;
  throw UsageError("--sampler: " + sampler +
                   " needs to know each pixel's number of samples beforehand, which adaptive "
                   "sampling does not; valid names are " +
                   valid);
}

// The estimators that say how much a sample would bring, and not only which pixels are finished.
std::string sharing_estimators() {
  std::string names;
  for (const EstimatorEntry& entry : estimator_table()) {
    if (entry.batch == 0) names += (names.empty() ? "" : ", ") + std::string(entry.name);
  }
  return names;
}

}  // namespace

SamplingPlan plan_sampling(const RenderOptions& o) {
  SamplingPlan plan;
  plan.uniform = o.driver != "adaptive" && !(o.driver == "bucket" && o.noise_threshold);
  if (plan.uniform) {
    refuse_adaptive_options(
        o, o.driver == "bucket"
               ? "without --noise-threshold the bucket driver gives every pixel --spp samples; "
                 "give a threshold, or --driver adaptive"
               : fmt::format("the {} driver gives every pixel --spp samples; valid with --driver "
                             "adaptive, or bucket with --noise-threshold",
                             o.driver));
    plan.samples_per_pixel = o.spp.value_or(kDefaultSamples);
    plan.streams = static_cast<StreamCount>(o.streams.value_or(1));
    return plan;
  }
  refuse_fixed_counts(o.sampler);
  AdaptiveSettings& a = plan.adaptive;
  a.estimator = o.estimator.empty() ? kDefaultEstimator : std::string_view(o.estimator);
  const EstimatorEntry& estimator = find_estimator(a.estimator);
  if (!o.allocation.empty()) {
    a.allocation = parse_error_metric(o.allocation);
    if (estimator.batch > 0) {
      throw UsageError(fmt::format(
          "--allocation: the estimator {} only tells which pixels are finished, and the others "
          "share evenly; valid with {}",
          estimator.name, sharing_estimators()));
    }
  }
  plan.streams = estimator.streams;
  if (o.streams && static_cast<StreamCount>(*o.streams) < estimator.streams) {
    throw UsageError(
        fmt::format("--streams {}: the estimator {} compares two sample streams; leave --streams "
                    "out, or give 2",
                    *o.streams, estimator.name));
  }
  if (o.streams) plan.streams = static_cast<StreamCount>(*o.streams);
  a.threshold = o.noise_threshold.value_or(0.0f);
  a.min_samples = o.min_spp.value_or(0);
  a.max_samples = o.max_spp.value_or(0);
  a.unbiased = o.unbiased;
  if (o.unbiased && estimator.batch > 0) {
    throw UsageError(fmt::format(
        "--unbiased: every pixel must take part in every round, and the estimator {} leaves the "
        "finished ones out; valid with {}",
        estimator.name, sharing_estimators()));
  }
  if (o.unbiased && o.max_spp) {
    throw UsageError(
        "--unbiased: every pixel must take part in every round, which --max-spp "
        "forbids; leave it out, --spp limits the frame");
  }
  if (o.min_spp && o.max_spp && *o.min_spp > *o.max_spp) {
    throw UsageError(fmt::format("--min-spp {} is above --max-spp {}; valid is 1 to {}", *o.min_spp,
                                 *o.max_spp, *o.max_spp));
  }
  if (o.min_spp && o.spp && *o.min_spp > *o.spp) {
    throw UsageError(fmt::format("--min-spp {} is above the average of --spp {}; valid is 1 to {}",
                                 *o.min_spp, *o.spp, *o.spp));
  }
  if (o.spp) {
    a.budget = *o.spp;
  } else if (o.unbiased || (a.threshold <= 0.0f && a.max_samples == 0)) {
    a.budget = kDefaultSamples;
  } else if (a.max_samples == 0) {
    a.max_samples = std::max(kDefaultMostSamples, a.min_samples);
  }
  plan.samples_per_pixel = a.budget;
  return plan;
}

DriverSettings driver_settings(const RenderOptions& options, const SamplingPlan& plan) {
  DriverSettings settings;
  settings.bucket_size = options.bucket_size;
  settings.bucket_order = options.bucket_order;
  settings.bisection_axis = options.bisection_axis;
  settings.reconstruction = options.reconstruction;
  settings.adaptive = plan.adaptive;
  settings.explained = options.explained;
  settings.keep_tree = !options.trees.empty();
  return settings;
}

}  // namespace emberline
