// `--display tev://HOST:PORT`: shows the frame in another program while it renders.
#pragma once

#include "io/viewer/tev_stream.h"
#include "renderer/core/rect.h"
#include "renderer/engine/render_sink.h"
#include "renderer/output/render_options.h"

namespace emberline {

// Sends each tile when it is finished. With a progressive driver, sends whole pictures instead, but
// so rarely that they cost almost no render time.
class RemoteViewer {
 public:
  // options.viewer must be set. The image is named after the output and the scene.
  RemoteViewer(const RenderOptions& options, const Rect& crop, int threads);

  // Thread-safe.
  void add(const FilmTile& tile);
  // Call when the driver pauses, `elapsed_s` seconds after the start. Sends the picture if one is
  // due.
  void update(const LivePicture& picture, double elapsed_s);
  // Whether update() would send a picture now. Any thread may call this, but not during update().
  bool is_due(double elapsed_s) const;
  // Waits briefly until pending data is sent. Waits at most 0.5 s if the user stopped the frame.
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
