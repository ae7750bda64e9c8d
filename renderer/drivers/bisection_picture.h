// The picture that `bisection` shows before every pixel has a sample. Gaps between sampled lines
// show the nearest line, or a blend of the two lines around the gap.
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
  // For the next step: the number of parts that are complete, and of parts that may have begun.
  size_t complete_parts = 0, begun_parts = 0;
};

// Describes a line of pixels as a blend of two sampled lines. If one sampled line suffices, `lower`
// and `upper` are equal.
struct LineBlend {
  int lower = 0, upper = 0;
  float weight = 0.0f;  // weight of `upper`
};
// Returns, for each of `size` lines, how to show it. `lines` are the sampled lines, which must be
// ascending and not empty. Depending on `reconstruction`, a line shows the nearest sampled line
// (the lower one if two are equally near), or a linear blend of the two sampled lines around it.
std::vector<LineBlend> blend_lines(std::span<const int> lines, int size,
                                   Reconstruction reconstruction);

// The film must not change during resolve(). All referenced objects must outlive this object.
struct BisectionPicture {
  std::span<const BisectionStep> steps;
  const BisectionPass& first_pass;  // knows how the steps are cut into parts
  const FilmTile& film;
  Reconstruction reconstruction;
  BisectionCoverage coverage;

  // Computes the whole picture. A pixel comes from the lattice of the current step if all samples
  // needed for this exist, otherwise from the lattice of the last complete step. The picture is
  // black if there are no samples. Uses the calling thread's TBB arena.
  void resolve(std::span<float> rgba, const LightMix* mix = nullptr) const;
};

}  // namespace emberline
