// The input of the error estimators: the state of a crop's pixels between two rounds, as planes of
// floats. Estimators are pure functions of this state, so they can be tested on synthetic images.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace emberline {

class FilmTile;

// Cost of a sample that traces only its camera ray; each further ray costs 1. The value follows
// from medians that we measured on FlightHelmet and a Cornell box. A sample that sees the sky takes
// 50 to 60 ns. Each ray in addition to the camera ray takes 300 to 400 ns more.
inline constexpr float kCameraRayCost = 0.17f;

// The planes have width x height entries, with rows from the crop's top. Radiance is linear; its
// channels are R, G, B.
struct PixelStatistics {
  int width = 0, height = 0;
  std::vector<float> count;  // number of samples of the pixel, n
  // Number of samples in the second of two streams (samplers/sampler.h); all 0 with one stream.
  std::vector<float> second_count;
  std::array<std::vector<float>, 3> mean;  // mean of all samples
  // Difference of the two streams' means; 0 if either stream has no samples. Its expected square is
  // V (1/n_A + 1/n_B), where n_A and n_B are the streams' sample counts, and V / n is the variance
  // of the mean of n samples. V includes the effect of correlation between the samples of a stream.
  std::array<std::vector<float>, 3> stream_difference;
  // Variance of a sample as if samples were independent: (sum of squares - n mean^2) / (n - 1), or
  // 0 for n < 2. If samples are stratified, the variance of their mean is less than this value
  // divided by n.
  std::array<std::vector<float>, 3> variance;
  // Cost of a sample, at least kCameraRayCost. It is measured in rays instead of seconds, so that
  // no decision depends on the clock.
  std::vector<float> cost;

  size_t size() const { return size_t(width) * size_t(height); }
  void resize(int new_width, int new_height);
};

// Resizes planes to `pixels` entries. Works in parallel for large crops, since touching new memory
// takes time.
void resize_planes(std::span<std::vector<float>* const> planes, size_t pixels);

// Returns the epsilon in relMSE = (x - r)^2 / (r^2 + epsilon). As in the command `compare`, it is a
// hundredth of the squared mean over pixels and channels, and at least 1e-6 so that a black picture
// does not make it 0.
float rel_mse_epsilon(const PixelStatistics& pixels);

// Computes the statistics of the film in parallel. The film must have squares and rays
// (FilmExtras).
void gather_statistics(const FilmTile& film, PixelStatistics* out);

}  // namespace emberline
