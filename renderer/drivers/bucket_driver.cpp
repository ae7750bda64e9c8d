#include "renderer/drivers/bucket_driver.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <exception>
#include <limits>
#include <mutex>
#include <numeric>

#include "renderer/core/errors.h"
#include "renderer/core/hash.h"
#include "renderer/core/names.h"
#include "renderer/core/parallel.h"
#include "renderer/drivers/adaptive/round_averages.h"
#include "renderer/drivers/render_work_item.h"

namespace emberline {
namespace {

constexpr BucketOrderEntry kOrders[] = {
    {"hilbert", "along Hilbert's curve: neighbours in time are neighbours in the frame",
     BucketOrder::kHilbert},
    {"spiral", "from the middle outwards", BucketOrder::kSpiral},
    {"scanline", "rows from the top", BucketOrder::kScanline},
    {"random", "shuffled: an early impression of the whole frame", BucketOrder::kRandom},
};

struct Cell {
  int x, y;
};

// Step at which Hilbert's curve over a 2^k x 2^k grid passes cell (x, y). Bit by bit from the
// highest: each pair of bits of the step names a quadrant, and turns what is found below it.
// 4 x 4, cell (3, 0), k = 2: its quadrant, right and above, is the last (3), and in there it is,
// turned, right and above again (3): step 15.
uint64_t hilbert_step(int k, uint32_t x, uint32_t y) {
  uint64_t step = 0;
  for (int bit = k - 1; bit >= 0; --bit) {
    const uint32_t rx = (x >> bit) & 1u, ry = (y >> bit) & 1u;
    step = 4 * step + ((3 * rx) ^ ry);
    if (ry == 0) {
      if (rx == 1) {
        x = ~x;
        y = ~y;
      }
      std::swap(x, y);
    }
  }
  return step;
}

// By sorting rather than by walking the curve, which would visit the whole square around a frame
// of one column: 65536 x 1 buckets took two minutes.
std::vector<Cell> hilbert_cells(int columns, int rows) {
  const int k = std::bit_width(uint32_t(std::max(columns, rows)) - 1);
  std::vector<std::pair<uint64_t, Cell>> steps;
  steps.reserve(size_t(columns) * size_t(rows));
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      steps.push_back({hilbert_step(k, uint32_t(x), uint32_t(y)), {x, y}});
    }
  }
  std::ranges::sort(steps, {}, &std::pair<uint64_t, Cell>::first);
  std::vector<Cell> cells;
  cells.reserve(steps.size());
  for (const auto& [step, cell] : steps) cells.push_back(cell);
  return cells;
}

// The part [first, last) of the steps of a leg that has 0 <= from + step * i < size.
void clip_leg(int from, int step, int size, int& first, int& last) {
  if (step == 0 && (from < 0 || from >= size)) last = first;
  if (step > 0) {
    first = std::max(first, -from);
    last = std::min(last, size - from);
  }
  if (step < 0) {
    first = std::max(first, from - size + 1);
    last = std::min(last, from + 1);
  }
}

std::vector<Cell> spiral_cells(int columns, int rows) {
  std::vector<Cell> cells;
  const size_t total = size_t(columns) * size_t(rows);
  cells.reserve(total);
  int x = (columns - 1) / 2, y = (rows - 1) / 2;
  // Legs of 1, 1, 2, 2, 3, 3 ... steps: right, down, left, up.
  constexpr int kStepX[4] = {1, 0, -1, 0}, kStepY[4] = {0, 1, 0, -1};
  for (int leg = 0; cells.size() < total; ++leg) {
    const int dx = kStepX[leg % 4], dy = kStepY[leg % 4], length = leg / 2 + 1;
    int first = 0, last = length;
    clip_leg(x, dx, columns, first, last);
    clip_leg(y, dy, rows, first, last);
    for (int i = first; i < last; ++i) cells.push_back({x + i * dx, y + i * dy});
    x += length * dx;
    y += length * dy;
  }
  return cells;
}

