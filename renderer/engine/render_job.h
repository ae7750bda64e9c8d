// Renders one frame: gets rounds from a driver, shares them among workers, pauses when a picture is
// due, and calls the sink. All clients render with it.
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

class FrameBudget;
class RenderLoop;
class RenderWorker;
class TileBudget;
class TileCost;
class TileOwner;

// Facts about a finished tile that are not in its film.
struct TileResult {
  std::optional<double> error = {};  // estimated error of the displayed tile
  uint32_t min_samples = 0;          // minimum over the tile's pixels
  RenderCounters counters = {};

  void archive(Archive& archive);
};

// Stores the state of finished tiles for a later run. Worker threads call these functions
// concurrently, once per tile. Tiles are numbered row by row.
class TileStore {
 public:
  virtual ~TileStore() = default;
  // Returns the state that was passed to save(), at most `max_bytes` bytes, or nullopt if the tile
  // must be rendered.
  virtual std::optional<std::vector<std::byte>> load(size_t tile, uint64_t max_bytes) = 0;
  // `state` consists of a TileResult, the film and the driver's state.
  virtual void save(size_t tile, std::span<const std::byte> state) = 0;
  // Returns the tile's state from the finished frame that this frame extends. That frame has fewer
  // samples.
  virtual std::optional<std::vector<std::byte>> load_finished(size_t /*tile*/, uint64_t /*most*/) {
    return std::nullopt;
  }
  // Called if a state is unusable. If `finished` is true, this is the state from load_finished(),
  // otherwise the state from load(). The tile is then rendered.
  virtual void report_unusable(bool /*finished*/) {}

  // The largest state that a job accepts from load() for a tile whose film has `film_bytes` bytes.
  static uint64_t max_state_bytes(uint64_t film_bytes) { return 4 * film_bytes + (1 << 16); }
};

struct RenderResult {
  RenderCounters counters;
  // True if all samples were rendered. Also true if a time limit ended a frame with one film,
  // because pixels without samples are then filled in from their neighbours.
  bool complete = false;
  uint64_t unsampled_pixels = 0;  // number of requested pixels without a sample
};

// A single sample, exactly as render() computes it.
struct SampleReplay {
  SampleValue value;
  Ray camera_ray;  // in the scene's internal space (rebased coordinates)
  RayCounters rays;
};

// Renders one frame. With a tiled driver, it passes each finished tile to the sink and keeps
// nothing; otherwise it keeps one film, which is the picture. RenderPlan::prepare() creates jobs.
// Everything that the frame refers to must outlive the job.
class RenderJob final : public LivePicture {
 public:
  RenderJob(Frame frame, DriverFactory drivers);
  RenderJob(const RenderJob&) = delete;  // the driver refers to frame_
  RenderJob& operator=(const RenderJob&) = delete;
  ~RenderJob() override;

  const Frame& frame() const { return frame_; }
  bool is_tiled() const { return drivers_.tiles; }

  // Makes render() of a tiled job load the tiles that are in `store`, and render and store the
  // other tiles. Call this before render().
  void set_tile_store(TileStore* store) { store_ = store; }
  // Makes a job with one film resumable. Call this before render(), save(), load() and extend(). A
  // resumable job finishes the driver's current decision even after a stop request, because a
  // decision cannot be saved halfway.
  void make_resumable();
  // Resumes a frame with the same settings from a state that save() wrote. The result is
  // bit-identical to that of an uninterrupted render. Throws InputError for an invalid state.
  void load(std::span<const std::byte> state);
  // Starts from the state of a finished frame with fewer samples or a higher threshold.
  void extend(std::span<const std::byte> finished);
  // Saves a TileResult, a flag that tells whether the frame is finished, the film, the driver's
  // state and the number of finished parts in its round. May be called in picture_changed(), in
  // interrupted() and after render().
  void save(std::vector<std::byte>& state);

