#include "samplers/poisson_disk_sampler.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <memory>
#include <vector>

#include "samplers/sample_runs.h"

namespace emberline {
namespace {

constexpr uint32_t kPoissonDiskSalt = 0xd15c5a17u;
constexpr uint32_t kTableSize = 1024;
constexpr uint32_t kTables = 8;
constexpr int kTablePairs = 2;                           // pairs with tables, per slot
constexpr uint32_t kTableSlots = kTables / kTablePairs;  // slots [0, kTableSlots) have tables

// Coordinates are in units of 2^-32, so that integer overflow wraps around the torus.
struct Table {
  uint32_t x[kTableSize], y[kTableSize];
};

double squared_distance(const Table& t, uint32_t i, uint32_t x, uint32_t y) {
  const double dx = int32_t(t.x[i] - x) * 0x1p-32, dy = int32_t(t.y[i] - y) * 0x1p-32;
  return dx * dx + dy * dy;
}

// Returns the square of the minimum distance of n points: kPoissonDiskRadius times the neighbour
// distance in the hexagonal lattice of n points on the unit torus.
double squared_spacing(uint32_t n) {
  return kPoissonDiskRadius * kPoissonDiskRadius * 2.0 / (std::sqrt(3.0) * n);
}

// A spatial grid of the points placed so far. The cells are at least as wide as the query distance.
class CellGrid {
 public:
  CellGrid(const Table& table, uint32_t points, double distance)
      : table_(table), side_(std::max(1u, uint32_t(1.0 / distance))), first_(side_ * side_, kNone) {
    for (uint32_t i = 0; i < points; ++i) add(i);
  }

  void add(uint32_t point) {
    uint32_t& first = first_[cell(table_.y[point]) * side_ + cell(table_.x[point])];
    next_[point] = first;
    first = point;
  }

  // Whether all points are at least sqrt(squared) away from (x, y). The caller must make sure that
  // this distance is at most the cell width.
  bool keeps_distance(uint32_t x, uint32_t y, double squared) const {
    const uint32_t column = cell(x), row = cell(y);
    for (const uint32_t r : {row, before(row), after(row)}) {
      for (const uint32_t c : {column, before(column), after(column)}) {
        for (uint32_t i = first_[r * side_ + c]; i != kNone; i = next_[i]) {
          if (squared_distance(table_, i, x, y) < squared) return false;
        }
      }
    }
    return true;
  }

 private:
  static constexpr uint32_t kNone = ~0u;
  uint32_t cell(uint32_t u) const { return uint32_t(uint64_t(u) * side_ >> 32); }
  uint32_t before(uint32_t c) const { return c == 0 ? side_ - 1 : c - 1; }
  uint32_t after(uint32_t c) const { return c + 1 == side_ ? 0 : c + 1; }

  const Table& table_;
  uint32_t side_;
  std::vector<uint32_t> first_;            // first point of each cell
  std::array<uint32_t, kTableSize> next_;  // next point in the same cell
};

// Throws darts until one keeps the minimum distance, and stores it as point n. The loop ends: the
// tables are deterministic, so one successful run proves that the radius leaves room for every
// point.
void throw_darts(Table& table, uint32_t n, const CellGrid& grid, uint64_t& state) {
  do {
    const uint64_t bits = hash64(state += 0x9e3779b97f4a7c15ull);
    table.x[n] = uint32_t(bits);
    table.y[n] = uint32_t(bits >> 32);
  } while (!grid.keeps_distance(table.x[n], table.y[n], squared_spacing(n + 1)));
}

Table make_table(uint64_t state) {
  Table table;
  // A new grid whenever the number of points has doubled keeps about one point per cell.
  for (uint32_t begin = 0; begin < kTableSize; begin = std::max(1u, 2 * begin)) {
    CellGrid grid(table, begin, std::sqrt(squared_spacing(begin + 1)));
    for (uint32_t n = begin; n < std::min(kTableSize, std::max(1u, 2 * begin)); ++n) {
      throw_darts(table, n, grid, state);
      grid.add(n);
    }
  }
  return table;
}

using Tables = std::array<Table, kTables>;

// Builds the tables once, for all samplers and seeds. Random shifts make the pixels differ.
const Tables& tables() {
  static const auto instance = [] {
    auto result = std::make_unique<Tables>();
    for (uint32_t t = 0; t < kTables; ++t) (*result)[t] = make_table(hash64(kPoissonDiskSalt + t));
    return result;
  }();
  return *instance;
}

// Writes one pair's numbers for a run; `key` selects the symmetry and the shift.
void fill_pair(const Table& table, uint32_t key, const SampleRun& run, float* x, float* y) {
  const uint32_t symmetry = hash_combine(key, 0);
  const uint32_t shift_x = hash_combine(key, 1), shift_y = hash_combine(key, 2);
  const uint32_t mirror_x = symmetry & 1u ? ~0u : 0u, mirror_y = symmetry & 2u ? ~0u : 0u;
  const uint32_t* table_x = (symmetry & 4u ? table.y : table.x) + run.index;
  const uint32_t* table_y = (symmetry & 4u ? table.x : table.y) + run.index;
  for (int i = 0; i < run.count; ++i) {
    x[i] = to_unit_float((table_x[i] ^ mirror_x) + shift_x);
    y[i] = to_unit_float((table_y[i] ^ mirror_y) + shift_y);
  }
}

}  // namespace

PoissonDiskSampler::PoissonDiskSampler(const SamplerSettings& settings)
    : streams_(settings.streams), fallback_(settings) {
  tables();  // build them before the first pixel
}

void PoissonDiskSampler::fill(const PixelKey& pixel, uint32_t slot, uint32_t first_sample,
                              int count, SlotBlock& out, int dimensions) const {
  assert(count >= 1 && first_sample % kSampleLanes + uint32_t(count) <= kSampleLanes);
  const bool has_tables = slot < kTableSlots;
  if (!has_tables || dimensions > 2 * kTablePairs) {
    fallback_.fill(pixel, slot, first_sample, count, out, dimensions);
  }
  if (!has_tables) return;
  for_each_run(streams_, {kTableSize, kTableSize}, first_sample, count, [&](const SampleRun& run) {
    const uint32_t hash = run_hash(pixel, run, kPoissonDiskSalt);
    for (uint32_t p = 0; p < uint32_t(kTablePairs) && 2 * int(p) < dimensions; ++p) {
      const uint32_t pair = kTablePairs * slot + p;
      // An odd stride visits every table once. The stride is random, which averages out accidental
      // correlation between any two tables.
      const Table& table = tables()[(hash + pair * (hash >> 3 | 1u)) % kTables];
      fill_pair(table, hash_combine(hash, pair), run, out.values[2 * p] + run.lane,
                out.values[2 * p + 1] + run.lane);
    }
  });
}

}  // namespace emberline
