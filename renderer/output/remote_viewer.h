// `--display tev://HOST:PORT`: the frame in another program's window while it renders.
#pragma once

#include "io/viewer/tev_stream.h"
#include "renderer/core/rect.h"
#include "renderer/engine/render_sink.h"
#include "renderer/output/render_options.h"

namespace emberline {

// Finished tiles as they come; of progressive drivers, pictures of the whole as often as costs
// hardly anything.
class RemoteViewer {
 public:
  // Needs options.viewer. The image has the output's name and the scene's.
  RemoteViewer(const RenderOptions& options, const Rect& crop, int threads);

  // Any thread.
  void add(const FilmTile& tile);
  // At a driver's pause, `elapsed_s` into the rendering: shows the picture if it is time for it.
  void look(const LivePicture& picture, double elapsed_s);
  // Whether look() would show it. Any thread, while look() is not called.
  bool wanted(double elapsed_s) const;
  // Waits for what is on its way, but not long; hardly at all for a user who has stopped the frame.
  void finish(PixelStop stop_cause);

  uint64_t bytes() const { return stream_.most_bytes(); }

 private:
  const Rect crop_;
  const int tile_size_;
  const int threads_;
  TevStream stream_;
  bool shown_ = false;
  double shown_at_s_ = 0.0;
  double paused_s_ = 0.0;  // the time that drivers waited for pictures
};

}  // namespace emberline
