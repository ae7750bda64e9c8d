#include "renderer/drivers/adaptive/pixel_statistics.h"

#include <algorithm>

#include "renderer/core/parallel.h"
#include "renderer/core/vector.h"
#include "renderer/drivers/adaptive/ordered_sum.h"
#include "renderer/film/film.h"

namespace emberline {
namespace {

// Limits the value, because sums of squares and their differences may exceed the range of float.
float to_float(double x) { return float(std::clamp(x, -1e30, 1e30)); }

// A camera ray that hits nothing costs little; every further ray comes with a surface to shade.
float sample_cost(double rays) { return float(double(kCameraRayCost) + std::max(0.0, rays - 1.0)); }

// The sums of a few pixels as arrays. The film stores each pixel's sums together, but arithmetic on
// arrays vectorises.
struct Block {
  static constexpr size_t kPixels = 64;
  double count[2][kPixels], rgb[2][3][kPixels], squares[3][kPixels], rays[kPixels];

  // `last` is the index of the film's last pixel. Prefetches one block ahead. This halves the time,
  // since a film is larger than the caches.
  void load(const FilmTile& film, size_t first, size_t pixels, size_t last) {
    for (size_t j = 0; j < pixels; ++j) {
      const size_t ahead = std::min(first + j + kPixels, last);
      __builtin_prefetch(&film.sums(ahead));
      __builtin_prefetch(film.squares(ahead));
      const PixelSums& sums = film.sums(first + j);
      const double* squares_of_pixel = film.squares(first + j);
      for (size_t stream = 0; stream < 2; ++stream) {
        count[stream][j] = sums.count[stream];
        for (size_t c = 0; c < 3; ++c) rgb[stream][c][j] = sums.rgb[stream][c];
      }
      for (size_t c = 0; c < 3; ++c) squares[c][j] = squares_of_pixel[c];
      rays[j] = film.rays(first + j);
    }
  }
};

// Reciprocals of the sums' divisors; 0 where the divisor is 0.
struct Reciprocals {
  double sample[Block::kPixels], degree[Block::kPixels], stream[2][Block::kPixels];

  explicit Reciprocals(const Block& block) {
    for (size_t j = 0; j < Block::kPixels; ++j) {
      const double a = block.count[0][j], b = block.count[1][j], n = a + b;
      const bool both = a > 0 && b > 0;
      sample[j] = n > 0 ? 1 / n : 0.0;
      degree[j] = n > 1 ? 1 / (n - 1) : 0.0;
      stream[0][j] = both ? 1 / a : 0.0;
      stream[1][j] = both ? 1 / b : 0.0;
    }
  }
};

void gather_counts(const Block& block, const Reciprocals& per, size_t pixels, float* __restrict n,
                   float* __restrict second, float* __restrict cost) {
  for (size_t j = 0; j < pixels; ++j) {
    const double all = block.count[0][j] + block.count[1][j];
    n[j] = float(all);
    second[j] = float(block.count[1][j]);
    cost[j] = all > 0 ? sample_cost(block.rays[j] * per.sample[j]) : 1.0f;
  }
}

void gather_channel(const Block& block, const Reciprocals& per, size_t c, size_t pixels,
                    float* __restrict mean, float* __restrict difference,
                    float* __restrict variance) {
  for (size_t j = 0; j < pixels; ++j) {
    const double a = block.rgb[0][c][j], b = block.rgb[1][c][j], sum = a + b;
    const double spread = block.squares[c][j] - sum * sum * per.sample[j];
    mean[j] = to_float(sum * per.sample[j]);
    difference[j] = to_float(a * per.stream[0][j] - b * per.stream[1][j]);
    variance[j] = to_float(std::max(0.0, spread) * per.degree[j]);
  }
}

}  // namespace

void PixelStatistics::resize(int new_width, int new_height) {
  width = new_width;
  height = new_height;
  std::vector<std::vector<float>*> planes = {&count, &second_count, &cost};
  for (auto* channels : {&mean, &stream_difference, &variance}) {
    for (std::vector<float>& channel : *channels) planes.push_back(&channel);
  }
  resize_planes(planes, size());
}

void resize_planes(std::span<std::vector<float>* const> planes, size_t pixels) {
  constexpr size_t kGrain = 1 << 16;
  const size_t planes_per_task = std::max<size_t>(1, kGrain / std::max<size_t>(1, pixels));
  parallel_ranges(planes.size(), planes_per_task, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) planes[i]->resize(pixels);
  });
}

float rel_mse_epsilon(const PixelStatistics& pixels) {
  double sum = 0.0;
  for (const std::vector<float>& plane : pixels.mean) {
    sum += ordered_sum(plane.size(), [&](size_t begin, size_t end) {
      double lanes[kSumLanes] = {};
      const float* values = plane.data();
      for_lanes(begin, end, [&](size_t i, size_t lane) { lanes[lane] += double(values[i]); });
      return sum_of_lanes(lanes);
    });
  }
  const double mean = pixels.size() > 0 ? sum / (3 * double(pixels.size())) : 0.0;
  return float(std::max(1e-6, 0.01 * mean * mean));
}

void gather_statistics(const FilmTile& film, PixelStatistics* out) {
  out->resize(film.rect().width(), film.rect().height());
  constexpr size_t kGrain = 4096;
  parallel_ranges(out->size(), kGrain, [&](size_t begin, size_t end) {
    Block block = {};
    for (size_t i = begin; i < end; i += Block::kPixels) {
      const size_t pixels = std::min(Block::kPixels, end - i);
      block.load(film, i, pixels, out->size() - 1);
      const Reciprocals per(block);
      gather_counts(block, per, pixels, &out->count[i], &out->second_count[i], &out->cost[i]);
      for (size_t c = 0; c < 3; ++c) {
        gather_channel(block, per, c, pixels, &out->mean[c][i], &out->stream_difference[c][i],
                       &out->variance[c][i]);
      }
    }
  });
}

}  // namespace emberline
