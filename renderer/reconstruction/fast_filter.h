// Denoises an image in milliseconds, for a window that shows each image as it arrives.
//
// This is the edge-avoiding à-trous wavelet transform (Dammertz et al. 2010, "Edge-Avoiding À-Trous
// Wavelet Transform for fast Global Illumination Filtering") on the colour divided by albedo. The
// similarity of pixels depends on normal, depth, and brightness relative to its noise (Schied et
// al. 2017, "Spatiotemporal Variance-Guided Filtering"). As more samples reduce the noise, the
// filter changes less, so the filtered image converges to the raw image. There is no error
// estimate; denoise.h has one.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>

namespace emberline {

// Features of a row of a frame, `width` values each. A ReadRow fills them in.
struct FeatureRow {
  std::array<float*, 3> albedo;  // if all are 0, the colour is not divided by albedo
  std::array<float*, 3> normal;
  float* nearness;  // 1 / depth; 0 where nothing is hit
  float* samples;   // 0: the pixel's colour is invalid
  float* variance;  // variance of the mean's luminance; negative: unknown
};

// The filter keeps its memory between images. It filters one image at a time, on TBB's current
// arena. The result's bits do not depend on the number of threads.
class FastFilter {
 public:
  FastFilter();
  ~FastFilter();

  // The filter calls this function from several threads, once per row.
  using ReadRow = std::function<void(int y, const FeatureRow& row)>;

  // Level l reaches 2^l pixels; the total reach, 2^levels - 1, must fit into a plane's border.
  static constexpr int kMaxLevels = 5;
  static int levels_for(double samples_per_pixel);

  // Filters interleaved R G B A pixels; alpha is copied. Pixels that are not finite or have no
  // samples are replaced by the nearest valid pixel of their row.
  void filter(int width, int height, std::span<const float> rgba, const ReadRow& read, int levels,
              std::span<float> filtered);

  // Maximum memory per pixel.
  static constexpr uint64_t kBytesPerPixel = 17 * sizeof(float);

 private:
  class Planes;
  const std::unique_ptr<Planes> planes_;
};

}  // namespace emberline
