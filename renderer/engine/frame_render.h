// The one loop that renders: asks a driver what comes next, has workers carry it out, pauses where
// a picture is wanted, tells the observer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "renderer/core/archive.h"
#include "renderer/drivers/driver_table.h"
#include "renderer/drivers/frame.h"
#include "renderer/drivers/frame_driver.h"
#include "renderer/engine/frame_observer.h"
#include "renderer/film/film.h"

namespace emberline {

class RenderWorker;
class TileOwner;

// What becomes of a tile beside its film.
struct TileResult {
  std::optional<double> error = {};  // estimated, of the displayed tile
  uint32_t least_samples = 0;        // of any pixel
  FrameCounters counters = {};

  void archive(Archive& archive);
};

// The state of finished tiles, kept elsewhere so that nobody need render them again. Called from
// worker threads, concurrently, of each tile once. Tiles are numbered row by row.
class TileStore {
 public:
  virtual ~TileStore() = default;
  // What save() was given, of at most so many bytes; nothing: the tile is to be rendered.
  virtual std::optional<std::vector<std::byte>> load(size_t tile, uint64_t most) = 0;
  // A TileResult, the film, the driver's state.
  virtual void save(size_t tile, std::span<const std::byte> state) = 0;
  // The same of an equal frame of fewer samples, which is finished and goes on in this one.
  virtual std::optional<std::vector<std::byte>> load_finished(size_t /*tile*/, uint64_t /*most*/) {
    return std::nullopt;
  }
  // What load() or load_finished() gave cannot be used: the tile is rendered.
  virtual void unusable(bool /*finished*/) {}
};

// One frame with one driver. A driver of tiles hands them to the observer as they are finished, and
// keeps nothing; another's film is kept, and is the picture.
class FrameRender final : public FramePicture {
 public:
  explicit FrameRender(DriverFactory drivers) : drivers_(std::move(drivers)) {}

  // Before render(). Of tiles: those that `store` has are not rendered, and it is given the others.
  void keep_tiles(TileStore* store) { store_ = store; }
  // Before render(), of one film: makes it, for save(), load() and extend(). Decisions are then
  // made to their end when a stop is requested, since amid one there is nothing to save.
  void resumable(const Frame& frame);
  // Goes on from what save() has saved of an equal frame, to the same bits. Throws InputError for
  // what it cannot have saved.
  void load(std::span<const std::byte> state);
  // The same of an equal frame of fewer samples, or a higher threshold, which is finished.
  void extend(std::span<const std::byte> finished);
  // At any call of picture_changed() and cut_short(), and after render(): a TileResult of the
  // whole, whether it is finished, the film, the driver's state, and how far it is.
  void save(std::vector<std::byte>& state);

  // Renders on the calling thread's TBB arena; once. Returns soon after a stop is requested. Throws
  // RenderError where the film does not fit into memory, and what the observer throws.
  FrameCounters render(const Frame& frame, FrameObserver& observer, std::stop_token stop);
  // After render(): writes into a film that was kept why its pixels stopped; those that a stop
  // request cut short, because of `cut_short`.
  void end(PixelStop cut_short);
  // After render(), once: end(), then hands over the film that was kept as finished tiles.
  void deliver(FrameObserver& observer);

  const FrameCounters& counters() const { return counters_; }
  // Expected RMS error of the displayed frame, if the driver has estimated it.
  std::optional<double> error_estimate() const;
  // The frame as it can be shown, from the first pause on; null if nothing is kept.
  const FramePicture* picture() const { return driver_ ? this : nullptr; }
  // The driver's, while picture() is there.
  DriverFacts facts() const { return driver_->facts(); }
  std::string explain(int x, int y) const { return driver_->explain(*film_, x, y); }
  void follow(int x, int y) { driver_->follow(x, y); }
  // Tiles are handed on, and nothing is kept.
  bool by_tiles() const { return drivers_.tiles; }
  // A time limit ends a frame as --spp does, but where the driver finishes it part by part: then
  // parts of it have nothing.
  bool is_complete(const FrameCounters& counters, PixelStop cause) const {
    return !counters.stopped || (cause == PixelStop::kTimeLimit && !by_tiles());
  }

  // What load() takes of a tile whose film holds so much, at most.
  static uint64_t most_of_state(uint64_t film_bytes) { return 4 * film_bytes + (1 << 16); }
  // What render() and deliver() hold of each pixel of the crop beside their workers' tiles, at
  // most; with light groups 24 for each and 24 more. And what is held by now.
  uint64_t bytes_per_pixel(const AovSet& aovs) const;
  // Of each pixel of a worker's tile.
  uint64_t tile_bytes_per_pixel(const AovSet& aovs) const;
  uint64_t film_bytes() const { return driver_ ? film_->bytes() + driver_->bytes() : 0; }

  void resolve(std::span<float> rgba, const LightMix* mix = nullptr) const override {
    driver_->resolve(*film_, rgba, mix);
  }
  const FilmTile& film() const override { return *film_; }
  PixelStop stop_so_far(int x, int y) const override { return driver_->stop_so_far(*film_, x, y); }

 private:
  class Loop;

  void render_tiles(Loop& loop);
  void render_crop(Loop& loop);
  void render_tile(Loop& loop, TileOwner& owner, RenderWorker& worker, FrameDriver& driver,
                   FilmTile& film, TileResult& result);
  void save_tile(const Rect& crop, FrameDriver& driver, FilmTile& film, TileResult& result);
  bool load_tile(Loop& loop, const Rect& tile, FilmTile& film, TileResult& result);
  std::unique_ptr<FrameDriver> begin_tile(Loop& loop, const Rect& tile, FilmTile& film,
                                          TileResult& result);
  void begin(const Frame& frame);
  std::vector<Rect> tiles_of(const Frame& frame) const;
  void archive(Archive& archive);

  const DriverFactory drivers_;
  std::optional<FilmTile> film_;
  std::unique_ptr<FrameDriver> driver_;
  FrameCounters counters_;
  std::optional<double> tiles_error_;
  TileStore* store_ = nullptr;
  bool resumable_ = false;
  // Of a frame of one film: the parts of the round under way that are done, and whether pixels of
  // later ones may have samples already.
  size_t parts_done_ = 0;
  bool film_is_ahead_ = false;
};

// Root of the mean square over the tiles' pixels, added in this order; nothing where one is
// unknown.
std::optional<double> error_of_tiles(std::span<const Rect> tiles,
                                     std::span<const std::optional<double>> errors);

// What a film holds of a pixel, in bytes, and deliver() on top where it fills in.
// What deliver() takes of a film whose pixels do not all have a sample, for so many layers or
// lights: each as it is shown, and a picture that they are taken from.
uint64_t shown_layer_bytes_per_pixel(size_t layers);

uint64_t film_bytes_per_pixel(const AovSet& aovs, const FilmExtras& extras);

// Makes the film ready for the crop. Throws RenderError if there is not the memory for it.
void reset_film(const Rect& crop, FilmTile* film);

}  // namespace emberline
