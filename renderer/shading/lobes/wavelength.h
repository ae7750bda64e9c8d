// Samples one wavelength per path, and computes indices of refraction at that wavelength
// (KHR_materials_dispersion).
#pragma once

#include "renderer/core/vector.h"

namespace emberline {

struct SampledWavelength {
  float nanometres;
  Rgb weight;  // factor on the path's radiance, linear Rec. 709; >= 0, at most 3
};

// Maps u in [0, 1) monotonically to a wavelength, so neighbouring values of u stay neighbours. The
// density of wavelengths is the mean of the three channels' responses, so no weight exceeds 3. The
// mean weight over uniform u is (1, 1, 1), so without dispersion colours do not change.
//
// The responses are the CIE 1931 functions (see colour_matching.h), converted to Rec. 709, clamped
// to non-negative values, then normalised per channel. Without the clamp, spectral colours, which
// are outside Rec. 709, would have negative channels, and paths of negative radiance would break
// variance estimates, Russian roulette and denoisers. Clamping makes single spectral colours a
// little paler, but mixtures are exact, because every channel keeps its full weight.
SampledWavelength sample_wavelength(float u);

// Returns the index of refraction, at least 1, by the extension's formula. This is Cauchy's
// equation, n = A + B / lambda^2, for an Abbe number of 20 / dispersion and an index of ior_d at
// Fraunhofer's d line. An ior_d of 0 (KHR_materials_ior: reflects everything) stays 0.
float ior_at(float ior_d, float dispersion, float nanometres);

}  // namespace emberline
