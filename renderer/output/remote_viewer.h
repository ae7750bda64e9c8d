// `--display tev://HOST:PORT`: shows the frame in another program while it renders.
#pragma once

#include "io/viewer/tev_stream.h"
#include "renderer/core/rect.h"
#include "renderer/engine/render_sink.h"
#include "renderer/output/render_options.h"

namespace emberline {

// Sends finished tiles as they come. For progressive drivers it sends whole pictures at a rate that
// costs almost no render time.
class RemoteViewer {
 public:
  // Needs options.viewer. The image is named after the output and the scene.
  RemoteViewer(const RenderOptions& options, const Rect& crop, int threads);

  // Any thread.
  void add(const FilmTile& tile);
  // Call at a driver's pause, `elapsed_s` into rendering: sends the picture if one is due.
  void update(const LivePicture& picture, double elapsed_s);
  // Whether update() would send it. Any thread, but not during update().
  bool is_due(double elapsed_s) const;
  // Waits briefly for pending data, and hardly at all after a user stop.
  void finish(PixelStop stop_cause);

  uint64_t bytes() const { return stream_.peak_bytes(); }

 private:
  const Rect crop_;
  const int tile_size_;
  const int threads_;
  TevStream stream_;
  bool sent_ = false;
  double sent_at_s_ = 0.0;
  double paused_s_ = 0.0;  // render time spent on copying pictures
};

}  // namespace emberline
