#include "renderer/drivers/adaptive/round_averages.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "renderer/core/parallel.h"

namespace emberline {

void RoundAverages::add_round(const FilmTile& film, double weight) {
  const auto pixels = size_t(film.rect().area());
  if (rounds_.empty()) rounds_.resize(pixels, Pixel{});
  constexpr size_t kGrain = 4096;
  parallel_ranges(pixels, kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const PixelSums& film_sums = film.sums(i);
      Pixel& pixel = rounds_[i];
      const double samples = film_sums.samples(), fresh = samples - pixel.samples;
      assert(fresh > 0);
      for (size_t c = 0; c < 4; ++c) {
        const double sum = c < 3 ? film_sums.rgb[0][c] + film_sums.rgb[1][c] : film_sums.alpha;
        pixel.average[c] += weight * (sum - pixel.sums[c]) / fresh;
        pixel.sums[c] = sum;
      }
      pixel.samples = samples;
      pixel.noise += weight * weight / fresh;
    }
  });
  weight_ += weight;
}

void RoundAverages::resolve(size_t i, float* rgba) const {
  constexpr double kMost = std::numeric_limits<float>::max();
  for (size_t c = 0; c < 4; ++c) {
    rgba[c] = float(std::clamp(rounds_[i].average[c] / weight_, -kMost, kMost));
  }
  rgba[3] = std::clamp(rgba[3], 0.0f, 1.0f);
}

void RoundAverages::archive(Archive& archive, const FilmTile& film) {
  archive.number(weight_, 0.0, 1e18);
  archive.array(rounds_, size_t(film.rect().area()));
  archive.check(rounds_.empty() || weight_ > 0);
  for (size_t i = 0; i < rounds_.size(); ++i) {
    const Pixel& pixel = rounds_[i];
    archive.check(pixel.samples > 0 && pixel.samples <= film.sums(i).samples());
    archive.check(pixel.noise > 0 && std::isfinite(pixel.noise));
    for (size_t c = 0; c < 4; ++c) {
      archive.check(std::isfinite(pixel.average[c]) && std::isfinite(pixel.sums[c]));
    }
  }
}

}  // namespace emberline
