// Composition of the air on a clear day, and the colour of its light.
#pragma once

#include <array>

#include "renderer/core/vector.h"

namespace emberline::atmosphere {

// Radii of the earth and of the top of its atmosphere, in metres.
inline constexpr double kGroundRadius = 6360e3, kTopRadius = 6460e3;

// Number of spectral bands. Each has a width of 20 nm; the first starts at 380 nm.
inline constexpr size_t kBands = 16;
using Spectrum = std::array<float, kBands>;

// Scattering and absorption coefficients per metre. They hold at the ground or, for ozone, at the
// height of its peak density. Haze is grey, so it has one value for all bands.
struct Coefficients {
  Spectrum rayleigh, ozone;
  float haze_scattering, haze_extinction;
};
const Coefficients& coefficients();

// Densities at a height in metres, relative to the densities for which Coefficients are given.
struct Density {
  double rayleigh, haze, ozone;
};
Density density(double height);

// Phase functions, per steradian. `cosine` is the cosine of the angle between the directions before
// and after scattering.
double rayleigh_phase(double cosine);
double haze_phase(double cosine);

// Converts radiance, given as fractions of the sun's spectral irradiance outside the atmosphere, to
// linear Rec. 709 in cd/m^2. Colours outside the gamut have negative channels.
Vec3d to_rgb(const Spectrum& relative_to_sun);

}  // namespace emberline::atmosphere
