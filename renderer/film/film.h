// What a frame accumulates, pixel by pixel, and how it becomes channels.
//
// A FilmTile holds the running sums of a rectangle of pixels. Each pixel has one owner at a time,
// which adds its samples in index order, so equal sets of samples give equal bits whatever the
// schedule (law 2); nothing here locks. Sums are double: 2^25 samples of 0.1 stay exact to 1e-9.
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

  // Clears to no samples over `rect`; keeps its memory. Of memory that is new, small pages are
  // taken by the samples that come to them, huge ones here (renderer/core/zeroed_array.h).
  void reset(const Rect& rect);
  const Rect& rect() const { return rect_; }
  const AovSet& aovs() const { return layout_.contents().aovs; }
  const FilmExtras& extras() const { return layout_.contents().extras; }

  // Adds sample value x filter weight. Returns false, and counts the sample as black and
  // non-finite, if any of its values is NaN or infinite.
  bool add(int x, int y, const FilmSample& sample);
  // Asks for a pixel's memory ahead of add().
  void prefetch(int x, int y) const { layout_.prefetch(pixel(index(x, y))); }
  void add_time(int x, int y, double seconds);
  void set_stop(int x, int y, PixelStop stop);
  // Whether set_sample_variance() keeps what it is told.
  bool takes_sample_variance() const {
    return extras().sample_variance && aovs().contains(Aov::kVariance);
  }
  // Of pixel i, which has samples; R G B, finite: the variance that over the pixel's count is that
  // of its mean, from a driver that knows more of it than the film. It stands while samples are
  // added, until the next; what they bring is then taken to be as noisy as those before.
  void set_sample_variance(size_t i, const Rgb& variance);
  // Of a merged frame, which of its parts the tile came from, 1 the first.
  void set_part(uint32_t part) { part_ = part; }
  // Of every pixel by its count: kBudget if that is all of `budget`, kNone if it is 0, else
  // `cut_short`.
  void mark_stops(uint32_t budget, PixelStop cut_short);

  uint32_t sample_count(int x, int y) const;
  uint32_t least_samples() const;  // of any pixel
  uint32_t non_finite(int x, int y) const { return sums(index(x, y)).non_finite; }
  PixelStop stop(int x, int y) const {
    return layout_.has(Sums::kStop) ? *at<PixelStop>(Sums::kStop, index(x, y)) : PixelStop::kNone;
  }
  Rgb mean(int x, int y) const;
  // Of the pixel's mean, as the `variance` channel has it: what the driver has told, else from the
  // difference of two streams, else as if samples were independent. Nothing where none of it is
  // known: with fewer than two samples, or neither two streams nor squares.
  std::optional<Rgb> variance(int x, int y) const;
  void rgba(int x, int y, float* out) const { put_rgba(index(x, y), out); }
  void put_rgba(size_t i, float* out) const;
  void put_layer(size_t i, PathLayer layer, float* rgb) const;
  double variance_of_mean(size_t i, size_t channel) const;
  uint32_t part() const { return part_; }
  // Of a pixel with samples, what the channels `albedo`, `N` and `Z` say; nearness, 1 over the
  // depth, is 0 where nothing is hit. With at least one of the channels.
  struct Surface {
    float albedo[3], normal[3], nearness;
  };
  Surface surface(int x, int y) const;

  // By index, rows from rect().y0; of a film that has the block.
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

  // Forgets what show() was told.
  void show_means() { shown_.reset(0); }
  // Copies what a pixel of another tile with the same channels has gathered, and what it shows.
  void copy_pixel(const FilmTile& from, int x, int y);
  // Adds the samples of another film of the same pixels, channels and extras, which have nothing to
  // do with those here; what was shown instead of means, too, weighted by samples.
  void add_film(const FilmTile& other);
  // What the pixel's R G B A are to be instead of the mean of its samples: its neighbours' where it
  // has none, or another average of them. The other channels, and its count, stay what they are.
  void show(int x, int y, const float* rgba);
  // The same of the means of the light groups, for a pixel that has no samples.
  void show_lights(int x, int y, std::span<const Rgb> means) { lights(index(x, y)).show(means); }
  void show_layers(int x, int y, std::span<const Rgb> means) { layers(index(x, y)).show(means); }

  // The tile's channels in film_channels() order, interleaved, rows from rect().y0; with room for
  // `more` values behind those of each pixel.
  void resolve(std::vector<float>& out, size_t more = 0) const;
  // R G B A only.
  void resolve_rgba(std::vector<float>& out) const;
  void resolve_rgba(std::span<float> out) const;

  uint64_t bytes() const;
  // All that it holds, exactly. A film that loads has been reset to the rectangle, and has the same
  // channels and extras. Throws InputError for what no samples add up to; then it is to be let go.
  void archive(Archive& archive);

 private:
  struct SampleVariance {
    float rgb[3];
    bool known;
  };
  struct ShownValue {
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
  bool knows_sample_variance(size_t i) const {
    return !sample_variances_.empty() && sample_variances_[i].known;
  }
  void resolve_row(const ChannelRow& row, std::span<float> out, size_t stride) const;
  void check(const Archive& archive) const;
  void add_means_of(const FilmTile& other, size_t i, double here, double there);

  FilmLayout layout_;
  PathLayers layers_;
  Rect rect_;
  uint32_t part_ = 0;
  ZeroedArray<std::byte> buffer_;
  std::vector<std::byte*> planes_;                // of the buffer, by the layout's parts
  PixelSums* sums_ = nullptr;                     // the first of them
  ZeroedArray<SampleVariance> sample_variances_;  // if taken
  ZeroedArray<ShownValue> shown_;                 // from the first show() on
};

// Puts the tile's channels into those of a frame that holds it, laid out as resolve() does it.
// Threads may do so side by side for tiles that have no pixel in common.
void put_channels(const FilmTile& tile, const Rect& frame, std::span<float> values);

}  // namespace emberline
