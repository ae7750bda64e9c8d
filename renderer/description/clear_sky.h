// A clear sky and its sun, as an environment for scenes that have no environment.
//
// The light of the sky is sunlight that air and haze scatter towards the ground, and that ozone and
// haze partly absorb. The earth is spherical (atmosphere.h). Single scattering is integrated along
// the view ray. Multiple scattering follows S. Hillaire, "A Scalable and Production Ready Sky and
// Atmosphere Rendering Technique" (EGSR 2020), section 5.5, which treats scattered light as
// isotropic. There is no refraction, so the sun has set when it is geometrically behind the
// horizon.
#pragma once

#include "renderer/description/scene_description.h"

namespace emberline {

// The luminance in cd/m^2 that becomes a radiance of 1. A white surface under a high sun has
// roughly this luminance.
inline constexpr double kUnitLuminance = 32768;

struct SkySettings {
  // Position of the sun's centre in degrees: elevation above the horizon, from -90 to 90, and
  // azimuth, measured from -Z towards +X.
  double elevation = 45, azimuth = 0;
  // The ground is grey, fills the lower half of the map and illuminates the air.
  double ground_albedo = 0.3;
  bool multiple_scattering = true;  // false: single scattering only
  int height = 512;                 // of the map, in texels
};

// Returns an environment with a map of float texels and, unless the sun has set, with the sun. Uses
// all threads.
EnvironmentDescription clear_sky(const SkySettings& settings);

}  // namespace emberline
