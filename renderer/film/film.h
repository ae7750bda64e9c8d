// A film: the running sums of a rectangle of pixels, and the code that turns them into channels.
//
// Each pixel has one owner at a time, which adds its samples in index order. So pixels with the
// same samples are bit-identical, whatever the schedule (law 2). There are no locks. Sums are
// double: the sum of 2^25 samples of 0.1 is exact to 1e-9.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "renderer/core/rect.h"
#include "renderer/core/vector.h"
#include "renderer/core/zeroed_array.h"
#include "renderer/film/cryptomatte_sums.h"
#include "renderer/film/film_layout.h"
#include "renderer/film/film_sample.h"
#include "renderer/film/half_sums.h"
#include "renderer/film/path_layers.h"
#include "renderer/film/pixel_stop.h"

namespace emberline {

class Archive;

class FilmTile {
 public:
  explicit FilmTile(const AovSet& aovs, const FilmExtras& extras = {})
      : layout_({aovs, extras}), layers_(aovs) {}

  // Resets the film to empty pixels over `rect`, and keeps the film's memory. New memory is
  // committed on first use if it has small pages, and by this call if it has huge pages
  // (renderer/core/zeroed_array.h).
  void reset(const Rect& rect);
  const Rect& rect() const { return rect_; }
  const AovSet& aovs() const { return layout_.contents().aovs; }
  const FilmExtras& extras() const { return layout_.contents().extras; }

  // Adds the sample's value times its filter weight. If any value of the sample is NaN or infinite,
  // returns false and counts the sample as black and non-finite.
  bool add(int x, int y, const FilmSample& sample);
  void prefetch(int x, int y) const { layout_.prefetch(pixel(index(x, y))); }
  void add_time(int x, int y, double seconds);
  // `judged` is the index, in the setting `judge`, of the channel that needed the pixel's last
  // samples. It is below kMaxJudged.
  void set_stop(int x, int y, PixelStop stop, uint32_t judged = 0);
  // Whether set_sample_variance() has an effect.
  bool stores_sample_variance() const {
    return extras().sample_variance && aovs().contains(Aov::kVariance);
  }
  // Sets the per-sample variance of pixel i; the variance of the mean is this value divided by the
  // sample count. The value must be finite, and the pixel must have samples. A driver calls this if
  // it knows the variance better than the film does. The value holds until the next call, so later
  // samples are assumed to be as noisy as earlier ones.
  void set_sample_variance(size_t i, const Rgb& variance);
  // Sets the part of a merged frame that the tile comes from; the first part is 1.
  void set_part(uint32_t part) { part_ = part; }
  // Sets each pixel's stop reason according to its sample count: `complete` for `budget` samples,
  // kNone for 0, otherwise `unfinished`.
  void mark_stops(uint32_t budget, PixelStop complete, PixelStop unfinished);

  uint32_t sample_count(int x, int y) const;
  uint32_t min_samples() const;  // minimum over the pixels
  uint32_t non_finite(int x, int y) const { return sums(index(x, y)).non_finite; }
  PixelStop stop(int x, int y) const {
    return layout_.has(Sums::kStop) ? reason_of(*at<uint8_t>(Sums::kStop, index(x, y)))
                                    : PixelStop::kNone;
  }
  Rgb mean(int x, int y) const;
  // Returns the variance of the pixel's mean, as in the `variance` channel. This is the driver's
  // value if the driver set one. Otherwise, it is estimated from the difference of the two streams
  // or, with one stream, as if samples were independent. The result is empty if the variance is
  // unknown: with fewer than two samples, or with neither two streams nor squares.
  std::optional<Rgb> variance(int x, int y) const;
  void rgba(int x, int y, float* out) const { put_rgba(index(x, y), out); }
  void put_rgba(size_t i, float* out) const;
  void put_layer(size_t i, PathLayer layer, float* rgb) const;
  // Writes the values of a row of film_channels().
  void put_row(const ChannelRow& row, size_t i, float* values) const;
  // Returns the fraction of the pixel's samples that determine the values of put_row(): the samples
  // that hit a surface, the samples that see a catcher or the background, or all samples.
  double share_of_samples(const ChannelRow& row, size_t i) const;
  double variance_of_mean(size_t i, size_t channel) const;
  uint32_t part() const { return part_; }
  // Means for the channels `albedo`, `N` and `Z`. The pixel must have samples, and the film must
  // have at least one of these channels. nearness is 1 / depth, or 0 where nothing was hit.
  struct Surface {
    float albedo[3], normal[3], nearness;
  };
  Surface surface(int x, int y) const;

