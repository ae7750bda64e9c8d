// A cleaner picture in milliseconds, for a window that shows each one as it comes.
//
// The edge-avoiding à-trous wavelet transform (Dammertz et al. 2010, "Edge-Avoiding À-Trous Wavelet
// Transform for fast Global Illumination Filtering") over the colour divided by albedo. Pixels
// count as alike by normal and depth, and by brightness as far as its noise lets one tell (Schied
// et al. 2017, "Spatiotemporal Variance-Guided Filtering"). Noise falls as samples come, and so
// does what is changed: the picture converges to the raw one. Nothing says how wrong it is;
// denoise.h does.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>

namespace emberline {

// What a row of a frame knows beside its colour, to be filled in: `width` values each.
struct FeatureRow {
  std::array<float*, 3> albedo;  // 0: nothing to divide by
  std::array<float*, 3> normal;
  float* nearness;  // 1 over the depth; 0 where nothing is
  float* samples;   // 0: the pixel's colour means nothing
  float* variance;  // of the luminance of the pixel's mean; negative: not known
};

// Keeps its memory from picture to picture. One picture at a time, on TBB's current arena; the same
// bits for any number of threads.
class FastFilter {
 public:
  FastFilter();
  ~FastFilter();

  // From several threads, each row once.
  using ReadRow = std::function<void(int y, const FeatureRow& row)>;

  // Level l looks 2^l pixels far; what they reach, 2^levels - 1, must fit into a plane's border.
  static constexpr int kMostLevels = 5;
  static int levels_for(double samples_per_pixel);

  // R G B A of each pixel, interleaved, to the same; alpha stays. Pixels that are not finite are
  // not known either: they become what the nearest known one of their row is.
  void filter(int width, int height, std::span<const float> rgba, const ReadRow& read, int levels,
              std::span<float> filtered);

  // Held for each pixel, at most.
  static constexpr uint64_t kBytesPerPixel = 17 * sizeof(float);

 private:
  class Planes;
  const std::unique_ptr<Planes> planes_;
};

}  // namespace emberline
