#include "renderer/drivers/bucket_driver.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <exception>
#include <mutex>

#include "renderer/core/errors.h"
#include "renderer/core/hash.h"
#include "renderer/core/names.h"
#include "renderer/core/parallel.h"
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

// Position of step d on Hilbert's curve over an n x n grid, n a power of two. Bit by bit from the
// lowest: each pair of bits of d names a quadrant, and rotates what was found below it.
void hilbert_cell(uint32_t n, uint64_t d, uint32_t* x, uint32_t* y) {
  *x = *y = 0;
  for (uint32_t s = 1; s < n; s *= 2) {
    const uint32_t rx = 1u & uint32_t(d / 2);
    const uint32_t ry = 1u & (uint32_t(d) ^ rx);
    if (ry == 0) {
      if (rx == 1) {
        *x = s - 1 - *x;
        *y = s - 1 - *y;
      }
      std::swap(*x, *y);
    }
    *x += s * rx;
    *y += s * ry;
    d /= 4;
  }
}

struct Cell {
  int x, y;
};

std::vector<Cell> hilbert_cells(int columns, int rows) {
  std::vector<Cell> cells;
  cells.reserve(size_t(columns) * size_t(rows));
  const uint32_t n = std::bit_ceil(uint32_t(std::max(columns, rows)));
  for (uint64_t d = 0; d < uint64_t(n) * n; ++d) {
    uint32_t x, y;
    hilbert_cell(n, d, &x, &y);
    if (int(x) < columns && int(y) < rows) cells.push_back({int(x), int(y)});
  }
  return cells;
}

std::vector<Cell> spiral_cells(int columns, int rows) {
  std::vector<Cell> cells;
  const size_t total = size_t(columns) * size_t(rows);
  cells.reserve(total);
  int x = (columns - 1) / 2, y = (rows - 1) / 2;
  // Legs of 1, 1, 2, 2, 3, 3 ... steps: right, down, left, up.
  constexpr int kStepX[4] = {1, 0, -1, 0}, kStepY[4] = {0, 1, 0, -1};
  for (int leg = 0; cells.size() < total; ++leg) {
    for (int i = 0; i < leg / 2 + 1; ++i) {
      if (x >= 0 && x < columns && y >= 0 && y < rows) cells.push_back({x, y});
      x += kStepX[leg % 4];
      y += kStepY[leg % 4];
    }
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

}  // namespace

std::span<const BucketOrderEntry> bucket_order_table() { return kOrders; }

BucketOrder parse_bucket_order(std::string_view name) {
  return find_named(kOrders, "--bucket-order", "order", name).order;
}

std::vector<WorkItem> bucket_schedule(const Rect& window, int bucket_size, BucketOrder order,
                                      uint32_t samples_per_pixel, uint32_t seed) {
  std::vector<WorkItem> items;
  if (window.empty()) return items;
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

BucketDriver::BucketDriver(const DriverSettings& settings)
    : bucket_size_(settings.bucket_size), order_(parse_bucket_order(settings.bucket_order)) {
  if (bucket_size_ < 1 || bucket_size_ > 4096) {
    throw UsageError("--bucket-size: " + std::to_string(bucket_size_) +
                     " is outside the valid range 1 to 4096");
  }
}

FrameCounters BucketDriver::render(const Frame& frame, FrameObserver& observer,
                                   std::stop_token stop) {
  const std::vector<WorkItem> items =
      bucket_schedule(frame.window, bucket_size_, order_, frame.samples_per_pixel, frame.seed);
  // Workers take the next bucket from a counter rather than a share of the list in advance, so the
  // order is kept whatever the threads' speeds. One increment per bucket is no contention.
  std::atomic<size_t> next{0};
  std::atomic<bool> failed{false};
  std::mutex merge_mutex;
  FrameCounters total;
  const auto work = [&] {
    RenderWorker worker(frame);
    FilmTile tile(frame.aovs);
    while (!failed.load(std::memory_order_relaxed) && !stop.stop_requested()) {
      const size_t i = next.fetch_add(1, std::memory_order_relaxed);
      if (i >= items.size()) break;
      tile.reset(items[i].pixels);
      worker.render(items[i], tile, observer, stop);
      try {
        observer.tile_finished(tile);
      } catch (...) {
        failed = true;
        throw;
      }
    }
    const std::lock_guard lock(merge_mutex);
    total.merge(worker.counters());
  };
  const int workers = std::max(1, tbb::this_task_arena::max_concurrency());
  parallel_tasks(size_t(workers), [&](size_t) { work(); });
  if (next.load() < items.size()) {
    total.stopped = true;
    total.min_samples = 0;
  }
  return total;
}

}  // namespace emberline
