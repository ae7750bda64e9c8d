// A finished or unfinished picture under other lights, without a new ray: light adds up, so the
// picture is the sum of what each light group gave to it, each times how much brighter it is now
// (Dorsey, Arvo & Greenberg 1995, "Interactive Design of Complex Time-Dependent Lighting").
#pragma once

#include <span>
#include <vector>

#include "renderer/core/color4.h"
#include "renderer/core/vector.h"

namespace emberline {

class FilmTile;
class LightGroupSums;

// What the radiance of each group is multiplied by; of light groups, or of layers by light path.
class LightMix {
 public:
  enum class Of { kLights, kPaths };
  // weights[g] is group g's, finite; of as many groups as the film has.
  explicit LightMix(std::span<const Rgb> weights, Of of = Of::kLights);

  // What is mixed of a film's pixel.
  LightGroupSums sums(const FilmTile& film, size_t pixel) const;

  size_t size() const { return weights_.size(); }
  const Color4* data() const { return weights_.data(); }

 private:
  std::vector<Color4> weights_;
  Of of_;
};

// R G B A of every pixel of a film with light groups, interleaved, rows from its top: the weighted
// sum of its groups' means, and the alpha of its samples. Black where there is no sample. Finite.
// What FilmTile::show() put into the film is not looked at. With all weights 1 it is the film's own
// picture to 1e-5 of its value, since each group rounds for itself. Uses the calling thread's TBB
// arena; the bits do not depend on it.
void relight(const FilmTile& film, const LightMix& mix, std::span<float> rgba);

}  // namespace emberline
