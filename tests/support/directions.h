// Makes unit vectors from spherical coordinates around +Z, for tests of lobes.
#pragma once

#include <cmath>

#include "renderer/core/vector.h"

namespace emberline::test {

inline Vec3f direction(float mu, float phi) {
  const float r = std::sqrt((1 - mu) * (1 + mu));
  return {r * std::cos(phi), r * std::sin(phi), mu};
}

}  // namespace emberline::test
