// Spectral curves of the linear Rec. 709 channels, for tables that are built at first use.
#pragma once

#include <cmath>

#include "renderer/core/vector.h"

namespace emberline {

// Returns the CIE 1931 colour matching functions at a wavelength, by the multi-lobe fit of Wyman,
// Sloan & Shirley 2013, "Simple Analytic Approximations to the CIE XYZ Color Matching Functions",
// equation 4.
inline Vec3d cie_1931(double nanometres) {
  const auto lobe = [nanometres](double height, double peak, double below, double above) {
    const double t = (nanometres - peak) * (nanometres < peak ? below : above);
    return height * std::exp(-0.5 * t * t);
  };
  return {lobe(0.362, 442.0, 0.0624, 0.0374) + lobe(1.056, 599.8, 0.0264, 0.0323) +
              lobe(-0.065, 501.1, 0.0490, 0.0382),
          lobe(0.821, 568.8, 0.0213, 0.0247) + lobe(0.286, 530.9, 0.0613, 0.0322),
          lobe(1.217, 437.0, 0.0845, 0.0278) + lobe(0.681, 459.0, 0.0385, 0.0725)};
}

// Converts XYZ to linear Rec. 709 (ITU-R BT.709-6 primaries and D65). The matrix has the same
// digits as in KHR_materials_iridescence.
inline Vec3d rec709_of_xyz(const Vec3d& c) {
  return {3.2404542 * c.x - 1.5371385 * c.y - 0.4985314 * c.z,
          -0.9692660 * c.x + 1.8760108 * c.y + 0.0415560 * c.z,
          0.0556434 * c.x - 0.2040259 * c.y + 1.0572252 * c.z};
}

// Returns the response of each channel to a wavelength. A response is negative where the spectral
// colour is outside the Rec. 709 gamut.
inline Vec3d rec709_response(double nanometres) { return rec709_of_xyz(cie_1931(nanometres)); }

inline constexpr double kFirstNanometre = 380.0, kLastNanometre = 780.0;

}  // namespace emberline
