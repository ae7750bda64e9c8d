// Streams a picture to the image viewer tev while it is rendered. The renderer never waits for the
// viewer.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "io/viewer/tev_protocol.h"
#include "renderer/core/rect.h"

namespace emberline {

// Connects and sends on its own thread. Unsent tiles wait in memory; for each rectangle, only the
// newest pixels are kept. If different rectangles do not overlap, the waiting tiles never exceed
// one frame. If the viewer keeps up, only a few tiles wait. If the viewer cannot be reached or is
// lost, logs one warning and drops all tiles.
class TevStream {
 public:
  struct Image {
    std::string name;
    int width = 0, height = 0;  // size of the whole frame
  };
  // How long finish() waits.
  struct Timeouts {
    double stalled_s = 1.0;  // without any progress
    double total_s = 10.0;
  };

  // Returns at once. The viewer shows an empty image as soon as it is connected.
  TevStream(const TevAddress& address, Image image);
  ~TevStream();  // drops unsent tiles

  // False once the viewer is lost; add() then has no effect. Thread-safe.
  bool open() const { return open_.load(std::memory_order_relaxed); }

  // `rgba` holds R G B A of `rect` (in frame pixels), interleaved, with rows from the top.
  // Rectangles are sent in order of arrival. If the same rectangle is still waiting, the new pixels
  // replace the old ones. Thread-safe; never waits for the viewer.
  void add(const Rect& rect, std::vector<float> rgba);
  // Adds the whole picture of `crop`, in tiles of `tile_size` that start at the crop's corner.
  void add_picture(const Rect& crop, int tile_size, std::vector<float> rgba);

  // Waits until everything is sent, and warns if one of `timeouts` is exceeded. Do not call add()
  // afterwards.
  void finish(const Timeouts& timeouts);

  uint64_t peak_bytes() const;  // the most bytes that ever waited at once
  // CPU time of the sending thread so far.
  double cpu_seconds() const { return cpu_s_.load(std::memory_order_relaxed); }

 private:
  using Key = std::array<int, 4>;
  struct QueuedTile {
    Rect rect, layout;  // in frame coordinates; `rgba` covers `layout`
    std::shared_ptr<const std::vector<float>> rgba;
  };

  void put(QueuedTile part);  // requires that the mutex is locked
  bool take(QueuedTile& part);
  void run();
  void send_all();
  bool keep_waiting(double waited_s) const;
  void end();

  const TevAddress address_;
  const Image image_;
  std::atomic<bool> open_{true};
  std::atomic<double> cpu_s_{0.0};

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::map<Key, QueuedTile> queued_;
  std::deque<Key> order_;  // keys of `queued_`
  uint64_t queued_bytes_ = 0, peak_bytes_ = 0;
  bool ended_ = false;      // nothing more will be added
  bool abandoned_ = false;  // unsent tiles must be dropped
  Timeouts timeouts_;
  std::chrono::steady_clock::time_point ended_at_;
  std::thread thread_;
};

}  // namespace emberline