std::vector<Cell> scanline_cells(int columns, int rows) {
  std::vector<Cell> cells;
  cells.reserve(size_t(columns) * size_t(rows));
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) cells.push_back({x, y});
  }
  return cells;
}

std::vector<Cell> random_cells(int columns, int rows, uint32_t seed) {
  std::vector<Cell> cells = scanline_cells(columns, rows);
  for (size_t i = cells.size(); i > 1; --i) {  // Fisher-Yates
    const uint64_t r = hash_combine64(seed, i);
    std::swap(cells[i - 1], cells[size_t(r % i)]);
  }
  return cells;
}

void mark_stops(FilmTile& tile, uint32_t samples_per_pixel, PixelStop cut_short) {
  if (!tile.aovs().contains(Aov::kStop)) return;
  const Rect& rect = tile.rect();
  for (int y = rect.y0; y < rect.y1; ++y) {
    for (int x = rect.x0; x < rect.x1; ++x) tile.mark_stop(x, y, samples_per_pixel, cut_short);
  }
}

}  // namespace

std::span<const BucketOrderEntry> bucket_order_table() { return kOrders; }

BucketOrder parse_bucket_order(std::string_view name) {
  return find_named(kOrders, "--bucket-order", "order", name).order;
}

std::vector<WorkItem> bucket_schedule(const Rect& window, int bucket_size, BucketOrder order,
                                      uint32_t samples_per_pixel, uint32_t seed) {
  std::vector<WorkItem> items;
  if (window.empty()) return items;
  // A list of more would take longer to make and hold than the buckets save.
  constexpr int64_t kMostBuckets = 1 << 24;
  const int64_t size = bucket_size;
  if ((window.width() + size - 1) / size * ((window.height() + size - 1) / size) > kMostBuckets) {
    throw UsageError("--bucket-size: " + std::to_string(bucket_size) +
                     " would cut the frame into "
                     "more than 16777216 buckets; make them larger");
  }
  const int columns = (window.width() + bucket_size - 1) / bucket_size;
  const int rows = (window.height() + bucket_size - 1) / bucket_size;
  std::vector<Cell> cells;
  switch (order) {
    case BucketOrder::kHilbert:
      cells = hilbert_cells(columns, rows);
      break;
    case BucketOrder::kSpiral:
      cells = spiral_cells(columns, rows);
      break;
    case BucketOrder::kScanline:
      cells = scanline_cells(columns, rows);
      break;
    case BucketOrder::kRandom:
      cells = random_cells(columns, rows, seed);
      break;
  }
  items.reserve(cells.size());
  for (const Cell& cell : cells) {
    const int x = window.x0 + cell.x * bucket_size;
    const int y = window.y0 + cell.y * bucket_size;
    items.push_back(
        {Rect{x, y, x + bucket_size, y + bucket_size}.intersect(window), 0, samples_per_pixel});
  }
  return items;
}

int checked_bucket_size(int bucket_size) {
  if (bucket_size < 1 || bucket_size > 4096) {
    throw UsageError("--bucket-size: " + std::to_string(bucket_size) +
                     " is outside the valid range 1 to 4096");
  }
  return bucket_size;
}

BucketDriver::BucketDriver(const DriverSettings& settings)
    : bucket_size_(checked_bucket_size(settings.bucket_size)),
      order_(parse_bucket_order(settings.bucket_order)),
      adaptive_(settings.adaptive) {}

