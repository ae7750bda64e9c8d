// Gives back the light of rare bright samples, which filtering would lose: the pixel with such a
// sample becomes as dark as its neighbours, and the neighbours reject the pixel's light. If a
// neighbourhood loses more light than its usual noise explains, the loss is returned to the
// neighbourhood's noisiest pixels, where the light came from. This is linear in the images, so
// light groups still add up to the whole.
#pragma once

#include "renderer/reconstruction/halves.h"

namespace emberline {

class OutlierEnergy {
 public:
  // Measures the loss as the difference between the raw and the filtered image.
  OutlierEnergy(const Halves& halves, const ColourPlanes& raw, const ColourPlanes& filtered);

  // Adds the lost light of `raw` to `filtered`. A pixel depends on pixels up to kOutlierEnergyReach
  // away.
  void restore(const BorderedPlane& raw, BorderedPlane& filtered) const;

  // Returns, for each pixel, the fraction of a change that restore() would undo if filtering
  // changed only this pixel.
  const BorderedPlane& own_fraction() const { return own_fraction_; }

 private:
  const Halves& halves_;
  BorderedPlane share_;  // fraction of a local loss that is returned, divided by noise and area
  BorderedPlane own_fraction_;
};

inline constexpr int kOutlierEnergyRadius = 5;
inline constexpr int kOutlierEnergyReach = 2 * kOutlierEnergyRadius;

}  // namespace emberline
