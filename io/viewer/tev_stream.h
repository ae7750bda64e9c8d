// A picture that grows in the image viewer tev while it is rendered, without anyone waiting for it.
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

// Connects and sends from a thread of its own. What is added meanwhile waits in memory, the newest
// pixels of each rectangle only: with disjoint rectangles never more than one frame, with a viewer
// that keeps up a few tiles. A viewer that cannot be reached, or is gone, is told of in one
// warning; from then on nothing is kept.
class TevStream {
 public:
  struct Image {
    std::string name;
    int width = 0, height = 0;  // of the whole frame
  };
  // For how long finish() waits.
  struct Patience {
    double stalled_s = 1.0;  // while the viewer takes nothing
    double whole_s = 10.0;
  };

  // Returns at once; the viewer has an empty image as soon as it is connected.
  TevStream(const TevAddress& address, Image image);
  ~TevStream();  // drops what has not been sent

  // Whether it is worthwhile to add anything: false once the viewer is lost. Any thread.
  bool open() const { return open_.load(std::memory_order_relaxed); }

  // R G B A of `rect`, in pixels of the frame, interleaved, rows from its top. Rectangles are sent
  // in the order in which they came; one that still waits gets the new pixels in its place. Any
  // thread; never waits for the viewer.
  void add(const Rect& rect, std::vector<float> rgba);
  // The same for all of `crop`, in tiles of `tile_size` from its corner.
  void add_picture(const Rect& crop, int tile_size, std::vector<float> rgba);

  // Waits until all is sent, or patience ends: then with a warning. Nothing is added afterwards.
  void finish(const Patience& patience);

  uint64_t most_bytes() const;  // that ever waited
  // Processor time of the sending thread so far.
  double cpu_seconds() const { return cpu_s_.load(std::memory_order_relaxed); }

 private:
  using Key = std::array<int, 4>;
  struct Part {
    Rect rect, layout;  // of the frame; the pixels are all those of `layout`
    std::shared_ptr<const std::vector<float>> rgba;
  };

  void put(Part part);  // with the mutex locked
  bool take(Part& part);
  void run();
  void send_all();
  bool patient(double waited_s) const;
  void end();

  const TevAddress address_;
  const Image image_;
  std::atomic<bool> open_{true};
  std::atomic<double> cpu_s_{0.0};

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::map<Key, Part> waiting_;
  std::deque<Key> order_;  // of `waiting_`
  uint64_t waiting_bytes_ = 0, most_bytes_ = 0;
  bool ended_ = false;      // nothing more will come
  bool abandoned_ = false;  // and nobody waits for what there is
  Patience patience_;
  std::chrono::steady_clock::time_point ended_at_;
  std::thread thread_;
};

}  // namespace emberline
