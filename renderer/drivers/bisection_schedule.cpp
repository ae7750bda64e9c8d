#include "renderer/drivers/bisection_schedule.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <numeric>

#include "renderer/drivers/frame_driver.h"

namespace emberline {
namespace {

// Side of the tiles in which square parts list their pixels. The 16 pixels of a tile share a batch
// of samples. The camera rays of a batch are traced together and should be close to each other.
constexpr size_t kTile = 4;

constexpr NamedValue<BisectionAxis> kAxes[] = {
    {"rows", "by rows, as in the paper", BisectionAxis::kRows},
    {"columns", "by columns", BisectionAxis::kColumns},
    {"both", "by columns and rows in turn: samples are spread evenly, for the best early picture",
     BisectionAxis::kBoth},
};

std::vector<int> all_lines(int size) {
  std::vector<int> lines(size_t(size), 0);
  std::iota(lines.begin(), lines.end(), 0);
  return lines;
}

std::vector<int> merged(const std::vector<int>& a, const std::vector<int>& b) {
  std::vector<int> lines(a.size() + b.size());
  std::ranges::merge(a, b, lines.begin());
  return lines;
}

// Returns the steps that add whole lines level by level along one axis. `lines` is the lattice's
// member for that axis; `across` is the member for the other axis.
std::vector<BisectionStep> line_steps(int size, int length, std::vector<int> PixelLattice::*lines,
                                      std::vector<int> PixelLattice::*across) {
  std::vector<BisectionStep> steps;
  const std::vector<int> all = all_lines(length);
  for (std::vector<int>& level : bisection_levels(size)) {
    BisectionStep step;
    step.added.*across = step.complete.*across = all;
    step.complete.*lines = steps.empty() ? level : merged(steps.back().complete.*lines, level);
    step.added.*lines = std::move(level);
    steps.push_back(std::move(step));
  }
  return steps;
}

std::vector<BisectionStep> lattice_steps(int width, int height) {
  const std::vector<std::vector<int>> columns = bisection_levels(width);
  const std::vector<std::vector<int>> rows = bisection_levels(height);
  const PixelLattice middle{columns[0], rows[0]};
  std::vector<BisectionStep> steps = {{middle, middle}};
  size_t i = 1, j = 1;  // number of complete levels; gaps are about width / 2^i and height / 2^j
  while (i < columns.size() || j < rows.size()) {
    const bool split_columns = int64_t(width) << j >= int64_t(height) << i;
    const PixelLattice& before = steps.back().complete;
    BisectionStep step;
    if (j == rows.size() || (split_columns && i < columns.size())) {
      step.added = {columns[i], before.rows};
      step.complete = {merged(before.columns, columns[i]), before.rows};
      ++i;
    } else {
      step.added = {before.columns, rows[j]};
      step.complete = {before.columns, merged(before.rows, rows[j])};
      ++j;
    }
    steps.push_back(std::move(step));
  }
  return steps;
}

// Returns the lines of [0, size) that the cells cover.
std::vector<int> lines_of_cells(const std::vector<int>& cells, int cell, int size) {
  std::vector<int> lines;
  for (const int c : cells) {
    for (int line = c * cell; line < std::min(size, (c + 1) * cell); ++line) lines.push_back(line);
  }
  return lines;
}

BisectionPass::Blocks make_blocks(const PixelLattice& lattice, PartShape shape,
                                  uint64_t part_pixels) {
  const size_t columns = lattice.columns.size(), rows = lattice.rows.size();
  BisectionPass::Blocks blocks;
  if (shape == PartShape::kRow) {
    blocks.width = std::min<uint64_t>(columns, part_pixels);
  } else if (shape == PartShape::kColumn) {
    blocks.height = std::min<uint64_t>(rows, part_pixels);
  } else {
    // If there are only a few rows or columns, the blocks become long instead of small.
    blocks.height = std::min(rows, size_t(square_cell(part_pixels).height));
    blocks.width = std::min<uint64_t>(columns, part_pixels / blocks.height);
    blocks.height = std::min<uint64_t>(rows, part_pixels / blocks.width);
  }
  blocks.across = (columns + blocks.width - 1) / blocks.width;
  blocks.down = (rows + blocks.height - 1) / blocks.height;
  return blocks;
}

std::vector<BisectionStep> cell_steps(int width, int height, BisectionAxis axis) {
  switch (axis) {
    case BisectionAxis::kRows:
      return line_steps(height, width, &PixelLattice::rows, &PixelLattice::columns);
    case BisectionAxis::kColumns:
      return line_steps(width, height, &PixelLattice::columns, &PixelLattice::rows);
    case BisectionAxis::kBoth:
      break;
  }
  return lattice_steps(width, height);
}

}  // namespace

std::span<const NamedValue<BisectionAxis>> bisection_axis_table() { return kAxes; }

std::vector<std::vector<int>> bisection_levels(int size) {
  struct Interval {
    int begin, end;
  };
  std::vector<std::vector<int>> levels;
  std::vector<Interval> queue, next;
  if (size > 0) queue.push_back({0, size});
  while (!queue.empty()) {
    std::vector<int>& lines = levels.emplace_back();
    next.clear();
    for (const auto& [a, b] : queue) {
      const int m = a + (b - a) / 2;
      lines.push_back(m);
      if (a < m) next.push_back({a, m});
      if (m + 1 < b) next.push_back({m + 1, b});
    }
    std::swap(queue, next);
  }
  return levels;
}

std::vector<BisectionStep> bisection_steps(int width, int height, BisectionAxis axis,
                                           const BisectionCell& cell) {
  if (width <= 0 || height <= 0) return {};
  const int columns = (width + cell.width - 1) / cell.width;
  const int rows = (height + cell.height - 1) / cell.height;
  std::vector<BisectionStep> steps = cell_steps(columns, rows, axis);
  for (BisectionStep& step : steps) {
    for (PixelLattice* lattice : {&step.added, &step.complete}) {
      lattice->columns = lines_of_cells(lattice->columns, cell.width, width);
      lattice->rows = lines_of_cells(lattice->rows, cell.height, height);
    }
  }
  return steps;
}

BisectionCell square_cell(uint64_t pixels) {
  const int bits = int(std::bit_width(pixels)) - 1;
  return {1 << (bits - bits / 2), 1 << bits / 2};
}

void add_bisection_passes(uint32_t done, uint32_t samples_per_pixel,
                          std::vector<SampleRange>& passes) {
  while (done < samples_per_pixel) {
    const uint32_t count = std::min(std::max(done, 1u), samples_per_pixel - done);
    passes.push_back({done, count});
    done += count;
  }
}

std::vector<SampleRange> bisection_passes(uint32_t samples_per_pixel) {
  std::vector<SampleRange> passes;
  add_bisection_passes(0, samples_per_pixel, passes);
  return passes;
}

BisectionPass::BisectionPass(std::span<const BisectionStep> steps, const Rect& crop,
                             const SampleRange& samples, PartShape shape, uint64_t part_pixels)
    : steps_(steps), crop_(crop), samples_(samples), shape_(shape), first_parts_{0} {
  assert(std::has_single_bit(part_pixels));
  for (const BisectionStep& step : steps) {
    const Blocks& blocks = blocks_.emplace_back(make_blocks(step.added, shape, part_pixels));
    first_parts_.push_back(first_parts_.back() + blocks.across * blocks.down);
  }
}

size_t BisectionPass::step_of(size_t part) const {
  assert(part < parts());
  return size_t(std::ranges::upper_bound(first_parts_, part) - first_parts_.begin()) - 1;
}

BisectionPass::Block BisectionPass::block(size_t part) const {
  const size_t step = step_of(part);
  const Blocks& blocks = blocks_[step];
  const size_t index = part - first_parts_[step];
  const auto clipped = [](const std::vector<int>& lines, size_t first, size_t count) {
    return std::span(lines).subspan(first, std::min(count, lines.size() - first));
  };
  const PixelLattice& added = steps_[step].added;
  return {clipped(added.columns, index % blocks.across * blocks.width, blocks.width),
          clipped(added.rows, index / blocks.across * blocks.height, blocks.height)};
}

uint64_t BisectionPass::pixels(size_t part) const {
  const Block b = block(part);
  return uint64_t(b.columns.size()) * b.rows.size();
}

void BisectionPass::expand(size_t part, std::vector<PixelWork>& list) const {
  const Block b = block(part);
  const size_t width = b.columns.size(), height = b.rows.size();
  const size_t tile = shape_ == PartShape::kSquare ? kTile : std::max(width, height);
  for (size_t y0 = 0; y0 < height; y0 += tile) {
    for (size_t x0 = 0; x0 < width; x0 += tile) {
      for (size_t j = y0; j < std::min(y0 + tile, height); ++j) {
        for (size_t i = x0; i < std::min(x0 + tile, width); ++i) {
          list.push_back({crop_.x0 + b.columns[i], crop_.y0 + b.rows[j], samples_.first_sample,
                          samples_.sample_count});
        }
      }
    }
  }
}

}  // namespace emberline
