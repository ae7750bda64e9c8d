// The order in which `bisection` renders, after Arikan & Gudukbay, "Bisection-based progressive
// refinement" (2000). It begins with a line between two halves of the frame. A line in the middle
// of each half follows, and so on, breadth-first. So the first few lines already show the frame.
// The order is a pure function of the crop, so tests can check it without rendering. Line numbers
// start at the crop's corner.
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

// Returns the lines [0, size) level by level. A queue starts with [0, size). Each interval [a, b)
// taken from the queue yields line m = (a + b) / 2, and adds [a, m) and [m + 1, b) to the queue if
// they are not empty. The lines of a level are ascending. Between two neighbouring lines of all
// earlier levels, a level has at most one line. Example for size 7: {3}, {1, 5}, {0, 2, 4, 6}.
std::vector<std::vector<int>> bisection_levels(int size);

// The pixels at the crossings of columns and rows. Both lists are ascending.
struct PixelLattice {
  std::vector<int> columns, rows;

  uint64_t pixels() const { return uint64_t(columns.size()) * rows.size(); }
};

// One step adds one level. No earlier step contains the pixels of `added`. After this step, all
// pixels of `complete` have samples.
struct BisectionStep {
  PixelLattice added, complete;
};

// The size of a cell in pixels. Steps add whole rows or columns of cells, so that neighbouring
// pixels are rendered together, which suits the caches.
struct BisectionCell {
  int width = 1, height = 1;
};

// Returns the steps of a frame.
//   rows     each step is a level of rows with all columns (as in the paper)
//   columns  each step is a level of columns with all rows
//   both     the first step is the frame's middle pixel; each later step is a level of columns on
//            the complete rows, or a level of rows on the complete columns. The axis with the
//            longer gaps is divided next (columns if the gaps are equal). Every complete step is
//            thus a lattice, evenly spread over the frame.
// With cells larger than a pixel, rows and columns of cells are bisected; cells at the right and
// lower end may be smaller.
std::vector<BisectionStep> bisection_steps(int width, int height, BisectionAxis axis,
                                           const BisectionCell& cell = {});

// Samples [first_sample, first_sample + sample_count) of every pixel.
struct SampleRange {
  uint32_t first_sample = 0, sample_count = 0;
  bool operator==(const SampleRange&) const = default;
};
// Returns the passes: one sample for every pixel, then 1, 2, 4, 8 ... more samples, up to
// `samples_per_pixel` in all. Each pass doubles the number of samples. From the sixth pass on, a
// pass consists of whole batches of 16.
std::vector<SampleRange> bisection_passes(uint32_t samples_per_pixel);
// Appends the passes that raise the count of every pixel from `done` to `samples_per_pixel`
// samples.
void add_bisection_passes(uint32_t done, uint32_t samples_per_pixel,
                          std::vector<SampleRange>& passes);

// Returns a cell of `pixels` pixels (a power of two). Its width is equal to its height or twice its
// height.
BisectionCell square_cell(uint64_t pixels);

// The shape of a part: a piece of one row or column, or roughly a square.
enum class PartShape { kRow, kColumn, kSquare };

// One pass over all steps, cut into parts for the workers. A part is a block of at most
// `part_pixels` pixels (a power of two) in a step's lattice. The blocks of a step follow in
// row-by-row order. `steps` must outlive the object.
class BisectionPass {
 public:
  BisectionPass(std::span<const BisectionStep> steps, const Rect& crop, const SampleRange& samples,
                PartShape shape, uint64_t part_pixels);

  size_t parts() const { return first_parts_.back(); }
  // Parts of step s are [first_part(s), first_part(s + 1)).
  size_t first_part(size_t step) const { return first_parts_[step]; }
  size_t step_of(size_t part) const;
  uint64_t pixels(size_t part) const;
  // Appends the part's pixels in order: along its line, or, for square parts, in tiles of 4 x 4.
  void expand(size_t part, std::vector<PixelWork>& list) const;

  // The blocks of a step. Block (i, j) is part first_part(step) + j * across + i.
  struct Blocks {
    size_t width = 1, height = 1;  // in lattice points; blocks at the far ends may be smaller
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
  std::vector<size_t> first_parts_;  // one entry more than there are steps
};

}  // namespace emberline
