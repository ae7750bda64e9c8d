#include "renderer/drivers/adaptive/dammertz_estimator.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "renderer/core/rect.h"
#include "renderer/core/summed_area_table.h"
#include "renderer/drivers/adaptive/pixel_errors.h"

namespace emberline {
namespace {

constexpr float kErrorPerDeviation = 2.7639532f;  // 2 sqrt(3) sqrt(2 / pi), see the header

// Pixel errors are integers in units of 2^-24, so sums are exact in any order, and the sum of a
// block of zeros is zero. The maximum is 256, so sums over 2^31 pixels cannot overflow.
constexpr float kUnits = 0x1p24f;
constexpr float kMaxPixelError = 256.0f;

bool has_estimate(const PixelStatistics& pixels, size_t i) {
  return pixels.second_count[i] >= 1.0f && pixels.count[i] - pixels.second_count[i] >= 1.0f;
}

// Returns the error e_p, which is at most kMaxPixelError. Returns 0 if the pixel has no estimate or
// an error that is not finite, because one such pixel must not keep its block unfinished.
uint64_t pixel_error(const PixelStatistics& pixels, size_t i) {
  constexpr float kMinLight = 1e-8f;  // a filter with negative lobes may even make `light` negative
  if (!has_estimate(pixels, i)) return 0;
  float light = 0.0f, difference = 0.0f;
  for (size_t c = 0; c < 3; ++c) {
    light += pixels.mean[c][i];
    difference += std::abs(pixels.stream_difference[c][i]);
  }
  // I - A is the difference of the streams times the second stream's share of the samples.
  const float e =
      pixels.second_count[i] / pixels.count[i] * difference / std::sqrt(std::max(light, kMinLight));
  return std::isfinite(e) ? uint64_t(std::min(e, kMaxPixelError) * kUnits) : 0;
}

// Returns the error e_b in the threshold's units.
float block_error(const SummedAreaTable& sums, const Rect& block) {
  const auto area = float(block.area());
  const float mean = float(double(sums(block)) / double(kUnits)) / area;
  return mean * std::sqrt(area / float(kDammertzLeafPixels)) / kErrorPerDeviation;
}

// Returns the part of `block` before `cut` along its longer axis.
Rect first_part(const Rect& block, int cut) {
  return block.width() >= block.height() ? Rect{block.x0, block.y0, cut, block.y1}
                                         : Rect{block.x0, block.y0, block.x1, cut};
}

// Returns the first cut with at least half of the block's error before it. At least one column or
// row comes after the cut.
int median_cut(const SummedAreaTable& sums, const Rect& block) {
  const bool across = block.width() >= block.height();
  int low = (across ? block.x0 : block.y0) + 1, high = (across ? block.x1 : block.y1) - 1;
  const uint64_t total = sums(block);
  while (low < high) {
    const int middle = low + (high - low) / 2;
    if (2 * sums(first_part(block, middle)) >= total) {
      high = middle;
    } else {
      low = middle + 1;
    }
  }
  return low;
}

class BlockTree {
 public:
  BlockTree(const PixelStatistics& pixels, float threshold, std::vector<float>* error)
      : sums_(pixels.width, pixels.height, [&](size_t i) { return pixel_error(pixels, i); }),
        threshold_(threshold),
        width_(size_t(pixels.width)),
        error_(error) {}

  void estimate_block(const Rect& block) {
    const float error = block_error(sums_, block);
    const bool noisy = threshold_ > 0.0f && error >= kDammertzSplitLimit * threshold_;
    if (error <= threshold_ || noisy || block.area() <= kDammertzLeafPixels) {
      fill(block, error);
      return;
    }
    const int cut = median_cut(sums_, block);
    const bool across = block.width() >= block.height();
    estimate_block(first_part(block, cut));
    estimate_block(across ? Rect{cut, block.y0, block.x1, block.y1}
                          : Rect{block.x0, cut, block.x1, block.y1});
  }

 private:
  // Pixels without an estimate stay unfinished, whatever the block's error.
  void fill(const Rect& block, float error) {
    for (int y = block.y0; y < block.y1; ++y) {
      float* row = &(*error_)[size_t(y) * width_];
      for (int x = block.x0; x < block.x1; ++x) row[x] = std::max(row[x], error);
    }
  }

  SummedAreaTable sums_;
  float threshold_;
  size_t width_;
  std::vector<float>* error_;
};

}  // namespace

void estimate_dammertz(const PixelStatistics& pixels, const EstimatorSettings& settings,
                       ErrorMap* out) {
  fill_errors(
      pixels, [&](size_t i) { return has_estimate(pixels, i) ? 0.0f : kUnknownError; }, out);
  if (pixels.size() == 0) return;
  BlockTree(pixels, settings.threshold, &out->error)
      .estimate_block({0, 0, pixels.width, pixels.height});
}

}  // namespace emberline