  // The following functions take a pixel index, which counts row by row from rect().y0. The film
  // must have the block that a function reads.
  bool has(Sums block) const { return layout_.has(block); }
  template <class T>
  const T* block(Sums block, size_t i) const {
    return at<T>(block, i);
  }
  const PixelSums& sums(size_t i) const { return sums_[i]; }
  const double* squares(size_t i) const { return at<double>(Sums::kSquares, i); }
  uint32_t rays(size_t i) const { return *at<uint32_t>(Sums::kRays, i); }
  LightGroupSums lights(size_t i) const { return lights_of(Sums::kLights, i); }
  LightGroupSums second_lights(size_t i) const { return lights_of(Sums::kHalfLights, i); }
  LightGroupSums layers(size_t i) const { return lights_of(Sums::kLayers, i); }
  const HalfSums& halves(size_t i) const { return *at<HalfSums>(Sums::kHalves, i); }
  CryptomatteSums mattes(size_t i) const { return mattes_at(layout_, pixel(i)); }

  // Undoes all calls of set_override().
  void clear_overrides() { overrides_.reset(0); }
  // Copies the sums and the override of a pixel from a tile with the same channels.
  void copy_pixel(const FilmTile& from, int x, int y);
  // Adds the samples of another film, which must be independent of this film's. The films must have
  // the same pixels, channels and extras. Overrides are averaged, each weighted by its sample
  // count.
  void add_film(const FilmTile& other);
  // Overrides the R G B A of a pixel, for pixels that are filled in from their neighbours or whose
  // samples are not simply averaged. The other channels and the sample count do not change.
  void set_override(int x, int y, const float* rgba);
  // Sets the means of the light groups of a pixel without samples.
  void override_lights(int x, int y, std::span<const Rgb> means) {
    lights(index(x, y)).set_override(means);
  }
  void override_layers(int x, int y, std::span<const Rgb> means) {
    layers(index(x, y)).set_override(means);
  }

  // Writes the channels in film_channels() order, interleaved, rows from rect().y0. Leaves room for
  // `more` values after the channels of each pixel.
  void resolve(std::vector<float>& out, size_t more = 0) const;
  void resolve_rgba(std::vector<float>& out) const;
  void resolve_rgba(std::span<float> out) const;

  uint64_t bytes() const;
  // Saves or loads all sums exactly. Before loading, the film must have been reset to the saved
  // rectangle, and it must have the same channels and extras. Throws InputError for invalid sums;
  // the film is then unusable.
  void archive(Archive& archive);

 private:
  struct SampleVariance {
    float rgb[3];
    bool known;
  };
  struct ValueOverride {
    float rgba[4];
    bool set;
  };

  size_t index(int x, int y) const { return rect_.index_of(x, y); }
  size_t pixels() const { return size_t(rect_.area()); }
  FilmPixel pixel(size_t i) const { return {planes_.data(), i}; }
  template <class T>
  T* at(Sums block, size_t i) const {
    assert(layout_.has(block) && i < pixels());
    return sums_at<T>(layout_.part(block), pixel(i));
  }
  LightGroupSums lights_of(Sums block, size_t i) const {
    return lights_at(layout_, block, pixel(i));
  }
  bool has_sample_variance(size_t i) const {
    return !sample_variances_.empty() && sample_variances_[i].known;
  }
  void check(const Archive& archive) const;
  void merge_overrides(const FilmTile& other, size_t i, double own_weight, double other_weight);

  FilmLayout layout_;
  PathLayers layers_;
  Rect rect_;
  uint32_t part_ = 0;
  ZeroedArray<std::byte> buffer_;
  std::vector<std::byte*> planes_;                // start of each part's plane in the buffer
  PixelSums* sums_ = nullptr;                     // the first plane
  ZeroedArray<SampleVariance> sample_variances_;  // empty unless stores_sample_variance()
  ZeroedArray<ValueOverride> overrides_;          // allocated by the first set_override()
};

// Copies the tile's channels into `values`, which holds the channels of a frame that contains the
// tile, in the layout of resolve(). Tiles that do not overlap may be copied concurrently.
void put_channels(const FilmTile& tile, const Rect& frame, std::span<float> values);

}  // namespace emberline
