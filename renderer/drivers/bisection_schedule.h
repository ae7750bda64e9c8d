// The order of `bisection`, after Arikan & Gudukbay, "Bisection-based progressive refinement"
// (2000): a line between two halves, then a line in the middle of each half, breadth-first, so that
// the first few lines already show the frame. A pure function of the crop, listed by tests
// without rendering. All lines count from the crop's corner.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/core/names.h"
#include "renderer/core/rect.h"
#include "renderer/drivers/driver_choices.h"

namespace emberline {

struct PixelWork;

std::span<const NamedValue<BisectionAxis>> bisection_axis_table();

// The lines [0, size) level by level: a queue begins with [0, size); from each interval [a, b)
// taken out comes the line m = (a + b) / 2, and [a, m) and [m + 1, b) go in, where not empty. Each
// level is ascending, and between two neighbours of all earlier levels lies one of its lines at
// most. Size 7: {3}, {1, 5}, {0, 2, 4, 6}.
std::vector<std::vector<int>> bisection_levels(int size);

// The pixels where a column and a row cross; both ascending.
struct PixelLattice {
  std::vector<int> columns, rows;

  uint64_t pixels() const { return uint64_t(columns.size()) * rows.size(); }
};

// One level: adds the pixels of `added`, none of which an earlier step had; then all pixels of
// `complete` have samples.
struct BisectionStep {
  PixelLattice added, complete;
};

// Columns and rows that stay together for the sake of the caches; a level then consists of cells.
struct BisectionCell {
  int width = 1, height = 1;
};

// The steps of a frame.
//   rows     a level of rows each, all columns (as in the paper)
//   columns  likewise
//   both     first the frame's middle; then a level of columns on the rows that are there or of
//            rows on the columns that are, whichever axis has the longer gaps; columns if equal.
//            So every complete step is a lattice, evenly spread over the frame.
// With cells of more than a pixel it is their rows and columns that are halved; those at the right
// and lower end may be smaller.
std::vector<BisectionStep> bisection_steps(int width, int height, BisectionAxis axis,
                                           const BisectionCell& cell = {});

// `sample_count` further samples of every pixel.
struct SampleRange {
  uint32_t first_sample = 0, sample_count = 0;
  bool operator==(const SampleRange&) const = default;
};
// A first sample for every pixel, then 1, 2, 4, 8 ... further ones up to `samples_per_pixel`: each
// pass doubles what is there, and from the sixth on consists of whole batches of 16.
std::vector<SampleRange> bisection_passes(uint32_t samples_per_pixel);

// Width and height of a block of `pixels` (a power of two): equal, or the width twice the height.
BisectionCell square_cell(uint64_t pixels);

// The shape of a part: a piece of one line, or nearly a square.
enum class PartShape { kRow, kColumn, kSquare };

// One pass over all steps, cut into parts for the workers: blocks of at most `part_pixels` pixels
// (a power of two) of a step's lattice, row of blocks by row of blocks. Refers to `steps`, which
// must outlive it.
class BisectionPass {
 public:
  BisectionPass(std::span<const BisectionStep> steps, const Rect& crop, const SampleRange& samples,
                PartShape shape, uint64_t part_pixels);

  size_t parts() const { return first_parts_.back(); }
  // Parts of step s are [first_part(s), first_part(s + 1)).
  size_t first_part(size_t step) const { return first_parts_[step]; }
  size_t step_of(size_t part) const;
  uint64_t pixels(size_t part) const;
  // Appends the part's pixels: along its line, or, of a square part, tile by tile of 4 x 4.
  void expand(size_t part, std::vector<PixelWork>& list) const;

  // How a step is cut: block (i, j) is part first_part(step) + j * across + i.
  struct Blocks {
    size_t width = 1, height = 1;  // in lattice points; the last of a row or column may have fewer
    size_t across = 1, down = 1;
  };
  const Blocks& blocks(size_t step) const { return blocks_[step]; }
  const SampleRange& samples() const { return samples_; }

 private:
  struct Block {
    std::span<const int> columns, rows;
  };
  Block block(size_t part) const;

  std::span<const BisectionStep> steps_;
  Rect crop_;
  SampleRange samples_;
  PartShape shape_;
  std::vector<Blocks> blocks_;
  std::vector<size_t> first_parts_;  // one more than there are steps
};

}  // namespace emberline
