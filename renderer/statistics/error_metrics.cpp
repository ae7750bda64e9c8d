#include "renderer/statistics/error_metrics.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <numeric>

#include "renderer/core/parallel.h"
#include "renderer/statistics/flip.h"
#include "renderer/statistics/row_sums.h"
#include "renderer/statistics/ssim.h"

namespace emberline {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct PlainSums {
  uint64_t finite = 0, different = 0;
  double squared = 0, signed_difference = 0, reference = 0, display_squared = 0;
  double largest = 0;
  PlainSums& operator+=(const PlainSums& o) {
    finite += o.finite;
    different += o.different;
    squared += o.squared;
    signed_difference += o.signed_difference;
    reference += o.reference;
    display_squared += o.display_squared;
    largest = std::max(largest, o.largest);
    return *this;
  }
};

struct Pictures {
  const RgbImage& image;
  const RgbImage& reference;
  const std::vector<uint8_t>& masked;
  const RgbImage& shown;
  const RgbImage& shown_reference;
};

PlainSums plain_sums_of_row(const Pictures& p, int y) {
  PlainSums sums;
  const size_t width = size_t(p.image.width);
  for (size_t i = size_t(y) * width; i < size_t(y + 1) * width; ++i) {
    const float* const x = &p.image.rgb[3 * i];
    const float* const r = &p.reference.rgb[3 * i];
    if (std::memcmp(x, r, 3 * sizeof(float)) != 0) ++sums.different;
    if (p.masked[i]) continue;
    ++sums.finite;
    for (size_t c = 0; c < 3; ++c) {
      const double difference = double(x[c]) - double(r[c]);
      sums.squared += difference * difference;
      sums.signed_difference += difference;
      sums.reference += double(r[c]);
      sums.largest = std::max(sums.largest, std::abs(difference));
      const double shown =
          double(p.shown.rgb[3 * i + c]) - double(p.shown_reference.rgb[3 * i + c]);
      sums.display_squared += shown * shown;
    }
  }
  return sums;
}

// Returns (x - r)^2 / (r^2 + eps), averaged over channels, for each finite pixel in row order.
std::vector<double> relative_errors(const Pictures& p, double epsilon) {
  std::vector<double> errors(p.masked.size());
  parallel_each(errors.size(), [&](size_t i) {
    for (size_t c = 3 * i; c < 3 * i + 3; ++c) {
      const double r = double(p.reference.rgb[c]), difference = double(p.image.rgb[c]) - r;
      errors[i] += difference * difference / (r * r + epsilon);
    }
    errors[i] /= 3;
  });
  size_t kept = 0;
  for (size_t i = 0; i < errors.size(); ++i) {
    if (!p.masked[i]) errors[kept++] = errors[i];
  }
  errors.resize(kept);
  return errors;
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / double(values.size());
}

// Returns the Rec. 709 luma of display values (ITU-R BT.709-6, section 3).
std::vector<float> luma(const RgbImage& shown) {
  std::vector<float> values(shown.rgb.size() / 3);
  for (size_t i = 0; i < values.size(); ++i) {
    const float* const c = &shown.rgb[3 * i];
    values[i] = 0.2126f * c[0] + 0.7152f * c[1] + 0.0722f * c[2];
  }
  return values;
}

double mean_flip(const Pictures& p, uint64_t finite) {
  const std::vector<float> map = flip_map(p.shown, p.shown_reference);
  const size_t width = size_t(p.image.width);
  const double sum = sum_rows<double>(p.image.height, [&](int y) {
    double row = 0;
    for (size_t i = size_t(y) * width; i < size_t(y + 1) * width; ++i) {
      if (!p.masked[i]) row += double(map[i]);
    }
    return row;
  });
  return sum / double(finite);
}

double encode_srgb(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
}

}  // namespace

