#include "renderer/drivers/bucket_schedule.h"

#include <algorithm>
#include <bit>
#include <cassert>

#include "renderer/core/errors.h"
#include "renderer/core/hash.h"

namespace emberline {
namespace {

constexpr NamedValue<BucketOrder> kOrders[] = {
    {"hilbert", "along a Hilbert curve: each bucket touches the previous one",
     BucketOrder::kHilbert},
    {"spiral", "from the middle outwards", BucketOrder::kSpiral},
    {"scanline", "row by row from the top", BucketOrder::kScanline},
    {"random", "in random order, for an early impression of the whole frame", BucketOrder::kRandom},
};

struct Cell {
  int x, y;
};

// Returns the step at which Hilbert's curve over a 2^k x 2^k grid passes cell (x, y). From the
// highest bit down, each pair of bits of the step selects a quadrant and rotates the curve inside
// it. Example for k = 2: cell (3, 0) is in the last quadrant (3), at the upper right. Within this
// quadrant, after the rotation, the cell is again in the last quadrant (3). So its step is 4 x 3 +
// 3 = 15.
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

// Sorts the cells by step. A walk along the curve would visit the whole square around the frame;
// this took two minutes for a frame of 65536 x 1 buckets.
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

// Clips the range [first, last) of a spiral's leg to the steps i with 0 <= from + step * i < size.
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
  // The legs have 1, 1, 2, 2, 3, 3 ... steps. They go right, down, left and up in turn.
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

}  // namespace

std::span<const NamedValue<BucketOrder>> bucket_order_table() { return kOrders; }

std::vector<Rect> bucket_schedule(const Rect& crop, int bucket_size, BucketOrder order,
                                  uint32_t seed) {
  assert(bucket_size > 0);
  std::vector<Rect> buckets;
  if (crop.empty()) return buckets;
  // A longer list would cost more time and memory than the buckets save.
  constexpr uint64_t kMaxBuckets = 1 << 24;
  if (bucket_count(crop, bucket_size) > kMaxBuckets) {
    throw UsageError("`bucket-size`: " + std::to_string(bucket_size) +
                     " would divide the frame into more than 16777216 buckets; make them larger");
  }
  const int columns = (crop.width() + bucket_size - 1) / bucket_size;
  const int rows = (crop.height() + bucket_size - 1) / bucket_size;
  const std::vector<Cell> cells = order == BucketOrder::kHilbert  ? hilbert_cells(columns, rows)
                                  : order == BucketOrder::kSpiral ? spiral_cells(columns, rows)
                                  : order == BucketOrder::kScanline
                                      ? scanline_cells(columns, rows)
                                      : random_cells(columns, rows, seed);
  buckets.reserve(cells.size());
  for (const Cell& cell : cells) {
    const int x = crop.x0 + cell.x * bucket_size;
    const int y = crop.y0 + cell.y * bucket_size;
    buckets.push_back(Rect{x, y, x + bucket_size, y + bucket_size}.intersect(crop));
  }
  return buckets;
}

uint64_t bucket_count(const Rect& crop, int bucket_size) {
  const int64_t size = bucket_size;
  return uint64_t((crop.width() + size - 1) / size * ((crop.height() + size - 1) / size));
}

// While the order is computed, a bucket needs a curve step and two cells, and then a cell and a
// rectangle: 24 bytes. Later it needs more: two rectangles, an error and a count.
uint64_t bucket_list_bytes(const Rect& crop, int bucket_size) {
  constexpr uint64_t kBytes = 48;
  return kBytes * bucket_count(crop, bucket_size);
}

int round_up_to_buckets(int bucket_size, int least) {
  return bucket_size * ((least + bucket_size - 1) / bucket_size);
}

ActiveBuckets active_buckets(const Rect& crop, int bucket_size, int threads) {
  const int64_t columns = (crop.width() - 1) / bucket_size + 1;
  const int64_t rows = (crop.height() - 1) / bucket_size + 1;
  return {.count = std::min<int64_t>(columns * rows, threads),
          .width = std::min(crop.width(), bucket_size),
          .height = std::min(crop.height(), bucket_size)};
}

size_t bucket_index(const Rect& crop, const Rect& bucket, int bucket_size) {
  const auto columns = size_t((crop.width() + bucket_size - 1) / bucket_size);
  return size_t((bucket.y0 - crop.y0) / bucket_size) * columns +
         size_t((bucket.x0 - crop.x0) / bucket_size);
}

}  // namespace emberline
