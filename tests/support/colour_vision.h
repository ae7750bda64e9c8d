// Computes perceived colours in CIELAB, for observers with normal vision and for colour-blind
// observers.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "renderer/statistics/colour_map.h"

namespace emberline::test {

using Triple = std::array<double, 3>;
using Matrix = std::array<Triple, 3>;

inline Triple times(const Matrix& m, const Triple& v) {
  Triple out{};
  for (size_t i = 0; i < 3; ++i) out[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
  return out;
}

// Normal vision and the three dichromacies, as matrices for linear sRGB. The matrices are from
// Machado, Oliveira & Fernandes 2009, "A Physiologically-based Model for Simulation of Color Vision
// Deficiency", with severity 1.
inline constexpr Matrix kVisions[] = {{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
                                      {{{0.152286, 1.052583, -0.204868},
                                        {0.114503, 0.786281, 0.099216},
                                        {-0.003882, -0.048116, 1.051998}}},
                                      {{{0.367322, 0.860646, -0.227968},
                                        {0.280085, 0.672501, 0.047413},
                                        {-0.011820, 0.042940, 0.968881}}},
                                      {{{1.255528, -0.076749, -0.178779},
                                        {-0.078411, 0.930809, 0.147602},
                                        {0.004733, 0.691367, 0.303900}}}};

// Returns L*, a* and b* (CIE 15, D65) of an 8-bit sRGB colour.
inline Triple cielab(const Rgb8& colour, const Matrix& vision = kVisions[0]) {
  Triple linear{};
  for (size_t c = 0; c < 3; ++c) {
    const double v = colour[c] / 255.0;
    linear[c] = v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
  }
  linear = times(vision, linear);
  for (double& v : linear) v = std::clamp(v, 0.0, 1.0);
  constexpr Matrix kToXyz = {{{0.4124564, 0.3575761, 0.1804375},
                              {0.2126729, 0.7151522, 0.0721750},
                              {0.0193339, 0.1191920, 0.9503041}}};
  const Triple xyz = times(kToXyz, linear);
  const auto f = [](double t) {
    return t > 216.0 / 24389 ? std::cbrt(t) : (24389.0 / 27 * t + 16) / 116;
  };
  const double x = f(xyz[0] / 0.95047), y = f(xyz[1]), z = f(xyz[2] / 1.08883);
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

inline double lightness(const Rgb8& colour) { return cielab(colour)[0]; }

// Returns the CIE 1976 difference between two colours for the kind of vision for which it is
// smallest. A difference of 2.3 is just noticeable.
inline double min_difference(const Rgb8& a, const Rgb8& b) {
  double smallest = 1e9;
  for (const Matrix& vision : kVisions) {
    const Triple p = cielab(a, vision), q = cielab(b, vision);
    smallest = std::min(smallest, std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]));
  }
  return smallest;
}

}  // namespace emberline::test
