// Converts linear colours from one set of primaries to another.
#pragma once

#include <memory>

#include "renderer/core/time_curve.h"
#include "renderer/core/vector.h"

namespace emberline {

struct ColourMatrix {
  Vec3f red, green, blue;  // each holds the weights of the input channels for one output channel

  Rgb operator*(const Rgb& c) const { return {dot(red, c), dot(green, c), dot(blue, c)}; }
};

// Converts colours from linear Rec. 709, which scene descriptions use, to the working space. It is
// null if the working space is Rec. 709.
using ToWorkingSpace = std::shared_ptr<const ColourMatrix>;

inline Rgb converted(const ToWorkingSpace& matrix, const Rgb& c) {
  return matrix ? *matrix * c : c;
}

// `shares` scales each channel of `colour` over time. Returns the factors that scale the converted
// colour in the same way.
inline std::shared_ptr<const TimeCurve<Rgb>> converted(
    const ToWorkingSpace& matrix, const std::shared_ptr<const TimeCurve<Rgb>>& shares,
    const Rgb& colour) {
  if (!matrix || !shares) return shares;
  auto result = std::make_shared<TimeCurve<Rgb>>(*shares);
  const Rgb whole = *matrix * colour;
  for (Rgb& share : result->values) {
    const Rgb part = *matrix * (colour * share);
    for (int c = 0; c < 3; ++c) share[c] = whole[c] > 0.0f ? part[c] / whole[c] : 0.0f;
  }
  return result;
}

}  // namespace emberline
