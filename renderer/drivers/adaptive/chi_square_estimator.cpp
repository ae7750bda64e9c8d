#include "renderer/drivers/adaptive/chi_square_estimator.h"

#include <cmath>

#include "renderer/drivers/adaptive/pixel_errors.h"
#include "renderer/drivers/adaptive/quantiles.h"

namespace emberline {
namespace {

// Returns the ratio of the bound to the plain estimate, which is variance / n. The bound is s^2 /
// chi2, where s^2 = variance (n - 1) / n.
float bound_factor(float count) {
  const double degrees = double(count) - 1.0;
  return float(degrees / chi_square_quantile_05(degrees));
}

}  // namespace

void estimate_chi_square(const PixelStatistics& pixels, const EstimatorSettings&, ErrorMap* out) {
  const auto bound = [&](size_t i, float error) {
    const float n = pixels.count[i];
    if (!(n >= float(kChiSquareBatch))) return kUnknownError;
    return error * std::sqrt(bound_factor(n));
  };
  fill_display_errors_of_samples(pixels, bound, out);
}

}  // namespace emberline
