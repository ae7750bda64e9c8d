// How window, progress bar, writers and checkpoints follow a job.
#pragma once

#include <cstdint>
#include <optional>

#include "renderer/core/rect.h"
#include "renderer/engine/live_picture.h"

namespace emberline {

class FilmTile;
// How far a progressive render has come.
struct JobProgress {
  int pass = 0;             // passes that have begun; the first brings every pixel its first sample
  uint64_t samples = 0;     // done so far
  uint64_t rays = 0;        // traced so far
  double completion = 0.0;  // of the first pass: share of pixels that have a sample, in [0, 1]
  bool pass_finished = false;
  // The driver's estimate, if it has made one: for the picture at the end of the pass before.
  std::optional<double> error_estimate;
};

// Receives tiles and pictures of a job. Functions are called from worker threads, concurrently,
// unless they say otherwise.
class RenderSink {
 public:
  virtual ~RenderSink() = default;
  // A driver of tiles begins with these pixels.
  virtual void tile_begun(const Rect& /*pixels*/) {}
  // All samples of the tile's pixels are in. The tile is reused after the call returns. May throw:
  // the frame is then abandoned and render() rethrows.
  virtual void tile_finished(const FilmTile& tile) = 0;
  // As tile_finished(), for a tile that an earlier run finished with this many samples.
  virtual void tile_loaded(const FilmTile& tile, uint64_t /*samples*/) { tile_finished(tile); }
  // This many samples of a tile come from an earlier run.
  virtual void samples_loaded(uint64_t /*count*/) {}
  // More samples are done (about every millisecond of work).
  virtual void samples_finished(uint64_t /*count*/) {}
  // A progressive driver pauses: on the thread that called render(), while no worker renders. It
  // pauses often in its first pass, then at the end of each pass and where a picture is wanted. The
  // picture may be read until the call returns. RenderJob::save() may be called.
  virtual void picture_changed(const JobProgress& /*progress*/, const LivePicture& /*picture*/) {}
  // A stop request has cut a round of a progressive driver short: as picture_changed(), but only
  // for saving the frame.
  virtual void cut_short() {}
  // True: a progressive driver pauses after the parts that are under way, some milliseconds of
  // work, instead of after the round. Asked after each part. Does not change what is rendered.
  virtual bool picture_wanted() const { return false; }
  // The least number of samples of the frame at which the next picture is wanted: a progressive
  // driver pauses with the part that reaches it, whatever the number of threads. Asked at pauses.
  virtual std::optional<uint64_t> picture_wanted_at() const { return std::nullopt; }
  // Why a stop was requested, for the pixels that it cut short.
  virtual PixelStop stop_cause() const { return PixelStop::kUser; }
};

}  // namespace emberline
