// The interface through which the window, progress bar, file writers and checkpoints observe a job.
#pragma once

#include <cstdint>
#include <optional>

#include "renderer/core/rect.h"
#include "renderer/engine/live_picture.h"

namespace emberline {

class FilmTile;
// Progress of a progressive render.
struct JobProgress {
  int pass = 0;             // passes begun; pass 1 gives every pixel its first sample
  uint64_t samples = 0;     // number of samples so far
  uint64_t rays = 0;        // number of rays so far
  double completion = 0.0;  // completed fraction of the first pass, in [0, 1]
  bool pass_finished = false;
  // The driver's error estimate, if it has one, for the picture at the end of the previous pass.
  std::optional<double> error_estimate;
};

// Receives a job's tiles and pictures. Worker threads call these functions concurrently unless
// stated otherwise.
class RenderSink {
 public:
  virtual ~RenderSink() = default;
  // A tiled driver is about to begin the tile with these pixels.
  virtual void tile_begun(const Rect& /*pixels*/) {}
  // All samples of the tile are done. After the call, the caller reuses `tile`. If this throws, the
  // frame is abandoned and render() rethrows.
  virtual void tile_finished(const FilmTile& tile) = 0;
  // Like tile_finished(), but an earlier run has finished the tile with this many samples.
  virtual void tile_loaded(const FilmTile& tile, uint64_t /*samples*/) { tile_finished(tile); }
  // This many samples of a tile come from an earlier run.
  virtual void samples_loaded(uint64_t /*count*/) {}
  // More samples are done; called about every millisecond of work.
  virtual void samples_finished(uint64_t /*count*/) {}
  // A progressive driver has paused. Called on the thread that called render(), while no worker
  // renders. This happens often in the first pass, then after each pass and when a picture is
  // wanted. The picture is valid until the call returns; RenderJob::save() is allowed.
  virtual void picture_changed(const JobProgress& /*progress*/, const LivePicture& /*picture*/) {}
  // A stop request has cut a progressive driver's round short. Called like picture_changed(), but
  // only to save the frame.
  virtual void interrupted() {}
  // Called after each part. If this returns true, a progressive driver pauses after the current
  // parts (a few milliseconds), before the round is finished. The pause does not change what is
  // rendered.
  virtual bool needs_picture() const { return false; }
  // Returns the frame's sample count at which the next picture is wanted. A progressive driver
  // pauses after the part that reaches this count, whatever the number of threads. Called at
  // pauses.
  virtual std::optional<uint64_t> next_picture_at() const { return std::nullopt; }
  // Says why a stop was requested. The cause is recorded for the pixels that the stop cut short.
  virtual PixelStop stop_cause() const { return PixelStop::kUser; }
};

}  // namespace emberline
