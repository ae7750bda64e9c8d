// How window, progress bar, writers and checkpoints see a frame while it renders.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "renderer/core/rect.h"
#include "renderer/film/pixel_stop.h"

namespace emberline {

class FilmTile;
class LightMix;

// The frame as it can be shown while it renders: complete at every moment, the pixels without
// samples filled from their neighbours.
class LivePicture {
 public:
  virtual ~LivePicture() = default;
  // R G B A of every pixel of the crop, interleaved, rows from its top. With a mix, of a frame
  // with light groups, under other lights: each group times its weight (renderer/film/light_mix.h).
  virtual void resolve(std::span<float> rgba, const LightMix* mix = nullptr) const = 0;
  virtual const FilmTile& film() const = 0;
  // Why the pixel of the crop gets no more samples, as far as the driver has decided that by now;
  // kGoingOn for the others, also where a stop request has cut them short.
  virtual PixelStop stop_so_far(int x, int y) const = 0;
};

// How far a progressive render has come.
struct JobProgress {
  int pass = 0;             // how many have begun; the first brings every pixel its first sample
  uint64_t samples = 0;     // so far
  uint64_t rays = 0;        // likewise
  double completion = 0.0;  // of the first pass: pixels that have a sample, in [0, 1]
  bool pass_finished = false;
  // The driver's own, if it has made one: of the picture as it was at the end of the pass before.
  std::optional<double> error_estimate;
};

// How window, progress bar, writers and checkpoints see the frame; drivers know none of them.
// Called from worker threads, concurrently, unless a function says otherwise.
class RenderSink {
 public:
  virtual ~RenderSink() = default;
  // A driver that finishes one part of the frame after another begins with these pixels.
  virtual void tile_begun(const Rect& /*pixels*/) {}
  // All samples of the tile's pixels are in; the tile is reused after the call returns. May throw:
  // the frame is then abandoned and render() rethrows.
  virtual void tile_finished(const FilmTile& tile) = 0;
  // The same for a tile that an earlier run has finished, with so many samples.
  virtual void tile_loaded(const FilmTile& tile, uint64_t /*samples*/) { tile_finished(tile); }
  // So many samples of a tile are of an earlier run.
  virtual void samples_loaded(uint64_t /*count*/) {}
  // Some more samples are done (about every millisecond of work).
  virtual void samples_finished(uint64_t /*count*/) {}
  // A progressive driver pauses: from its own thread, while no worker renders. That is often in its
  // first pass, and then at the end of each pass or where a picture is wanted. The picture may be
  // looked at until the call returns.
  virtual void picture_changed(const JobProgress& /*progress*/, const LivePicture& /*picture*/) {}
  // A stop request has ended a round of a progressive driver before its end: as picture_changed(),
  // for saving the frame alone.
  virtual void cut_short() {}
  // Somebody waits for picture_changed(): a progressive driver then pauses after the parts that
  // are under way, some milliseconds of work, instead of after a round of them. Asked from worker
  // threads after each part; what is rendered is the same.
  virtual bool picture_wanted() const { return false; }
  // The least number of the frame's samples at which the next picture is wanted: a progressive
  // driver then pauses with the part that reaches it, for whatever number of threads. Asked at
  // pauses.
  virtual std::optional<uint64_t> picture_wanted_at() const { return std::nullopt; }
  // Why a stop was requested, for the pixels that it cut short.
  virtual PixelStop stop_cause() const { return PixelStop::kUser; }
};

}  // namespace emberline
