// Composition of the air on a clear day, and the colour of its light.
#pragma once

#include <array>

#include "renderer/core/vector.h"

namespace emberline::atmosphere {

// Radii of the earth and of its atmosphere, in metres.
inline constexpr double kGroundRadius = 6360e3, kTopRadius = 6460e3;

// Spectral bands: 16 means over 20 nm, starting at 380 nm.
inline constexpr size_t kBands = 16;
using Spectrum = std::array<float, kBands>;

// Per metre, at the ground; for ozone, at its peak density. Haze is grey.
struct Coefficients {
  Spectrum rayleigh, ozone;
  float haze_scattering, haze_extinction;
};
const Coefficients& coefficients();

// Densities at a height in metres, relative to those of the coefficients.
struct Density {
  double rayleigh, haze, ozone;
};
Density density(double height);

// Per steradian, as functions of the cosine between the directions before and after scattering.
double rayleigh_phase(double cosine);
double haze_phase(double cosine);

// Luminances of linear Rec. 709, in cd/m^2, for radiances given as fractions of the sun's spectral
// irradiance outside the atmosphere; negative outside the gamut.
Vec3d to_rgb(const Spectrum& relative_to_sun);

}  // namespace emberline::atmosphere
