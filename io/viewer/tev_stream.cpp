#include "io/viewer/tev_stream.h"

#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <exception>
#include <utility>

#include "io/viewer/tcp_client.h"
#include "renderer/core/log.h"

namespace emberline {
namespace {

constexpr double kConnectSeconds = 5.0;

// Larger rectangles are split, so that each part appears soon and fits into the 1 MiB packet buffer
// with which tev starts.
constexpr int kPacketSide = 128;  // in pixels; a packet has 256 KiB

double thread_cpu_seconds() {
  timespec t = {};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

template <typename Use>
void for_each_tile(const Rect& crop, int size, const Use& use) {
  for (int y = crop.y0; y < crop.y1; y += size) {
    for (int x = crop.x0; x < crop.x1; x += size) {
      use(Rect{x, y, x + size, y + size}.intersect(crop));
    }
  }
}

}  // namespace

TevStream::TevStream(const TevAddress& address, Image image)
    : address_(address), image_(std::move(image)), thread_([this] { run(); }) {}

TevStream::~TevStream() {
  {
    const std::lock_guard lock(mutex_);
    abandoned_ = true;
  }
  end();
}

void TevStream::finish(const Timeouts& timeouts) {
  {
    const std::lock_guard lock(mutex_);
    timeouts_ = timeouts;
  }
  end();
}

void TevStream::end() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    ended_at_ = std::chrono::steady_clock::now();
  }
  wake_.notify_all();
  thread_.join();
}

void TevStream::add(const Rect& rect, std::vector<float> rgba) {
  if (!open()) return;
  {
    const std::lock_guard lock(mutex_);
    put({rect, rect, std::make_shared<const std::vector<float>>(std::move(rgba))});
  }
  wake_.notify_all();
}

void TevStream::add_picture(const Rect& crop, int tile_size, std::vector<float> rgba) {
  if (!open()) return;
  const auto shared = std::make_shared<const std::vector<float>>(std::move(rgba));
  {
    const std::lock_guard lock(mutex_);
    for_each_tile(crop, tile_size, [&](const Rect& rect) { put({rect, crop, shared}); });
  }
  wake_.notify_all();
}

void TevStream::put(QueuedTile part) {
  const Key key = {part.rect.x0, part.rect.y0, part.rect.x1, part.rect.y1};
  const uint64_t bytes = uint64_t(part.rect.area()) * 4 * sizeof(float);
  const auto [place, added] = queued_.insert_or_assign(key, std::move(part));
  if (!added) return;
  order_.push_back(place->first);
  queued_bytes_ += bytes;
  peak_bytes_ = std::max(peak_bytes_, queued_bytes_);
}

// Waits for the next part. Returns false if no part will follow.
bool TevStream::take(QueuedTile& part) {
  std::unique_lock lock(mutex_);
  wake_.wait(lock, [this] { return ended_ || !order_.empty(); });
  if (abandoned_ || order_.empty()) return false;
  auto node = queued_.extract(order_.front());
  order_.pop_front();
  part = std::move(node.mapped());
  queued_bytes_ -= uint64_t(part.rect.area()) * 4 * sizeof(float);
  return true;
}

bool TevStream::keep_waiting(double waited_s) const {
  const std::lock_guard lock(mutex_);
  if (!ended_) return true;
  const double since_end =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - ended_at_).count();
  return !abandoned_ && since_end < timeouts_.total_s &&
         std::min(waited_s, since_end) < timeouts_.stalled_s;
}

void TevStream::send_all() {
  TcpClient viewer(address_.host, address_.port, kConnectSeconds,
                   [this](double waited_s) { return keep_waiting(waited_s); });
  viewer.send(tev_create_image(image_.name, image_.width, image_.height));
  for (QueuedTile part; take(part);) {
    for_each_tile(part.rect, kPacketSide, [&](const Rect& piece) {
      viewer.send(tev_update_image(image_.name, piece, *part.rgba, part.layout));
    });
    cpu_s_.store(thread_cpu_seconds(), std::memory_order_relaxed);
  }
}

void TevStream::run() {
  std::string fault;
  try {
    send_all();
  } catch (const std::exception& error) {  // a viewer's failure must not end the render
    fault = error.what();
  }
  open_ = false;
  bool rendering = false;
  {
    const std::lock_guard lock(mutex_);
    queued_.clear();
    order_.clear();
    if (abandoned_) return;
    rendering = !ended_;
  }
  if (fault.empty()) return;
  log_warning(fmt::format("`display` {}: {}; {}", address_.url(), fault,
                          rendering ? "the render continues without this viewer"
                                    : "the viewer's picture is incomplete"));
}

uint64_t TevStream::peak_bytes() const {
  const std::lock_guard lock(mutex_);
  return peak_bytes_;
}

}  // namespace emberline
