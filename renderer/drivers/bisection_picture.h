// The picture of `bisection` before every pixel has a sample: gaps between lines show the nearest
// line, or a blend of the two lines around.
#pragma once

#include <span>
#include <vector>

#include "renderer/core/names.h"
#include "renderer/drivers/bisection_schedule.h"
#include "renderer/drivers/driver_choices.h"

namespace emberline {

class FilmTile;
class LightMix;

std::span<const NamedValue<Reconstruction>> reconstruction_table();

// Progress of the first pass.
struct BisectionCoverage {
  size_t complete_steps = 0;
  // How many parts of the next step are complete, and how many may have begun.
  size_t complete_parts = 0, begun_parts = 0;
};

// A line of pixels as a blend of two sampled lines; lower == upper if one of them suffices.
struct LineBlend {
  int lower = 0, upper = 0;
  float weight = 0.0f;  // weight of `upper`
};
// Returns for each of `size` lines how to show it from `lines`, which must be ascending and not
// empty: as the nearest of these (the lower one if two are equally near), or as a linear blend of
// the two around it.
std::vector<LineBlend> blend_lines(std::span<const int> lines, int size,
                                   Reconstruction reconstruction);

// The film must not change during resolve(). All referenced objects must outlive this.
struct BisectionPicture {
  std::span<const BisectionStep> steps;
  const BisectionPass& first_pass;  // contains how the steps are cut into parts
  const FilmTile& film;
  Reconstruction reconstruction;
  BisectionCoverage coverage;

  // Computes each pixel from the lattice of the current step if all samples needed for the pixel
  // exist, otherwise from the lattice of the last complete step. The picture is black if there are
  // no samples. Uses the calling thread's TBB arena.
  void resolve(std::span<float> rgba, const LightMix* mix = nullptr) const;
};

}  // namespace emberline
