// Merges the parts of a frame. The parts differ in their tiles, sample ranges or seeds.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "io/files/record_file.h"
#include "io/json/value.h"
#include "renderer/core/memory_budget.h"
#include "renderer/drivers/bucket_schedule.h"
#include "renderer/engine/render_job.h"
#include "renderer/engine/render_plan.h"
#include "renderer/output/outputs.h"
#include "renderer/output/scene_layers.h"

namespace emberline {

// A part of a frame, or a whole frame, that was read from a checkpoint that `render` kept.
class StoredFrame {
 public:
  // Throws InputError if the file is not a checkpoint, is damaged or has invalid settings, or if
  // its bucket lists exceed the budget.
  explicit StoredFrame(const std::string& path, MemoryBudget* budget = nullptr);

  const std::string& path() const { return file_.path(); }
  const nlohmann::json& head() const { return *head_; }
  const FrameSettings& settings() const { return settings_; }
  const RenderPlan& plan() const { return plan_; }
  int tile_size() const {
    return emberline::tile_size(*plan_.driver, plan_.driver_settings.bucket_size);
  }
  const FilmExtras& film_extras() const { return extras_; }
  const SceneLayers& layers() const { return layers_; }

  // Loads the whole film if the driver has only one; does nothing for a tiled frame.
  void load_film(MemoryBudget& budget);
  // Whether the frame has the tile with this bucket_index().
  bool has_tile(size_t tile) const;
  // Loads a tile into `film`, which the caller must have reset to this tile. For a tiled frame,
  // also returns the tile's result and, if `driver` is not null, stores the driver's state in
  // `*driver`. Thread-safe. Throws InputError.
  TileResult load(size_t tile, FilmTile& film, std::vector<std::byte>* driver = nullptr) const;
  // Whether this frame is the given part and has all tiles of the part undamaged. Reads all its
  // tiles.
  bool is_complete_part(const FramePart& part) const;
  // Returns the fraction of this part's tiles that are finished.
  double completed_fraction() const;
  // The result of a frame with one film; absent for a tiled frame.
  const std::optional<TileResult>& film_result() const { return film_result_; }

 private:
  RecordFile file_;
  JsonValue head_;
  FrameSettings settings_;
  RenderPlan plan_;
  SceneLayers layers_;
  FilmExtras extras_;
  bool is_tiled_;
  size_t tile_index(const Rect& tile) const { return bucket_index(plan_.crop, tile, tile_size()); }
  TileResult empty_result() const;
  std::vector<Rect> part_tiles_;           // tiles of this part of the frame
  std::vector<const RecordEntry*> tiles_;  // indexed by tile number; null if missing
  std::optional<FilmTile> film_;
  std::optional<TileResult> film_result_;
};

// Receives the state of a merged tile, like TileStore::save(). Any thread may call it.
using SaveTile = std::function<void(size_t tile, std::span<const std::byte> state)>;

class FrameMerge {
 public:
  // Checks that the parts belong to one frame and share no samples. Unless `allow_holes` is set,
  // also checks that no samples are missing. With `strict`, also checks that all parts come from
  // the same kind of machine. Throws an InputError that names the part at fault. The constructor
  // and deliver() throw Cancelled soon after a stop request.
  FrameMerge(const std::vector<std::string>& paths, bool allow_holes, bool strict,
             MemoryBudget& budget, std::stop_token stop = {});

  const StoredFrame& first() const { return *frames_.front(); }
  const std::vector<std::unique_ptr<StoredFrame>>& frames() const { return frames_; }
  FrameSettings settings() const;
  bool complete() const { return complete_; }

  // Call before deliver(). Reserves memory for the tiles that deliver() works on and for the data
  // that the outputs keep until they are written. With `resumable`, also reserves memory for the
  // checkpoint. Throws InputError.
  void reserve(const RenderOptions& options, const OutputSettings& settings, int threads,
               MemoryBudget& budget) const;
  // Passes every tile to the sink. A tile has the channels of the parts and, if `aovs` contains it,
  // the channel `part`. Runs on the calling thread's TBB arena, with two films per thread. `save`
  // may be null. If it is given, the parts must be tiled and have the same seed. Throws InputError
  // and what the sink throws.
  void deliver(const AovSet& aovs, RenderSink& sink, const SaveTile& save = nullptr);
  // Valid after deliver().
  const RenderCounters& counters() const { return counters_; }
  uint64_t unsampled_pixels() const { return unsampled_pixels_; }
  std::optional<double> error_estimate() const { return error_; }

 private:
  // The parts that have the same seed and sample range. Together they cover all tiles, unless the
  // frame has holes.
  struct Group {
    uint32_t seed = 0, first_sample = 0, end_sample = 0;
    std::vector<const StoredFrame*> frames_by_tile;  // by tile number; null if missing
    std::vector<std::optional<double>> errors;
    std::vector<uint64_t> samples;
  };

  void check_stop() const;
  void check_frames(bool strict) const;
  void make_groups();
  void check_groups(bool allow_holes);
  void merge_tile(const Rect& tile, FilmTile& film, FilmTile& more, RenderCounters& counters,
                  const SaveTile& save);
  void combine_errors();
  size_t part_number(const StoredFrame* frame) const;
  size_t tile_index(const Rect& tile) const {
    return bucket_index(first().plan().crop, tile, first().tile_size());
  }

  const std::stop_token stop_;
  std::vector<std::unique_ptr<StoredFrame>> frames_;
  std::vector<Rect> tiles_;  // in bucket order
  std::vector<Group> groups_;
  bool complete_ = true;  // no samples are missing
  RenderCounters counters_;
  uint64_t unsampled_pixels_ = 0;
  std::optional<double> error_;
};

}  // namespace emberline
