// Rare bright samples: the neighbours of such a pixel reject its light while the pixel itself is
// filtered, so the light would be lost. A neighbourhood's loss beyond its usual noise is returned
// to its noisiest pixels, where it came from. Linear in the images, so that light groups still add
// up.
#pragma once

#include "renderer/reconstruction/halves.h"

namespace emberline {

class OutlierEnergy {
 public:
  // From the raw and the filtered image.
  OutlierEnergy(const Halves& halves, const ColourPlanes& raw, const ColourPlanes& filtered);

  // Adds the lost light of `raw` to `filtered`, depending on pixels up to kOutlierEnergyReach away.
  void restore(const BorderedPlane& raw, BorderedPlane& filtered) const;

  // Fraction of a single pixel's change that is returned to the pixel.
  const BorderedPlane& own_fraction() const { return own_fraction_; }

 private:
  const Halves& halves_;
  BorderedPlane share_;  // returned fraction of a neighbourhood's loss, over its noise and area
  BorderedPlane own_fraction_;
};

inline constexpr int kOutlierEnergyRadius = 5;
inline constexpr int kOutlierEnergyReach = 2 * kOutlierEnergyRadius;

}  // namespace emberline
