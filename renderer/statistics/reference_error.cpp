#include "renderer/statistics/reference_error.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "renderer/statistics/flip.h"
#include "renderer/statistics/value_list.h"

namespace emberline {
namespace {

constexpr double kPercentile = 0.95;

RgbImage mean_of(const RgbImage& a, const RgbImage& b) {
  RgbImage mean = a;
  for (size_t i = 0; i < a.rgb.size(); ++i) {
    mean.rgb[i] = float(0.5 * (double(a.rgb[i]) + double(b.rgb[i])));
  }
  return mean;
}

double percentile(std::vector<double> values) {
  return values.empty() ? std::nan("") : nearest_rank_quantile(std::move(values), kPercentile);
}

struct PixelError {
  double square, product;  // relative errors, averaged over channels; `product` uses both halves
};

// Drops the pixels with the largest `square`, a fraction kTrimmedFraction of all pixels, and
// returns the mean `product` of the others.
double trimmed_mean(std::vector<PixelError> errors) {
  const size_t kept = errors.size() - size_t(kTrimmedFraction * double(errors.size()));
  std::ranges::stable_sort(errors, {}, &PixelError::square);
  double sum = 0;
  for (size_t i = 0; i < kept; ++i) sum += errors[i].product;
  return sum / double(kept);
}

}  // namespace

ReferencePicture::ReferencePicture(const RgbImage& a, const RgbImage& b)
    : a_(a), b_(b), mean_(mean_of(a, b)), masked_(non_finite_pixels(a, b)) {
  assert(a.width == b.width && a.height == b.height && a.width > 0 && a.height > 0);
  for (size_t i = 0; i < masked_.size(); ++i) {
    if (masked_[i]) continue;
    ++pixels_;
    for (size_t c = 3 * i; c < 3 * i + 3; ++c) sum_ += double(mean_.rgb[c]);
  }
  display_a_ = to_display(a_, 0, masked_);
  display_b_ = to_display(b_, 0, masked_);
  display_mean_ = to_display(mean_, 0, masked_);
  const double mean = sum_ / (3 * double(pixels_));
  epsilon_ = mean != 0 ? 0.01 * mean * mean : kBlackEpsilon;
}

ReferencePicture::ReferencePicture(const RgbImage& picture) : ReferencePicture(picture, picture) {}

StudyError ReferencePicture::measure(const RgbImage& picture) const {
  assert(picture.width == mean_.width && picture.height == mean_.height);
  const RgbImage shown = to_display(picture, 0, masked_);
  StudyError out;
  double difference_sum = 0;
  std::vector<PixelError> relative;
  std::vector<double> absolute, displayed;
  for (size_t i = 0; i < masked_.size(); ++i) {
    if (masked_[i]) continue;
    PixelError& pixel = relative.emplace_back(0.0, 0.0);
    double squares = 0, shown_squares = 0;
    for (size_t c = 3 * i; c < 3 * i + 3; ++c) {
      const double x = double(picture.rgb[c]), r = double(mean_.rgb[c]), d = double(shown.rgb[c]);
      const double product = (x - double(a_.rgb[c])) * (x - double(b_.rgb[c]));
      const double square = (x - r) * (x - r), weight = 1 / (3 * (r * r + epsilon_));
      out.mse += product;
      out.display_mse += (d - double(display_a_.rgb[c])) * (d - double(display_b_.rgb[c]));
      pixel.product += product * weight;
      pixel.square += square * weight;
      difference_sum += x - r;
      squares += square;
      shown_squares += (d - double(display_mean_.rgb[c])) * (d - double(display_mean_.rgb[c]));
    }
    out.rel_mse += pixel.product;
    absolute.push_back(std::sqrt(squares / 3));
    displayed.push_back(std::sqrt(shown_squares / 3));
  }
  const auto pixels = double(pixels_);
  out.mse /= 3 * pixels;
  out.display_mse /= 3 * pixels;
  out.rel_mse /= pixels;
  out.rel_mse_trimmed = trimmed_mean(std::move(relative));
  out.signed_bias = difference_sum / sum_;
  out.p95_absolute = percentile(std::move(absolute));
  out.p95_display = percentile(std::move(displayed));
  const std::vector<float> map = flip_map(shown, display_mean_);
  for (size_t i = 0; i < map.size(); ++i) {
    if (!masked_[i]) out.flip += double(map[i]) / pixels;
  }
  return out;
}

std::vector<float> ReferencePicture::flip(const RgbImage& picture) const {
  return flip_map(to_display(picture, 0, masked_), display_mean_);
}

void ReferencePicture::set_noise(StudyReference* out) const {
  double squares = 0, relative = 0, displayed = 0;
  for (size_t c = 0; c < mean_.rgb.size(); ++c) {
    if (masked_[c / 3]) continue;
    const double d = (double(a_.rgb[c]) - double(b_.rgb[c])) / 2, r = double(mean_.rgb[c]);
    const double s = (double(display_a_.rgb[c]) - double(display_b_.rgb[c])) / 2;
    squares += d * d;
    relative += d * d / (r * r + epsilon_);
    displayed += s * s;
  }
  const double values = 3 * double(pixels_);
  out->noise_mse = squares / values;
  out->noise_rel_mse = relative / values;
  out->noise_display_mse = displayed / values;
  // The formula assumes that pixels are independent. It also assumes that the channels of a pixel
  // are fully correlated, so the result is an upper bound.
  out->noise_bias = std::sqrt(3 * squares) / std::abs(sum_);
  out->rel_mse_epsilon = epsilon_;
}

}  // namespace emberline
