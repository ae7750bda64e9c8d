// One frame that is rendered: asks a driver what comes next, has workers carry it out, pauses where
// a picture is wanted, tells the sink. Whatever renders does it through here.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "renderer/core/archive.h"
#include "renderer/drivers/driver_table.h"
#include "renderer/drivers/frame.h"
#include "renderer/drivers/frame_driver.h"
#include "renderer/engine/render_sink.h"
#include "renderer/film/sample_value.h"

namespace emberline {

class RenderLoop;
class RenderWorker;
class TileOwner;

// What becomes of a tile beside its film.
struct TileResult {
  std::optional<double> error = {};  // estimated, of the displayed tile
  uint32_t least_samples = 0;        // of any pixel
  RenderCounters counters = {};

  void archive(Archive& archive);
};

// Keeps the state of finished tiles, so that a later run need not render them again. Called from
// worker threads, concurrently, for each tile once. Tiles are numbered row by row.
class TileStore {
 public:
  virtual ~TileStore() = default;
  // What save() was given, of at most `most` bytes; nothing: the tile is to be rendered.
  virtual std::optional<std::vector<std::byte>> load(size_t tile, uint64_t most) = 0;
  // `state`: a TileResult, the film, the driver's state.
  virtual void save(size_t tile, std::span<const std::byte> state) = 0;
  // The same for an equal frame of fewer samples, which is finished and goes on in this one.
  virtual std::optional<std::vector<std::byte>> load_finished(size_t /*tile*/, uint64_t /*most*/) {
    return std::nullopt;
  }
  // What load() or load_finished() gave cannot be used: the tile is rendered.
  virtual void unusable(bool /*finished*/) {}

  // The most that load() takes for a tile whose film has `film_bytes`.
  static uint64_t most_of_state(uint64_t film_bytes) { return 4 * film_bytes + (1 << 16); }
};

struct RenderResult {
  RenderCounters counters;
  // All was done, or the frame has a picture that a time limit has ended; then that counts as all.
  // A frame of tiles has no picture before its last tile.
  bool complete = false;
};

// One sample of a frame alone, exactly as render() computes it.
struct SampleReplay {
  SampleValue value;
  Ray camera_ray;  // in internal space
  RayCounters rays;
};

// A driver of tiles hands them to the sink as they are finished, and nothing is kept; another's
// film is kept, and is the picture. Made by RenderPlan::prepare(), or of a frame and the drivers
// that make it. What the frame refers to must outlive the job.
class RenderJob final : public LivePicture {
 public:
  RenderJob(Frame frame, DriverFactory drivers);
  RenderJob(const RenderJob&) = delete;  // its driver refers to its frame
  RenderJob& operator=(const RenderJob&) = delete;
  ~RenderJob() override;

  const Frame& frame() const { return frame_; }
  bool by_tiles() const { return drivers_.tiles; }

  // Before render(), by tiles: those that `store` has are not rendered, and it is given the others.
  void keep_tiles(TileStore* store) { store_ = store; }
  // Before render(), of one film: makes it, for save(), load() and extend(). Decisions are then
  // made to their end when a stop is requested, since amid one there is nothing to save.
  void make_resumable();
  // Goes on from what save() has saved of an equal frame, to the same bits. Throws InputError for
  // what it cannot have saved.
  void load(std::span<const std::byte> state);
  // The same for an equal frame of fewer samples, or a higher threshold, which is finished.
  void extend(std::span<const std::byte> finished);
  // At any call of picture_changed() and cut_short(), and after render(): a TileResult of the
  // whole, whether it is finished, the film, the driver's state, and how far it is.
  void save(std::vector<std::byte>& state);

  // Renders on the calling thread's TBB arena; once. Returns soon after a stop is requested. Throws
  // RenderError where the film does not fit into memory, and what the sink throws.
  RenderResult render(RenderSink& sink, std::stop_token stop);
  // After render(): writes into a film that was kept why its pixels stopped; those that a stop
  // request cut short, because of `cut_short`.
  void end(PixelStop cut_short);
  // After render(), once: end(), then hands over the film that was kept as finished tiles.
  void deliver(RenderSink& sink);

  // What render() and deliver() hold of each pixel of the crop beside workers' tiles, at most; 0 by
  // tiles.
  uint64_t kept_bytes_per_pixel() const;
  // Held by now.
  uint64_t film_bytes() const;

  SampleReplay replay(int x, int y, uint32_t sample) const;

  // So far.
  const RenderCounters& counters() const { return counters_; }
  // Expected RMS error of the displayed frame, if the driver has estimated it; end() of a frame
  // that was stopped may do so.
  std::optional<double> error_estimate() const;
  // The frame as it can be shown, from the first pause on; null if nothing is kept.
  const LivePicture* picture() const { return driver_ ? this : nullptr; }
  // The driver's, while picture() is there.
  DriverFacts facts() const { return driver_->facts(); }
  std::string explain(int x, int y) const { return driver_->explain(*film_, x, y); }
  void follow(int x, int y) { driver_->follow(x, y); }

  void resolve(std::span<float> rgba, const LightMix* mix = nullptr) const override {
    driver_->resolve(*film_, rgba, mix);
  }
  const FilmTile& film() const override { return *film_; }
  PixelStop stop_so_far(int x, int y) const override { return driver_->stop_so_far(*film_, x, y); }

 private:
  FilmExtras film_extras() const { return frame_.with_light_groups(drivers_.film_extras); }
  void begin();
  void archive(Archive& archive);
  void render_crop(RenderLoop& loop);

  // render_tiles.cpp
  void render_tiles(RenderLoop& loop);
  void render_tile(RenderLoop& loop, TileOwner& owner, RenderWorker& worker, FrameDriver& driver,
                   FilmTile& film, TileResult& result);
  void save_tile(FrameDriver& driver, FilmTile& film, TileResult& result);
  bool load_tile(RenderLoop& loop, const Rect& tile, FilmTile& film, TileResult& result);
  std::unique_ptr<FrameDriver> begin_tile(RenderLoop& loop, const Rect& tile, FilmTile& film,
                                          TileResult& result);
  std::vector<Rect> tiles() const;

  const Frame frame_;
  const DriverFactory drivers_;
  std::unique_ptr<FilmTile> film_;
  std::unique_ptr<FrameDriver> driver_;
  RenderCounters counters_;
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

}  // namespace emberline
