#include "renderer/drivers/adaptive/error_estimator.h"

#include "renderer/core/names.h"
#include "renderer/drivers/adaptive/chi_square_estimator.h"
#include "renderer/drivers/adaptive/contrast_estimator.h"
#include "renderer/drivers/adaptive/dammertz_estimator.h"
#include "renderer/drivers/adaptive/kajiya_estimator.h"
#include "renderer/drivers/adaptive/nested_estimator.h"
#include "renderer/drivers/adaptive/painter_sloan_estimator.h"
#include "renderer/drivers/adaptive/two_stream_estimator.h"

namespace emberline {
namespace {

template <typename Estimator>
std::unique_ptr<ErrorEstimator> create(const EstimatorSettings& settings) {
  return std::make_unique<Estimator>(settings);
}

// A row of an estimator of the books, which gives unfinished pixels a batch at a time.
template <typename Estimator>
constexpr EstimatorEntry historical(std::string_view name, std::string_view summary,
                                    StreamCount streams, bool rms_error = false) {
  return {
      name,     summary, create<Estimator>, streams, Estimator::kFirstSamples, Estimator::kBatch,
      rms_error};
}

// The first row is the default.
constexpr EstimatorEntry kEstimators[] = {
    {"nested",
     "variance from what the last doubling of one sample stream has brought, pooled over "
     "neighbours; counts are powers of two and half again, as well stratified as uniform ones",
     create<NestedEstimator>, StreamCount::kOne, 16, 0, true, true},
    {"two-stream",
     "variance from two independent sample streams, pooled over neighbours; samples go where they "
     "lower the error most for their cost",
     create<TwoStreamEstimator>, StreamCount::kTwo, 16, 0, true},
    historical<ContrastEstimator>(
        "contrast", "contrast between neighbouring pixels (Mitchell 1987)", StreamCount::kOne),
    historical<PainterSloanEstimator>(
        "painter-sloan", "confidence interval of the pixel's mean (Painter & Sloan 1989)",
        StreamCount::kOne),
    historical<ChiSquareEstimator>(
        "chi-square", "upper bound on the variance of the pixel's mean (Lee et al. 1985)",
        StreamCount::kOne),
    historical<KajiyaEstimator>("kajiya", "difference of the pixel's two halves (Kajiya 1986)",
                                StreamCount::kTwo, true),
    historical<DammertzEstimator>(
        "dammertz", "difference of two half images over blocks (Dammertz et al. 2009)",
        StreamCount::kTwo),
};

}  // namespace

std::span<const EstimatorEntry> estimator_table() { return kEstimators; }

const EstimatorEntry& find_estimator(std::string_view name) {
  return find_named(kEstimators, "--estimator", "estimator", name);
}

}  // namespace emberline
