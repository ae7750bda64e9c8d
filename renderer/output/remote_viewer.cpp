#include "renderer/output/remote_viewer.h"

#include <filesystem>
#include <utility>
#include <vector>

#include "renderer/drivers/bucket_schedule.h"
#include "renderer/engine/render_clock.h"
#include "renderer/film/film.h"

namespace emberline {
namespace {

// Minimum seconds between whole pictures. A higher rate is hardly visible.
constexpr double kMinInterval = 0.1;

// Fraction of the render time that whole pictures may cost. The cost is the pauses for copying, in
// which workers are idle, plus the sending thread's CPU time divided by the thread count. In all, a
// viewer may cost 2 % of the render time; half of that is left for costs that are not measured here
// (kernel, caches, a viewer on the same machine).
constexpr double kMaxCostFraction = 0.01;

// Buckets smaller than this are combined into larger tiles for sending.
constexpr int kMinTileSize = 32;

std::string image_name(const RenderOptions& options) {
  return options.outputs.front() + " (" + std::filesystem::path(options.scene).filename().string() +
         ")";
}

}  // namespace

RemoteViewer::RemoteViewer(const RenderOptions& options, const Rect& crop, int threads)
    : crop_(crop),
      tile_size_(round_up_to_buckets(options.bucket_size, kMinTileSize)),
      threads_(threads),
      stream_(*options.viewer, {image_name(options), options.width, options.height}) {}

void RemoteViewer::add(const FilmTile& tile) {
  if (!stream_.open()) return;
  std::vector<float> rgba;
  tile.resolve_rgba(rgba);
  stream_.add(tile.rect(), std::move(rgba));
}

bool RemoteViewer::is_due(double elapsed_s) const {
  if (!stream_.open()) return false;
  if (!sent_) return true;
  const double cost_s = paused_s_ + stream_.cpu_seconds() / threads_;
  return elapsed_s >= sent_at_s_ + kMinInterval && cost_s <= kMaxCostFraction * elapsed_s;
}

void RemoteViewer::update(const LivePicture& picture, double elapsed_s) {
  if (!is_due(elapsed_s)) return;
  const Stopwatch pause;
  std::vector<float> rgba(4 * size_t(crop_.area()));
  picture.resolve(rgba);
  stream_.add_picture(crop_, tile_size_, std::move(rgba));
  sent_ = true;
  sent_at_s_ = elapsed_s;
  paused_s_ += pause.seconds();
}

void RemoteViewer::finish(PixelStop stop_cause) {
  TevStream::Timeouts timeouts;
  if (stop_cause == PixelStop::kUser) timeouts = {.stalled_s = 0.25, .total_s = 0.5};
  stream_.finish(timeouts);
}

}  // namespace emberline
