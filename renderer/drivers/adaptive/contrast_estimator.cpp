#include "renderer/drivers/adaptive/contrast_estimator.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "renderer/drivers/adaptive/pixel_errors.h"

namespace emberline {
namespace {

constexpr float kLimits[3] = {0.4f, 0.3f, 0.6f};  // red, green, blue: Mitchell 1987

// The extremes of a channel over three rows, for each column. There is one extra column at each
// end, so entry x + 1 is column x. If an entry has no samples or is outside the crop, its low is
// above its high.
struct ColumnExtremes {
  std::vector<float> low, high;

  void clear(size_t width) {
    low.assign(width + 2, 2.0f);
    high.assign(width + 2, -1.0f);
  }
  void add_row(const float* mean, const float* count, size_t width) {
    for (size_t x = 0; x < width; ++x) {
      const float value = mean[x] > 0.0f ? std::min(mean[x], 1.0f) : 0.0f;  // as displayed
      const bool sampled = count[x] >= 1.0f;
      low[x + 1] = std::min(low[x + 1], sampled ? value : 2.0f);
      high[x + 1] = std::max(high[x + 1], sampled ? value : -1.0f);
    }
  }
  // Returns (max - min) / (max + min) over columns x - 1 to x + 1, or 0 without light or samples.
  float contrast(size_t x) const {
    const float minimum = std::min({low[x], low[x + 1], low[x + 2]});
    const float maximum = std::max({high[x], high[x + 1], high[x + 2]});
    return maximum > 0.0f ? (maximum - minimum) / (maximum + minimum) : 0.0f;
  }
};

// Raises the error of each pixel in row `y` to the error of one channel if that is larger.
void add_channel(const PixelStatistics& pixels, size_t channel, size_t y, ColumnExtremes& columns,
                 float* error) {
  const auto width = size_t(pixels.width), height = size_t(pixels.height);
  columns.clear(width);
  for (size_t row = y > 0 ? y - 1 : 0; row < std::min(y + 2, height); ++row) {
    columns.add_row(&pixels.mean[channel][row * width], &pixels.count[row * width], width);
  }
  const float scale = kContrastThreshold / kLimits[channel];
  for (size_t x = 0; x < width; ++x) error[x] = std::max(error[x], scale * columns.contrast(x));
}

}  // namespace

void estimate_contrast(const PixelStatistics& pixels, const EstimatorSettings&, ErrorMap* out) {
  constexpr size_t kRows = 8;
  // The error of a pixel with one sample is unknown, because the pixel's value is that of a single
  // path.
  fill_errors(
      pixels, [&](size_t i) { return pixels.count[i] >= 2.0f ? 0.0f : kUnknownError; }, out);
  const auto width = size_t(pixels.width);
  parallel_ranges(size_t(pixels.height), kRows, [&](size_t begin, size_t end) {
    ColumnExtremes columns;
    for (size_t y = begin; y < end; ++y) {
      for (size_t c = 0; c < 3; ++c) add_channel(pixels, c, y, columns, &out->error[y * width]);
    }
  });
}

}  // namespace emberline
