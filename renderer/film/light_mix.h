// Relights a picture, finished or not, without new rays. Light is additive, so the new picture is
// the sum of the light groups, each multiplied by its change in brightness (Dorsey, Arvo &
// Greenberg 1995, "Interactive Design of Complex Time-Dependent Lighting").
#pragma once

#include <span>
#include <vector>

#include "renderer/core/color4.h"
#include "renderer/core/vector.h"

namespace emberline {

class FilmTile;
class LightGroupSums;

// Weights of the light groups or of the light-path layers.
class LightMix {
 public:
  enum class Source { kLights, kPaths };
  // weights[g] is the weight of group g and must be finite. There must be one weight for each group
  // of the film.
  explicit LightMix(std::span<const Rgb> weights, Source source = Source::kLights);

  LightGroupSums sums(const FilmTile& film, size_t pixel) const;

  size_t size() const { return weights_.size(); }
  const Color4* data() const { return weights_.data(); }

 private:
  std::vector<Color4> weights_;
  Source source_;
};

// Writes R G B A of every pixel of a film with light groups, interleaved, rows from the top: the
// weighted sum of the groups' means, and the alpha of the samples. All values are finite; pixels
// without samples are black. Values set by FilmTile::set_override() are ignored. If all weights are
// 1, the result equals the film's own picture to within a relative error of 1e-5, since each group
// is rounded separately. Uses the calling thread's TBB arena, which does not affect the result's
// bits.
void relight(const FilmTile& film, const LightMix& mix, std::span<float> rgba);

}  // namespace emberline
