// The input of the error estimators: the state of a crop's pixels between two rounds, as planes of
// floats. Estimators are pure functions of it, so they can be tested on synthetic images.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace emberline {

class FilmTile;

// Cost of a sample that traces only its camera ray; each further ray costs 1. Medians on
// FlightHelmet and a Cornell box: 50 to 60 ns for a sample that sees the sky, 300 to 400 ns more
// for each ray beyond the camera's.
inline constexpr float kCameraRayCost = 0.17f;

// Planes of width x height entries, rows from the crop's top. Linear radiance, channels R, G, B.
struct PixelStatistics {
  int width = 0, height = 0;
  std::vector<float> count;  // samples of the pixel, n
  // Those of the second of two sample streams (samplers/sampler.h); all 0 with one stream.
  std::vector<float> second_count;
  std::array<std::vector<float>, 3> mean;  // of all samples
  // Difference of the two streams' means; 0 if one has no samples. Its expected square is the
  // variance of a sample times (1/n_A + 1/n_B), however correlated the samples within a stream are.
  std::array<std::vector<float>, 3> stream_difference;
  // Sample variance as if samples were independent: (sum of squares - n mean^2) / (n - 1), 0 for n
  // < 2. The mean of stratified samples has less variance than this over n.
  std::array<std::vector<float>, 3> variance;
  // Cost of a sample, at least kCameraRayCost. In rays instead of seconds, so that no decision
  // depends on the clock.
  std::vector<float> cost;

  size_t size() const { return size_t(width) * size_t(height); }
  void resize(int new_width, int new_height);
};

// Resizes planes of pixels; those of a large crop in parallel, since their memory may be new.
void resize_planes(std::span<std::vector<float>* const> planes, size_t pixels);

// relMSE's epsilon, (x - r)^2 / (r^2 + epsilon): a hundredth of the squared mean over pixels and
// channels, as in `compare`; at least 1e-6, for a black picture.
float rel_mse_epsilon(const PixelStatistics& pixels);

// Reads the film, which must have squares and rays (FilmExtras). In parallel.
void gather_statistics(const FilmTile& film, PixelStatistics* out);

}  // namespace emberline
