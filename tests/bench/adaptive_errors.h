// References for measuring adaptive sampling: the picture from two independent frames, and the
// error of uniform sampling per pixel from the variance of many frames.
#pragma once

#include <algorithm>
#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "bench/bench_frame.h"
#include "renderer/engine/render_sink.h"
#include "renderer/film/film.h"

namespace emberline::bench {

using Floats = std::vector<float>;

enum Error : int { kMse, kRelMse, kDisplay, kErrors };
inline constexpr const char* kErrorNames[] = {"mse", "relmse", "display"};

// Keeps a frame's channels, interleaved.
class ImageSink final : public RenderSink {
 public:
  ImageSink(const BenchFrame& frame, const AovSet& aovs)
      : width_(frame.width()), channels_(film_channels(aovs).size()) {
    values.resize(frame.pixels() * channels_);
  }
  void tile_finished(const FilmTile& tile) override {
    std::vector<float> pixels;
    tile.resolve(pixels);
    const Rect& r = tile.rect();
    const std::lock_guard lock(mutex_);
    for (int y = r.y0; y < r.y1; ++y) {
      const size_t row = size_t(r.width()) * channels_;
      std::copy_n(&pixels[size_t(y - r.y0) * row], row,
                  &values[(size_t(y) * size_t(width_) + size_t(r.x0)) * channels_]);
    }
  }
  Floats plane(size_t channel) const {
    Floats out(values.size() / channels_);
    for (size_t i = 0; i < out.size(); ++i) out[i] = values[i * channels_ + channel];
    return out;
  }
  Floats rgb() const {
    Floats out;
    for (size_t i = 0; i < values.size(); i += channels_) {
      out.insert(out.end(), &values[i], &values[i] + 3);
    }
    return out;
  }
  Floats values;

 private:
  const int width_;
  const size_t channels_;
  std::mutex mutex_;
};

// Two independent frames of many samples. Pixels are interleaved R G B.
struct Reference {
  Floats a, b;
  Floats variance;     // of a sample, R G B, as if samples were independent
  Floats cost;         // seconds per sample, one value per pixel
  double epsilon = 0;  // of relMSE

  double mean(size_t i) const { return 0.5 * (double(a[i]) + double(b[i])); }
  // Returns the weight of a channel's squared error. For the display error, it is the squared slope
  // of the display's curve.
  double weight(Error error, size_t i) const;
};

// Reads the reference from the file `cache`, or renders it and writes the file. An empty name means
// no cache. Throws RenderError if the file is for another frame.
Reference make_reference(const BenchFrame& frame, uint32_t spp, int threads,
                         const std::string& cache);

// Squared errors of a frame of `spp` samples per pixel, for each channel: linear, and as displayed.
struct UniformErrors {
  Floats linear, display;
};

// Computes the errors from uniform_frames(spp) frames, or reads them from the file `cache`.SPP.
UniformErrors measure_uniform(const BenchFrame& frame, uint32_t spp, int threads,
                              const std::string& cache);
int uniform_frames(uint32_t spp);

// Returns the mean error over pixels and channels.
double mean_error(const UniformErrors& uniform, const Reference& reference, Error error);

// Returns the Neyman limit (renderer/statistics/neyman_limit.h) of the reference's variances, for
// independent samples.
double independent_limit(const Reference& reference, Error error);

// Returns the limit for the measured errors of uniform frames, which fall as samples^-slope. It is
// the gain that better allocation alone could reach on top of stratification. Roots of variances
// from few frames are a few per cent too small on average. The limit is corrected for this as if
// errors were normal, and remains too large where errors are rare and large.
double stratified_limit(const UniformErrors& uniform, uint32_t spp, const Reference& reference,
                        Error error, double slope);

}  // namespace emberline::bench
