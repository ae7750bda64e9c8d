#include "renderer/drivers/adaptive/painter_sloan_estimator.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "renderer/drivers/adaptive/pixel_errors.h"
#include "renderer/drivers/adaptive/quantiles.h"

namespace emberline {
namespace {

// The pixel and its edge neighbours. Pixels without samples are left out.
struct Neighbourhood {
  std::array<size_t, 5> pixels;
  size_t size = 0;
};

Neighbourhood neighbourhood(const PixelStatistics& statistics, size_t i) {
  Neighbourhood result;
  const auto add = [&](bool inside, size_t j) {
    if (inside && statistics.count[j] >= 1.0f) result.pixels[result.size++] = j;
  };
  const auto width = size_t(statistics.width);
  const size_t x = i % width;
  add(true, i);
  add(x > 0, i - 1);
  add(x + 1 < width, i + 1);
  add(i >= width, i - width);
  add(i + width < statistics.size(), i + width);
  return result;
}

// Returns the standard deviation of the displayed means in the pixel's neighbourhood, as the root
// mean square over the channels.
float external_deviation(const PixelStatistics& statistics, size_t i) {
  const Neighbourhood neighbours = neighbourhood(statistics, i);
  if (neighbours.size < 2) return 0.0f;
  float spread = 0.0f;
  for (const std::vector<float>& means : statistics.mean) {
    float displayed[5], sum = 0.0f;
    for (size_t k = 0; k < neighbours.size; ++k) {
      displayed[k] = display_value(means[neighbours.pixels[k]]);
      sum += displayed[k];
    }
    const float mean = sum / float(neighbours.size);
    for (size_t k = 0; k < neighbours.size; ++k)
      spread += (displayed[k] - mean) * (displayed[k] - mean);
  }
  return std::sqrt(spread / (3.0f * float(neighbours.size - 1)));
}

float t_quantile(float count) { return float(student_t_quantile_975(double(count) - 1.0)); }

}  // namespace

void estimate_painter_sloan(const PixelStatistics& pixels, const EstimatorSettings&,
                            ErrorMap* out) {
  const auto half_interval = [&](size_t i, float error) {
    const float n = pixels.count[i];
    if (!(n >= 2.0f)) return kUnknownError;
    const float interval = map_error(t_quantile(n) * error);
    if (n >= float(kPainterSloanBatch)) return interval;
    return std::max(interval, external_deviation(pixels, i));
  };
  fill_display_errors_of_samples(pixels, half_interval, out);
}

}  // namespace emberline
