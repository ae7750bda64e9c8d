#include "renderer/drivers/adaptive/frame_error.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "renderer/core/display_error.h"
#include "renderer/core/parallel.h"
#include "renderer/drivers/adaptive/ordered_sum.h"

namespace emberline {
namespace {

constexpr int kTileSide = 32;

// Sums over pixels and channels.
struct ErrorSums {
  double error = 0.0;        // squared display error, from the differences
  double independent = 0.0;  // the same from the spread, as if samples were independent
  double weighted = 0.0;     // error times the pixel's count
};

struct Lanes {
  float error[kSumLanes] = {}, independent[kSumLanes] = {}, weighted[kSumLanes] = {};

  ErrorSums sums() const {
    return {sum_of_lanes(error), sum_of_lanes(independent), sum_of_lanes(weighted)};
  }
};

// The sums of the pixels whose counts are powers of two, and of the others. `nested` raises counts
// to powers of two and 1.5 times powers of two.
struct TileSums {
  Lanes powers, others;

  void add_row(const PixelStatistics& p, size_t c, size_t begin, size_t end) {
    const float *count = p.count.data(), *second = p.second_count.data(), *mean = p.mean[c].data(),
                *spread = p.variance[c].data(), *difference = p.stream_difference[c].data();
    for_lanes(begin, end, [&](size_t i, size_t lane) {
      const float n = std::max(1.0f, count[i]);
      const float variance = sample_variance(count[i], second[i], difference[i], spread[i]);
      const float weight = display_error_weight(mean[i], std::sqrt(variance / n), 0.0f);
      const float error = weight * (variance / n);
      const float independent = weight * (std::min(spread[i], kMaxVariance) / n);
      constexpr uint32_t kMantissa = 0x7fffffu;
      const float is_power = (std::bit_cast<uint32_t>(n) & kMantissa) == 0 ? 1.0f : 0.0f;
      powers.error[lane] += is_power * error;
      powers.independent[lane] += is_power * independent;
      powers.weighted[lane] += is_power * (error * n);
      others.error[lane] += (1.0f - is_power) * error;
      others.independent[lane] += (1.0f - is_power) * independent;
      others.weighted[lane] += (1.0f - is_power) * (error * n);
    });
  }
};

// Return by how much the difference of two parts overstates the variance of the mean, if that falls
// as n^-a and p = 2^a. First for halves: V(n/2) / V(n) - 1. Then for the last third of the samples
// against the rest, the first of which are a power of two; aligned blocks of the sequence are
// interchangeable.
double excess_of_halves(double p) { return p - 1; }
double excess_of_third(double p) { return 2 * (3 + p - 4 / p) / (p + 8 / p); }

// Returns the squared error from sums whose `error` is overstated by excess(2^a).
double corrected_error(const ErrorSums& sums, double (*excess)(double)) {
  if (!(sums.error > 0.0)) return 0.0;
  // Limits the correction where the tile has both stratified noise and noise that is not.
  constexpr double kMaxExponent = 2.0;
  constexpr int kIterations = 5;
  const double ratio = std::log(std::max(1e-9, sums.independent / sums.error));
  const double log_count = std::log(std::max(4.0, sums.weighted / sums.error));
  double overstated = 1.0;
  for (int i = 0; i < kIterations; ++i) {
    const double exponent = 1.0 + (ratio + std::log(overstated)) / log_count;
    overstated = excess(std::exp2(std::clamp(exponent, 1.0, kMaxExponent)));
  }
  return sums.error / overstated;
}

double squared_error_of_tile(const PixelStatistics& p, int x0, int y0, Compared compared) {
  TileSums tile;
  const int x1 = std::min(x0 + kTileSide, p.width), y1 = std::min(y0 + kTileSide, p.height);
  for (int y = y0; y < y1; ++y) {
    const size_t row = size_t(y) * size_t(p.width);
    for (size_t c = 0; c < 3; ++c) tile.add_row(p, c, row + size_t(x0), row + size_t(x1));
  }
  const ErrorSums powers = tile.powers.sums(), others = tile.others.sums();
  if (compared == Compared::kStreams) return powers.error + others.error;
  return corrected_error(powers, excess_of_halves) + corrected_error(others, excess_of_third);
}

double rms_of(double sum, size_t pixels) {
  return std::sqrt(sum / std::max(1.0, 3 * double(pixels)));
}

}  // namespace

double frame_error(const PixelStatistics& pixels, Compared compared, double missed) {
  const int columns = (pixels.width + kTileSide - 1) / kTileSide;
  const int rows = (pixels.height + kTileSide - 1) / kTileSide;
  std::vector<double> errors(size_t(columns) * size_t(rows));
  parallel_each(errors.size(), [&](size_t i) {
    const int x = int(i % size_t(columns)) * kTileSide, y = int(i / size_t(columns)) * kTileSide;
    errors[i] = squared_error_of_tile(pixels, x, y, compared);
  });
  return rms_of(std::accumulate(errors.begin(), errors.end(), missed), pixels.size());
}

double frame_error(const RoundAverages& averages, size_t pixels, double missed) {
  const double sum = ordered_sum(pixels, [&](size_t begin, size_t end) {
    double partial_sum = 0.0;
    for (size_t c = 0; c < 3; ++c) {
      float lanes[kSumLanes] = {};
      for_lanes(begin, end, [&](size_t i, size_t lane) {
        const auto mean = float(averages.mean(i, c)), variance = float(averages.variance(i, c));
        lanes[lane] += display_error_weight(mean, std::sqrt(variance), 0.0f) * variance;
      });
      partial_sum += sum_of_lanes(lanes);
    }
    return partial_sum;
  });
  return rms_of(sum + missed, pixels);
}

}  // namespace emberline
