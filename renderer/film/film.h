// What a frame accumulates, pixel by pixel, and how it becomes channels.
//
// A FilmTile holds the running sums of a rectangle of pixels. Each pixel has one owner at a time,
// which adds its samples in index order, so equal sets of samples give equal bits whatever the
// schedule (law 2); nothing here locks. Sums are double: 2^25 samples of 0.1 stay exact to 1e-9.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "renderer/core/rect.h"
#include "renderer/core/vector.h"
#include "renderer/core/zeroed_array.h"
#include "renderer/film/cryptomatte_sums.h"
#include "renderer/film/film_channels.h"
#include "renderer/film/film_extras.h"
#include "renderer/film/half_sums.h"
#include "renderer/film/light_group_sums.h"
#include "renderer/film/path_layers.h"
#include "renderer/film/pixel_stop.h"
#include "renderer/film/sample_value.h"
#include "renderer/film/shadow_sums.h"

namespace emberline {

class Archive;

// A pixel's sums over its samples, each times its filter weight.
struct PixelSums {
  double rgb[2][3];  // by stream
  double alpha;
  uint32_t count[2];
  uint32_t non_finite;
  uint32_t id;

  double samples() const { return double(count[0]) + double(count[1]); }
};

class FilmTile {
 public:
  explicit FilmTile(const AovSet& aovs, const FilmExtras& extras = {})
      : aovs_(aovs),
        extras_(extras),
        light_groups_(extras.light_groups),
        path_layers_(PathLayers(aovs).empty() ? -1 : PathLayers(aovs).size()),
        shadows_(aovs.contains(Aov::kShadow)),
        halves_(aovs.contains(Aov::kDenoising), extras.light_groups),
        cryptomattes_(extras.cryptomattes, extras.cryptomatte_levels) {}

  // Clears to no samples over `rect`; keeps its memory. Of memory that is new, small pages are
  // taken by the samples that come to them, huge ones here (renderer/core/zeroed_array.h).
  void reset(const Rect& rect);
  const Rect& rect() const { return rect_; }
  const AovSet& aovs() const { return aovs_; }
  const FilmExtras& extras() const { return extras_; }

