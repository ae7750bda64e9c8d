// A glass material and a sky, for tests.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

#include "support/scenes.h"

namespace emberline::test {

inline MaterialDescription glass(float ior, float roughness, bool solid = true) {
  MaterialDescription m;
  m.base_color = Rgb(1.0f);
  m.metallic = 0.0f;
  m.roughness = roughness;
  m.ior = ior;
  m.transmission = 1.0f;
  m.thin_walled = !solid;
  return m;
}

// Returns a sky with radiance 1 above the horizon and 0 below. The radiance is interpolated between
// the two rows of texels at the horizon, but no ray of these tests goes there.
inline std::shared_ptr<const Image> upper_half() {
  auto image = std::make_shared<Image>();
  image->width = 4;
  image->height = 64;
  image->channels = 3;
  image->type = TexelType::kFloat;
  std::vector<float> texels(size_t(image->width * image->height * 3), 0.0f);
  std::fill(texels.begin(), texels.begin() + std::ptrdiff_t(texels.size() / 2), 1.0f);
  image->texels.resize(texels.size() * sizeof(float));
  std::memcpy(image->texels.data(), texels.data(), image->texels.size());
  return image;
}

// Returns the reflectance of a dielectric interface for unpolarised light from outside.
inline double fresnel(double theta, double eta) {
  const double ci = std::cos(theta), ct = std::sqrt(1 - square(std::sin(theta) / eta));
  const double s = (ci - eta * ct) / (ci + eta * ct), p = (eta * ci - ct) / (eta * ci + ct);
  return (s * s + p * p) / 2;
}

}  // namespace emberline::test
