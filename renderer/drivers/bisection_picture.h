// The frame of `bisection` as it is shown before every pixel has a sample: lines are duplicated
// into the gaps between them, or blended across.
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

// How much of the first pass is there.
struct BisectionCoverage {
  size_t complete_steps = 0;
  // In the following step: complete parts, and parts that may have begun.
  size_t complete_parts = 0, begun_parts = 0;
};

// A line of pixels as a blend of two lines that have samples; lower == upper where one of them is
// enough.
struct LineBlend {
  int lower = 0, upper = 0;
  float weight = 0.0f;  // of `upper`
};
// For each of `size` lines, how it is shown from `lines` (ascending, not empty): by the nearest
// one, of two as near the lower; or by the two around it, in proportion to their nearness.
std::vector<LineBlend> blend_lines(std::span<const int> lines, int size,
                                   Reconstruction reconstruction);

// Looks at a film that stands still while resolve() runs. Everything it refers to must outlive it.
struct BisectionPicture {
  std::span<const BisectionStep> steps;
  const BisectionPass& first_pass;  // says how the steps are cut into parts
  const FilmTile& film;
  Reconstruction reconstruction;
  BisectionCoverage coverage;

  // A pixel is shown from the lattice of the step under way where that has the samples it needs,
  // else from the lattice of the last complete step. Black if there is no sample at all. Uses the
  // calling thread's TBB arena.
  void resolve(std::span<float> rgba, const LightMix* mix = nullptr) const;
};

}  // namespace emberline
