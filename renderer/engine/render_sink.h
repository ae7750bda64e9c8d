// The interface through which window, progress bar, writers and checkpoints observe a job.
#pragma once

#include <cstdint>
#include <optional>

#include "renderer/core/rect.h"
#include "renderer/engine/live_picture.h"

namespace emberline {

class FilmTile;
// Progress of a progressive render.
struct JobProgress {
  int pass = 0;             // passes begun; the first gives every pixel its first sample
  uint64_t samples = 0;     // number so far
  uint64_t rays = 0;        // number so far
  double completion = 0.0;  // completed fraction of the first pass, in [0, 1]
  bool pass_finished = false;
  // The driver's estimate, if it has one, for the picture at the end of the previous pass.
  std::optional<double> error_estimate;
};

// Receives a job's tiles and pictures. Worker threads call these functions concurrently unless
// stated otherwise.
class RenderSink {
 public:
  virtual ~RenderSink() = default;
  // A tiled driver is about to begin these pixels.
  virtual void tile_begun(const Rect& /*pixels*/) {}
  // All samples of the tile are done. The tile is reused after the call. If this throws, the frame
  // is abandoned and render() rethrows.
  virtual void tile_finished(const FilmTile& tile) = 0;
  // Like tile_finished(), for a tile that an earlier run finished with this many samples.
  virtual void tile_loaded(const FilmTile& tile, uint64_t /*samples*/) { tile_finished(tile); }
  // This many samples of a tile come from an earlier run.
  virtual void samples_loaded(uint64_t /*count*/) {}
  // More samples are done; called about every millisecond of work.
  virtual void samples_finished(uint64_t /*count*/) {}
  // A progressive driver has paused. Called on the thread that called render(), while no worker
  // renders: often in the first pass, then after each pass and when a picture is wanted. The
  // picture is valid until the call returns; RenderJob::save() is allowed.
  virtual void picture_changed(const JobProgress& /*progress*/, const LivePicture& /*picture*/) {}
  // A stop request has cut a progressive driver's round short. Like picture_changed(), but only for
  // saving the frame.
  virtual void interrupted() {}
  // Asked after each part. If true, a progressive driver does not finish the round, but pauses
  // after the current parts (a few milliseconds). Does not change what is rendered.
  virtual bool needs_picture() const { return false; }
  // The sample count of the frame at which the next picture is wanted. A progressive driver pauses
  // after the part that reaches it, for any number of threads. Asked at pauses.
  virtual std::optional<uint64_t> next_picture_at() const { return std::nullopt; }
  // Why a stop was requested. Recorded for the pixels that it cut short.
  virtual PixelStop stop_cause() const { return PixelStop::kUser; }
};

}  // namespace emberline
