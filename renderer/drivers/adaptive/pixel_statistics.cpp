#include "renderer/drivers/adaptive/pixel_statistics.h"

#include <algorithm>

#include "renderer/core/parallel.h"

namespace emberline {
namespace {

// Sums of squares may exceed float, and so may what is left of them.
float to_float(double x) { return float(std::clamp(x, -1e30, 1e30)); }

// The camera's ray leads to little work when it meets nothing; every further one brings a surface
// to be shaded with it.
float sample_cost(double rays) {
  constexpr double kCameraRay = 0.17;  // measured; see tests/bench/README.md
  return float(kCameraRay + std::max(0.0, rays - 1.0));
}

void gather_pixel(const FilmTile& film, size_t i, PixelStatistics* out) {
  const PixelSums& sums = film.sums(i);
  const double a = sums.count[0], b = sums.count[1], n = a + b;
  out->count[i] = float(n);
  out->second_count[i] = float(b);
  const double per_sample = n > 0 ? 1 / n : 0.0, per_degree = n > 1 ? 1 / (n - 1) : 0.0;
  const double per_a = a > 0 && b > 0 ? 1 / a : 0.0, per_b = a > 0 && b > 0 ? 1 / b : 0.0;
  for (size_t c = 0; c < 3; ++c) {
    const double sum = sums.rgb[0][c] + sums.rgb[1][c];
    const double spread = film.squares()[3 * i + c] - sum * sum * per_sample;
    out->mean[c][i] = to_float(sum * per_sample);
    out->stream_difference[c][i] = to_float(sums.rgb[0][c] * per_a - sums.rgb[1][c] * per_b);
    out->variance[c][i] = to_float(std::max(0.0, spread) * per_degree);
  }
  out->cost[i] = n > 0 ? sample_cost(double(film.rays()[i]) * per_sample) : 1.0f;
}

}  // namespace

void PixelStatistics::resize(int new_width, int new_height) {
  width = new_width;
  height = new_height;
  for (auto* plane : {&count, &second_count, &cost}) plane->resize(size());
  for (size_t c = 0; c < 3; ++c) {
    mean[c].resize(size());
    stream_difference[c].resize(size());
    variance[c].resize(size());
  }
}

float rel_mse_epsilon(const PixelStatistics& pixels) {
  double sum = 0.0;  // in one order, whatever the threads
  for (const std::vector<float>& plane : pixels.mean) {
    for (const float value : plane) sum += double(value);
  }
  const double mean = pixels.size() > 0 ? sum / (3 * double(pixels.size())) : 0.0;
  return float(std::max(1e-6, 0.01 * mean * mean));
}

void gather_statistics(const FilmTile& film, PixelStatistics* out) {
  out->resize(film.rect().width(), film.rect().height());
  constexpr size_t kGrain = 4096;
  parallel_ranges(out->size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) gather_pixel(film, i, out);
  });
}

}  // namespace emberline
