#include "renderer/drivers/adaptive/error_estimator.h"

#include "renderer/core/names.h"
#include "renderer/drivers/adaptive/two_stream_estimator.h"

namespace emberline {
namespace {

template <typename T>
std::unique_ptr<ErrorEstimator> make(const EstimatorSettings& settings) {
  return std::make_unique<T>(settings);
}

// The first row is the default.
constexpr EstimatorEntry kEstimators[] = {
    {"two-stream",
     "variance from two independent sample streams, pooled over neighbours; samples "
     "go where they lower the error most for their cost",
     make<TwoStreamEstimator>, StreamCount::kTwo, 16, 0},
};

}  // namespace

std::span<const EstimatorEntry> estimator_table() { return kEstimators; }

const EstimatorEntry& find_estimator(std::string_view name) {
  return find_named(kEstimators, "--estimator", "estimator", name);
}

}  // namespace emberline