// Renders a bucket round by round until each of its pixels has met the settings' limits. The
// estimates end at the bucket's edge: a pixel is judged with its neighbours in the same bucket.
// Returns the estimate of its RMS error; NaN without one.
double BucketDriver::render_adaptively(const Frame& frame, RenderWorker& worker, FilmTile& tile,
                                       FrameObserver& observer, const std::stop_token& stop) const {
  const Rect& rect = tile.rect();
  const auto pixels = size_t(rect.area());
  RoundPlanner planner(adaptive_, rect.width(), rect.height(), frame.seed);
  RoundAverages averages;
  if (adaptive_.unbiased) planner.set_averages(&averages);
  std::vector<uint32_t> have(pixels, 0);
  std::vector<PixelWork> list;
  bool more = true;
  while (more) {
    list.clear();
    for (size_t i = 0; i < pixels; ++i) {
      const uint32_t target = planner.targets()[i];
      if (target > have[i]) list.push_back({rect.x_of(i), rect.y_of(i), have[i], target - have[i]});
      have[i] = target;
    }
    worker.set_seed(planner.round_seed());
    if (!worker.render(list, tile, observer, stop)) break;
    if (adaptive_.unbiased) averages.add_round(tile, planner.round_weight());
    // Isolated: while this thread waits for help, it must not begin another bucket.
    tbb::this_task_arena::isolate([&] { more = planner.plan(tile); });
  }
  tbb::this_task_arena::isolate([&] { planner.tell_variances(&tile); });
  for (size_t i = 0; i < pixels; ++i) {
    const uint32_t samples = tile.sample_count(rect.x_of(i), rect.y_of(i));
    tile.set_stop(rect.x_of(i), rect.y_of(i),
                  samples == 0        ? PixelStop::kNone
                  : samples < have[i] ? observer.stop_cause()
                                      : planner.stop_of(i));
    if (averages.empty()) continue;
    float rgba[4];
    averages.resolve(i, rgba);
    tile.show(rect.x_of(i), rect.y_of(i), rgba);
  }
  return planner.error_estimate();
}

FrameCounters BucketDriver::render(const Frame& frame, FrameObserver& observer,
                                   std::stop_token stop) {
  const bool adaptive = adaptive_.threshold > 0.0f;
  const std::vector<WorkItem> items =
      bucket_schedule(frame.window, bucket_size_, order_, frame.samples_per_pixel, frame.seed);
  // Workers take the next bucket from a counter rather than a share of the list in advance, so the
  // order is kept whatever the threads' speeds. One increment per bucket is no contention.
  std::atomic<size_t> next{0};
  std::atomic<bool> failed{false};
  std::mutex merge_mutex;
  FrameCounters total;
  uint32_t fewest = std::numeric_limits<uint32_t>::max();
  std::vector<double> errors(adaptive ? items.size() : 0);  // summed in order, whoever brought them
  const auto work = [&] {
    try {
      RenderWorker worker(frame);
      FilmTile tile(frame.aovs,
                    frame.with_light_groups(
                        {.squares = adaptive,
                         .rays = adaptive,
                         .sample_variance = adaptive && RoundPlanner::knows_variances(adaptive_)}));
      uint32_t fewest_here = std::numeric_limits<uint32_t>::max();
      while (!failed.load(std::memory_order_relaxed) && !stop.stop_requested()) {
        const size_t i = next.fetch_add(1, std::memory_order_relaxed);
        if (i >= items.size()) break;
        tile.reset(items[i].pixels);
        observer.tile_begun(items[i].pixels);
        if (adaptive) {
          const double error = render_adaptively(frame, worker, tile, observer, stop);
          errors[i] = square(error) * double(items[i].pixels.area());
          fewest_here = std::min(fewest_here, tile.least_samples());
        } else {
          worker.render(items[i], tile, observer, stop);
          mark_stops(tile, frame.samples_per_pixel, observer.stop_cause());
        }
        observer.tile_finished(tile);
      }
      const std::lock_guard lock(merge_mutex);
      total.merge(worker.counters());
      fewest = std::min(fewest, fewest_here);
    } catch (...) {
      failed = true;  // the other workers need not finish a frame that is lost
      throw;
    }
  };
  const int workers = std::max(1, tbb::this_task_arena::max_concurrency());
  parallel_tasks(size_t(workers), [&](size_t) { work(); });
  if (adaptive) {
    total.min_samples = items.empty() ? 0 : fewest;
    const double sum = std::accumulate(errors.begin(), errors.end(), 0.0);
    const double rms = std::sqrt(sum / double(frame.window.area()));
    if (rms >= 0.0) error_estimate_ = rms;
  }
  if (next.load() < items.size()) {
    total.stopped = true;
    total.min_samples = 0;
  }
  return total;
}

}  // namespace emberline
