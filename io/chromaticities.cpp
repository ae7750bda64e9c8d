// Compiled into the module that reads images, too, which has nothing of OpenColorIO.
#include <algorithm>
#include <cmath>

#include "io/working_space.h"

namespace emberline {

// ITU-R BT.709-6, section 1; SMPTE ST 2065-1 and the Academy's S-2014-004.
Chromaticities chromaticities_of(WorkingSpace space) {
  if (space == WorkingSpace::kAcesCg) {
    return {0.713f, 0.293f, 0.165f, 0.830f, 0.128f, 0.044f, 0.32168f, 0.33767f};
  }
  return {0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f};
}

WorkingSpace space_of(const Chromaticities& chromaticities) {
  const auto near = [](float a, float b) { return std::abs(a - b) < 1e-4f; };
  const bool acescg =
      std::ranges::equal(chromaticities, chromaticities_of(WorkingSpace::kAcesCg), near);
  return acescg ? WorkingSpace::kAcesCg : WorkingSpace::kRec709;
}

}  // namespace emberline