// If several values equal the smallest dropped one, it does not matter which of them are dropped.
double trimmed_mean(std::vector<double> values) {
  const size_t dropped = size_t(kTrimmedFraction * double(values.size()));
  const size_t kept = values.size() - dropped;
  if (dropped > 0) {
    std::nth_element(values.begin(), values.begin() + ptrdiff_t(kept), values.end());
    values.resize(kept);
    // nth_element leaves the order unspecified. Sorting the values makes the rounding of their sum
    // deterministic.
    std::sort(values.begin(), values.end());
  }
  return mean(values);
}

std::vector<uint8_t> non_finite_pixels(const RgbImage& image, const RgbImage& reference) {
  std::vector<uint8_t> masked(image.rgb.size() / 3);
  for (size_t i = 0; i < masked.size(); ++i) {
    bool finite = true;
    for (size_t c = 0; c < 3; ++c) {
      finite &= std::isfinite(image.rgb[3 * i + c]) && std::isfinite(reference.rgb[3 * i + c]);
    }
    masked[i] = finite ? 0 : 1;
  }
  return masked;
}

RgbImage to_display(const RgbImage& image, float exposure, const std::vector<uint8_t>& masked) {
  assert(masked.size() * 3 == image.rgb.size());
  const double scale = std::exp2(double(exposure));
  RgbImage shown{image.width, image.height, std::vector<float>(image.rgb.size(), 0.0f)};
  parallel_each(shown.rgb.size(), [&](size_t c) {
    if (!masked[c / 3]) shown.rgb[c] = float(encode_srgb(double(image.rgb[c]) * scale));
  });
  return shown;
}

ErrorMetrics compare_images(const RgbImage& image, const RgbImage& reference,
                            const CompareSettings& settings) {
  assert(image.width > 0 && image.height > 0);
  assert(image.width == reference.width && image.height == reference.height);
  assert(image.rgb.size() == 3 * size_t(image.width) * size_t(image.height));
  assert(reference.rgb.size() == image.rgb.size());

  const std::vector<uint8_t> masked = non_finite_pixels(image, reference);
  const RgbImage shown = to_display(image, settings.exposure, masked);
  const RgbImage shown_reference = to_display(reference, settings.exposure, masked);
  const Pictures pictures = {image, reference, masked, shown, shown_reference};
  const PlainSums sums =
      sum_rows<PlainSums>(image.height, [&](int y) { return plain_sums_of_row(pictures, y); });

  ErrorMetrics metrics;
  metrics.different_pixels = sums.different;
  metrics.non_finite = masked.size() - sums.finite;
  if (sums.finite == 0) return metrics;

  const double values = 3 * double(sums.finite);
  metrics.mse = sums.squared / values;
  metrics.rmse = std::sqrt(metrics.mse);
  metrics.max_absolute = sums.largest;
  if (sums.signed_difference == 0) {
    metrics.signed_bias = 0;
  } else if (sums.reference == 0) {
    metrics.signed_bias = std::copysign(kInfinity, sums.signed_difference);
  } else {
    metrics.signed_bias = sums.signed_difference / sums.reference;
  }

  const double mean_reference = sums.reference / values;
  metrics.rel_mse_epsilon = 0.01 * mean_reference * mean_reference;
  if (!(metrics.rel_mse_epsilon > 0)) metrics.rel_mse_epsilon = kBlackEpsilon;
  std::vector<double> errors = relative_errors(pictures, metrics.rel_mse_epsilon);
  metrics.rel_mse = mean(errors);
  metrics.rel_mse_trimmed = trimmed_mean(std::move(errors));

  const double display_mse = sums.display_squared / values;
  metrics.psnr = display_mse > 0 ? -10 * std::log10(display_mse) : kInfinity;
  metrics.ssim = mean_ssim(luma(shown), luma(shown_reference), masked, image.width, image.height);
  metrics.flip = mean_flip(pictures, sums.finite);
  return metrics;
}

}  // namespace emberline
