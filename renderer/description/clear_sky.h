// A clear sky and its sun: an environment for a scene that comes with none.
//
// What air, haze and ozone around a round earth (atmosphere.h) scatter of the sun's light towards
// the ground: once, as an integral along the view; more often after S. Hillaire, "A Scalable and
// Production Ready Sky and Atmosphere Rendering Technique" (EGSR 2020), section 5.5, which takes
// light that has met the air before as coming from everywhere alike. No refraction: the sun sets
// when it is behind the horizon.
#pragma once

#include "renderer/description/scene_description.h"

namespace emberline {

// cd/m^2 that are a radiance of 1: about what a white surface shows under a high sun.
inline constexpr double kSkyUnit = 32768;

struct SkySettings {
  // Of the sun's middle, in degrees: above the horizon, from -90 to 90; and from -Z over +X, +Z,
  // -X.
  double elevation = 45, azimuth = 0;
  // Of the ground, which is grey, fills the lower half of the map and lights the air.
  double ground_albedo = 0.3;
  bool scattered_again = true;  // false: light is scattered once
  int height = 512;             // of the map
};

// A map of float texels, and the sun, unless it has set. Uses all threads.
EnvironmentDescription clear_sky(const SkySettings& settings);

}  // namespace emberline