  // Renders on the calling thread's TBB arena. May be called only once. Returns soon after a stop
  // request. Throws RenderError if the film does not fit into memory, and also rethrows what the
  // sink throws.
  RenderResult render(RenderSink& sink, std::stop_token stop);
  // Call this after render(). If the film is kept, records in it why each pixel got no more
  // samples. The reason is `interrupted` for pixels that a stop request cut short.
  void end(PixelStop interrupted);
  // Call this once, after render(). It calls end() and, if the film is kept, passes it to the sink
  // as finished tiles.
  void deliver(RenderSink& sink);

  // Returns the maximum bytes kept per pixel of the crop; 0 for tiled drivers. Excludes workers'
  // tiles and the bytes that deliver() adds for layers (delivery_bytes_per_pixel()).
  uint64_t job_bytes_per_pixel() const;
  // Returns the present memory of the film and the driver, in bytes.
  uint64_t film_bytes() const;

  SampleReplay replay(int x, int y, uint32_t sample) const;

  const RenderCounters& counters() const { return counters_; }
  // Returns the expected RMS error of the displayed frame, if the driver has estimated it. For a
  // stopped frame, end() may make the estimate.
  std::optional<double> error_estimate() const;
  // Returns the frame as it can be displayed, or null if no film is kept. Valid from the first
  // pause on.
  const LivePicture* picture() const { return driver_ ? this : nullptr; }
  // These functions call the driver. picture() must not be null.
  DriverFacts facts() const { return driver_->facts(); }
  std::string history() const { return driver_->history(); }
  std::string explain(int x, int y) const { return driver_->explain(*film_, x, y); }
  void record_pixel(int x, int y) { driver_->record_pixel(x, y); }
  std::optional<WorkForecast> forecast() const { return driver_->forecast(); }
  std::vector<uint32_t> planned_counts(const AdaptiveSettings& limits) const {
    return driver_->planned_counts(limits);
  }

  void resolve(std::span<float> rgba, const LightMix* mix = nullptr) const override {
    driver_->resolve(*film_, rgba, mix);
  }
  const FilmTile& film() const override { return *film_; }
  PixelStop current_stop(int x, int y) const override {
    return driver_->current_stop(*film_, x, y);
  }

 private:
  FilmExtras film_extras() const { return frame_.with_light_groups(drivers_.film_extras); }
  void begin();
  void archive(Archive& archive);
  void render_crop(RenderLoop& loop);
  bool extend_work(std::optional<FrameBudget>& budget);

  // render_tiles.cpp
  void render_tiles(RenderLoop& loop);
  void render_tile(RenderLoop& loop, TileOwner& owner, RenderWorker& worker, FrameDriver& driver,
                   FilmTile& film, TileResult& result);
  void save_tile(FrameDriver& driver, FilmTile& film, TileResult& result);
  bool load_tile(RenderLoop& loop, const Rect& tile, FilmTile& film, TileResult& result);
  std::unique_ptr<FrameDriver> begin_tile(RenderLoop& loop, const Rect& tile, uint32_t samples,
                                          FilmTile& film, TileResult& result);
  void measure_tiles(RenderLoop& loop, std::span<const Rect> tiles, uint32_t first_sample,
                     uint32_t samples, std::span<TileCost> costs) const;
  void begin_budget(RenderLoop& loop, std::span<const Rect> tiles,
                    std::optional<TileBudget>& budget) const;
  std::vector<Rect> tiles() const;

  const Frame frame_;
  const DriverFactory drivers_;
  std::unique_ptr<FilmTile> film_;
  std::unique_ptr<FrameDriver> driver_;
  RenderCounters counters_;
  std::optional<double> tile_error_;
  uint64_t unsampled_pixels_ = 0;
  TileStore* store_ = nullptr;
  bool resumable_ = false;
  // For a frame with one film: the number of finished parts of the current round, and whether
  // pixels of later parts may already have samples.
  size_t parts_done_ = 0;
  bool film_is_ahead_ = false;
  bool is_budget_spent_ = false;  // the time budget is over, so the frame is finished
};

// Returns how many pixels have no sample.
uint64_t count_unsampled(const FilmTile& film);

// Returns the RMS of the tiles' errors, or nothing if any error is unknown. Weights each tile by
// its pixel count and sums in the given order.
std::optional<double> error_of_tiles(std::span<const Rect> tiles,
                                     std::span<const std::optional<double>> errors);

}  // namespace emberline
