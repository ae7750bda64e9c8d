// One wavelength for a whole path, and indices of refraction at it (KHR_materials_dispersion).
#pragma once

#include "renderer/core/vector.h"

namespace emberline {

struct SampledWavelength {
  float nanometres;
  Rgb weight;  // of the path's radiance, linear Rec. 709; >= 0, at most 3
};

// u in [0, 1) to a wavelength, increasing, with the mean of the three channels' responses as its
// density, so that neighbouring u stay neighbours and no weight exceeds 3. The mean weight over
// uniform u is (1, 1, 1): white stays white, and what does not disperse keeps its colour.
//
// Responses: CIE 1931 (see colour_matching.h) to Rec. 709, negative parts cut, each channel then
// divided by its integral. Spectral colours lie outside Rec. 709, so some of their channels are
// negative; a path of negative radiance would break variance estimates, roulette and denoisers.
// Cutting makes lone spectral colours a little paler than they are; where wavelengths mix again
// nothing is off, since every channel has its whole weight.
SampledWavelength sample_wavelength(float u);

// The extension's formula: Cauchy's equation, n = A + B / lambda^2, of Abbe number V = 20 /
// dispersion through ior_d at Fraunhofer's d line; at least 1. An ior_d of 0 (KHR_materials_ior:
// reflects everything) stays 0.
float ior_at(float ior_d, float dispersion, float nanometres);

}  // namespace emberline
