#include "renderer/drivers/adaptive/round_averages.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "renderer/core/archive.h"
#include "renderer/core/parallel.h"
#include "renderer/core/rect.h"
#include "renderer/core/vector.h"
#include "renderer/film/film.h"

namespace emberline {
namespace {

constexpr double kMaxVariance = 1e18;  // keeps sums over a frame finite

Rgb variance_of_first_round(const FilmTile& film, size_t i) {
  const Rect& rect = film.rect();
  const int x = rect.x0 + int(i % size_t(rect.width())),
            y = rect.y0 + int(i / size_t(rect.width()));
  return film.variance(x, y).value_or(Rgb(0.0f));
}

}  // namespace

// Let s be the new round's fraction of all weights, U the variance of the average so far, V the
// variance of the round's mean and D the difference between this mean and the average so far. Then
// E D^2 = U + V, so the new variance is (1 - s)^2 U + s^2 V = (1 - 2 s) U + s^2 E D^2.
void RoundAverages::add_round(const FilmTile& film, double weight) {
  const auto pixels = size_t(film.rect().area());
  if (pixels_.empty()) pixels_.resize(pixels, Pixel{});
  const bool first = weight_ == 0.0;
  const double round_fraction = weight / (weight_ + weight);
  assert(first || round_fraction <= 0.5);
  constexpr size_t kGrain = 4096;
  parallel_ranges(pixels, kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const PixelSums& film_sums = film.sums(i);
      Pixel& pixel = pixels_[i];
      const double samples = film_sums.samples(), new_samples = samples - pixel.samples;
      assert(new_samples > 0);
      const Rgb first_variance = first ? variance_of_first_round(film, i) : Rgb(0.0f);
      for (size_t c = 0; c < 4; ++c) {
        const double sum = c < 3 ? film_sums.rgb[0][c] + film_sums.rgb[1][c] : film_sums.alpha;
        const double mean = (sum - pixel.sums[c]) / new_samples;
        if (c < 3) {
          double& variance = pixel.variance[c];
          variance = first ? double(first_variance[int(c)])
                           : (1 - 2 * round_fraction) * variance +
                                 square(round_fraction * (mean - pixel.average[c] / weight_));
          variance = std::clamp(variance, 0.0, kMaxVariance);
        }
        pixel.average[c] += weight * (sum - pixel.sums[c]) / new_samples;
        pixel.sums[c] = sum;
      }
      pixel.samples = samples;
    }
  });
  weight_ += weight;
}

void RoundAverages::resolve(size_t i, float* rgba) const {
  constexpr double kMaxFloat = std::numeric_limits<float>::max();
  for (size_t c = 0; c < 4; ++c) {
    rgba[c] = float(std::clamp(pixels_[i].average[c] / weight_, -kMaxFloat, kMaxFloat));
  }
  rgba[3] = std::clamp(rgba[3], 0.0f, 1.0f);
}

void RoundAverages::archive(Archive& archive, const FilmTile& film) {
  archive.number(weight_, 0.0, 1e18);
  archive.array(pixels_, size_t(film.rect().area()));
  archive.check(pixels_.empty() || weight_ > 0);
  for (size_t i = 0; i < pixels_.size(); ++i) {
    const Pixel& pixel = pixels_[i];
    archive.check(pixel.samples > 0 && pixel.samples <= film.sums(i).samples());
    for (const double v : pixel.variance) archive.check(v >= 0 && v <= kMaxVariance);
    for (size_t c = 0; c < 4; ++c) {
      archive.check(std::isfinite(pixel.average[c]) && std::isfinite(pixel.sums[c]));
    }
  }
}

}  // namespace emberline
