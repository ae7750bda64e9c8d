// What the air of a clear day is made of, and what its light looks like.
#pragma once

#include <array>

#include "renderer/core/vector.h"

namespace emberline::atmosphere {

// Radii of the earth and of the air around it, in metres.
inline constexpr double kGround = 6360e3, kTop = 6460e3;

// Wavelengths: 16 means over 20 nm, from 380 nm on.
inline constexpr size_t kBands = 16;
using Spectrum = std::array<float, kBands>;

// Per metre: at the ground, and of ozone where there is most. Haze is grey.
struct Coefficients {
  Spectrum rayleigh, ozone;
  float haze_scattering, haze_extinction;
};
const Coefficients& coefficients();

// How much there is at a height, in metres, of what the coefficients say.
struct Density {
  double rayleigh, haze, ozone;
};
Density density(double height);

// Per steradian, of the cosine between the ways before and after.
double rayleigh_phase(double cosine);
double haze_phase(double cosine);

// Luminances of linear Rec. 709, in cd/m^2, of radiances that are so much of the sun's spectral
// irradiance outside the air; negative where that has no such colour.
Vec3d to_rgb(const Spectrum& share_of_the_sun);

}  // namespace emberline::atmosphere
