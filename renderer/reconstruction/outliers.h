// Rare bright samples: the neighbours of one refuse its smear while the pixel itself is filtered,
// and its light would be gone. What a neighbourhood lost beyond what its common noise explains goes
// back to those of its pixels that are noisiest, which is where it came from. Linear in the
// pictures, so that light groups still add up.
#pragma once

#include "renderer/reconstruction/halves.h"

namespace emberline {

class LostLight {
 public:
  // Of the raw picture and the filtered one.
  LostLight(const Halves& halves, const ColourPlanes& raw, const ColourPlanes& filtered);

  // Adds to `filtered` what it has lost of `raw`. A pixel depends on those kLostLightReach around
  // it.
  void give_back(const BorderedPlane& raw, BorderedPlane& filtered) const;

  // How much of a change that a pixel alone made comes back to it.
  const BorderedPlane& own_share() const { return own_share_; }

 private:
  const Halves& halves_;
  BorderedPlane
      share_;  // of a neighbourhood's loss that is given back, over its noise and its area
  BorderedPlane own_share_;
};

inline constexpr int kLostLightRadius = 5;
inline constexpr int kLostLightReach = 2 * kLostLightRadius;

}  // namespace emberline