  // Adds sample value x filter weight. `half` (0 or 1) is the stream the sample belongs to. Returns
  // false, and counts the sample as black and non-finite, if the value is NaN or infinite.
  // `features` and `shares` come with the channels of `denoising`.
  bool add(int x, int y, int half, float filter_weight, const SampleValue& value,
           const DenoiserFeatures* features = nullptr, const SampleShares* shares = nullptr);
  // Asks for a pixel's sums ahead of add().
  void prefetch(int x, int y) const {
    const char* sums = reinterpret_cast<const char*>(&sums_[index(x, y)]);
    __builtin_prefetch(sums, 1);
    __builtin_prefetch(sums + sizeof(PixelSums) - 1, 1);
  }
  void prefetch_lights(int x, int y) const { light_groups_.prefetch(index(x, y)); }
  void prefetch_layers(int x, int y) const { path_layers_.prefetch(index(x, y)); }
  // What the light groups gave to the sample of a lane, which add() was given as well; nothing at
  // all, and alpha 0, for one that it refused.
  void add_lights(int x, int y, int half, float filter_weight, float alpha,
                  const LightGroupValues& values, int lane) {
    light_groups_.add(index(x, y), filter_weight, alpha, values, lane);
    if (half == 1) halves_.add_second_lights(index(x, y), filter_weight, values, lane);
  }
  // The same of the layers by light path, in the order of PathLayers.
  void add_layers(int x, int y, float filter_weight, float alpha, const LightGroupValues& values,
                  int lane) {
    path_layers_.add(index(x, y), filter_weight, alpha, values, lane);
  }
  // What a sample saw, which add() took: an id for each kind; `weight` is that of the filter times
  // the sample's alpha.
  void add_ids(int x, int y, float weight, std::span<const uint32_t> ids) {
    cryptomattes_.add(index(x, y), weight, ids);
  }
  // What shadow catchers received in a sample, which add() took.
  void add_catcher_sample(int x, int y, float filter_weight, const CatcherSample& sample) {
    shadows_.add(index(x, y), filter_weight, sample);
  }
  void add_time(int x, int y, double seconds);
  void add_rays(int x, int y, uint32_t rays);
  void set_stop(int x, int y, PixelStop stop);
  // Whether set_sample_variance() keeps what it is told.
  bool takes_sample_variance() const {
    return extras_.sample_variance && aovs_.contains(Aov::kVariance);
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
  uint32_t non_finite(int x, int y) const { return sums_[index(x, y)].non_finite; }
  PixelStop stop(int x, int y) const {
    return stops_.empty() ? PixelStop::kNone : stops_[index(x, y)];
  }
  Rgb mean(int x, int y) const;
  // Of the pixel's mean, as the `variance` channel has it: what the driver has told, else from the
  // difference of two streams, else as if samples were independent. Nothing where none of it is
  // known: with fewer than two samples, or neither two streams nor squares.
  std::optional<Rgb> variance(int x, int y) const;
  void rgba(int x, int y, float* out) const { put_rgba(index(x, y), out); }
  // Of a pixel with samples, what the channels `albedo`, `N` and `Z` say; nearness, 1 over the
  // depth, is 0 where nothing is hit. With at least one of the channels.
  struct Surface {
    float albedo[3], normal[3], nearness;
  };
  Surface surface(int x, int y) const;

  // By index, rows from rect().y0. The squares (three a pixel) and rays are null unless wanted.
  const PixelSums& sums(size_t i) const { return sums_[i]; }
  const double* squares() const { return squares_.begin(); }
  const uint32_t* rays() const { return rays_.begin(); }
  const LightGroupSums& light_groups() const { return light_groups_; }
  const LightGroupSums& path_layers() const { return path_layers_; }
  const HalfSums& halves() const { return halves_; }
  const ShadowSums& shadows() const { return shadows_; }
  const CryptomatteSums& cryptomattes() const { return cryptomattes_; }

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
  void show_lights(int x, int y, std::span<const Rgb> means) {
    light_groups_.show(index(x, y), means);
  }
  void show_layers(int x, int y, std::span<const Rgb> means) {
    path_layers_.show(index(x, y), means);
  }

  // The tile's channels in film_channels() order, interleaved, rows from rect().y0.
  void resolve(std::vector<float>& out) const;
  // R G B A only.
  void resolve_rgba(std::vector<float>& out) const;
  void resolve_rgba(std::span<float> out) const;

  uint64_t bytes() const;
  // All that it holds, exactly. A film that loads has been reset to the rectangle, and has the same
  // channels and extras. Throws InputError for what no samples add up to; then it is to be let go.
  void archive(Archive& archive);

 private:
  struct SurfaceSums {
    double albedo[3];
    double normal[3];
    double depth;
    uint32_t hits;

    void add(const SurfaceSums& more) {
      for (int c = 0; c < 3; ++c) albedo[c] += more.albedo[c];
      for (int c = 0; c < 3; ++c) normal[c] += more.normal[c];
      depth += more.depth;
      hits += more.hits;
    }
  };

  // Of the samples that hit a surface.
  struct PlaceSums {
    double position[3];
    double uv[2];
    uint32_t hits;

    void add(const PlaceSums& more) {
      for (int c = 0; c < 3; ++c) position[c] += more.position[c];
      for (int c = 0; c < 2; ++c) uv[c] += more.uv[c];
      hits += more.hits;
    }
  };

  // Of the samples that hit a surface, or where none did of those that did not.
  struct VelocitySums {
    double x, y;
    uint32_t count;
    uint32_t of_surfaces;  // 1 or 0

    void add(const VelocitySums& more) {
      if (more.of_surfaces > of_surfaces) *this = {0.0, 0.0, 0, 1};
      if (more.of_surfaces < of_surfaces) return;
      x += more.x;
      y += more.y;
      count += more.count;
    }
  };

  size_t index(int x, int y) const { return rect_.index_of(x, y); }
  bool wants_surface() const {
    return aovs_.contains(Aov::kAlbedo) || aovs_.contains(Aov::kNormal) ||
           aovs_.contains(Aov::kDepth);
  }
  bool wants_place() const { return aovs_.contains(Aov::kPosition) || aovs_.contains(Aov::kUv); }
  void put_rgba(size_t i, float* out) const;
  float* put_layers(size_t i, float* out) const;
  bool knows_sample_variance(size_t i) const {
    return !sample_variances_.empty() && sample_variances_[i].known;
  }
  double variance_of_mean(size_t i, size_t channel) const;
  void check(const Archive& archive) const;
  void add_means_of(const FilmTile& other, size_t i, double here, double there);

  AovSet aovs_;
  FilmExtras extras_;
  Rect rect_;
  uint32_t part_ = 0;
  ZeroedArray<PixelSums> sums_;
  ZeroedArray<double> squares_;           // 3 per pixel, if wanted
  ZeroedArray<uint32_t> rays_;            // if wanted
  ZeroedArray<SurfaceSums> surfaces_;     // with albedo, N or Z
  ZeroedArray<PlaceSums> places_;         // with P or UV
  ZeroedArray<VelocitySums> velocities_;  // with velocity
  ZeroedArray<double> clamped_;           // 3 per pixel, with clamped
  ZeroedArray<float> seconds_;            // with time
  ZeroedArray<PixelStop> stops_;          // with stop
  struct SampleVariance {
    float rgb[3];
    bool known;
  };
  ZeroedArray<SampleVariance> sample_variances_;  // if taken
  LightGroupSums light_groups_;
  LightGroupSums path_layers_;  // with any of those
  ShadowSums shadows_;          // with shadow
  HalfSums halves_;             // with denoising
  CryptomatteSums cryptomattes_;
  struct ShownValue {
    float rgba[4];
    bool set;
  };
  ZeroedArray<ShownValue> shown_;  // from the first show() on
};

// Puts the tile's channels into those of a frame that holds it, laid out as resolve() does it.
// Threads may do so side by side for tiles that have no pixel in common.
void put_channels(const FilmTile& tile, const Rect& frame, std::span<float> values);

}  // namespace emberline
