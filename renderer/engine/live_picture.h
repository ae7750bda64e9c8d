// The picture of a frame while it renders.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "renderer/core/rect.h"
#include "renderer/core/vector.h"
#include "renderer/film/pixel_stop.h"

namespace emberline {

class FilmTile;
class LightMix;
struct RenderPlan;

// The frame as it can be displayed while it renders. It never has holes: pixels without samples are
// filled in from their neighbours. Coordinates are pixels of the frame inside rect().
class LivePicture {
 public:
  virtual ~LivePicture() = default;
  // Writes interleaved R G B A of every pixel of the crop, top row first. For frames with light
  // groups, `mix` weights each group (renderer/film/light_mix.h).
  virtual void resolve(std::span<float> rgba, const LightMix* mix = nullptr) const = 0;
  virtual const FilmTile& film() const = 0;
  // Says why the pixel gets no more samples. Returns kUnfinished as long as the driver may still
  // give it samples, even after a stop request.
  virtual PixelStop current_stop(int x, int y) const = 0;

  const Rect& rect() const;
  uint32_t sample_count(int x, int y) const;
  // Number of samples that were NaN or infinite. They count as black.
  uint32_t non_finite(int x, int y) const;
  // Returns the variance of the pixel's mean, in squared linear radiance, or nothing if the film
  // does not record it.
  std::optional<Rgb> variance(int x, int y) const;
  // Returns all channels of the film in the order of film_channels(), interleaved, top row first.
  std::vector<float> channels() const;
};

// Collects the finished tiles of a tiled driver, which does not keep them, and draws them over an
// earlier picture. Not thread-safe.
class TilePicture final : public LivePicture {
 public:
  // `before` is the earlier picture: R G B A of each pixel of the plan's crop. Throws RenderError
  // if there is not enough memory for the film.
  TilePicture(const RenderPlan& plan, std::vector<float> before);
  ~TilePicture() override;
  static uint64_t bytes_per_pixel(const RenderPlan& plan);

  // Adds a tile. Returns its rectangle.
  Rect add(const FilmTile& tile);
  uint64_t samples() const { return samples_; }
  double completion() const { return double(pixels_) / double(rect().area()); }
  std::span<const float> rgba() const { return rgba_; }

  // Mixes the light groups on the calling thread.
  void resolve(std::span<float> rgba, const LightMix* mix = nullptr) const override;
  const FilmTile& film() const override { return *film_; }
  // Returns kUnfinished for pixels outside the added tiles. For other pixels, returns kNone if the
  // tiles have no `stop` channel.
  PixelStop current_stop(int x, int y) const override;

 private:
  const std::unique_ptr<FilmTile> film_;
  const bool overrides_means_;  // displayed values may differ from the film's means
  std::vector<float> rgba_;
  int64_t pixels_ = 0;
  uint64_t samples_ = 0;
};

}  // namespace emberline
