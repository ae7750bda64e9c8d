// What adaptive sampling is measured against: the picture itself, from two references, and the
// error of uniform sampling, pixel by pixel, from the spread of many frames.
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

// Two independent frames of many samples. Planes of pixels are interleaved R G B.
struct Reference {
  Floats a, b;
  Floats variance;     // of a sample, R G B, as if samples were independent
  Floats cost;         // seconds a sample, one a pixel
  double epsilon = 0;  // of relMSE

  double mean(size_t i) const { return 0.5 * (double(a[i]) + double(b[i])); }
  // What a channel's squared error counts for; of the display, about its curve's slope.
  double weight(Error error, size_t i) const;
};

// Renders it, or reads it from the file `cache` if there is one, which else is written unless it
// has no name. Throws RenderError if the file is of another frame.
Reference make_reference(const BenchFrame& frame, uint32_t spp, int threads,
                         const std::string& cache);

// How far frames of `spp` samples a pixel are from their mean: squared errors of one of them, by
// channel. Linear, and of what is displayed.
struct UniformErrors {
  Floats linear, shown;
};

// From uniform_frames(spp) frames, or from the file `cache`.SPP as make_reference() has it.
UniformErrors measure_uniform(const BenchFrame& frame, uint32_t spp, int threads,
                              const std::string& cache);
int uniform_frames(uint32_t spp);

// Mean over pixels and channels.
double mean_error(const UniformErrors& uniform, const Reference& reference, Error error);

// The Neyman limit (renderer/statistics/neyman_limit.h) of the reference's variances, which takes
// samples for independent.
double independent_limit(const Reference& reference, Error error);

// And of uniform frames as they are, of an error that falls with samples^-slope: what a better
// sharing-out alone could gain, by what stratification has left. The roots of what few frames say
// of a pixel are too small by a few per cent on average, for which it is corrected (as if their
// errors were normal; it stays too large where they are rarer and greater).
double stratified_limit(const UniformErrors& uniform, uint32_t spp, const Reference& reference,
                        Error error, double slope);

}  // namespace emberline::bench
