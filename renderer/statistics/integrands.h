// Integrands whose means are known exactly, for comparing samplers. They are functions of the
// random numbers that a sampler gives to a camera ray. They resemble what occurs in a pixel, such
// as an edge, a disc or a gradient.
#pragma once

#include <cmath>
#include <numbers>

#include "renderer/core/vector.h"
#include "samplers/slot_numbers.h"

namespace emberline {

inline constexpr double kPiDouble = std::numbers::pi;

struct Integrand {
  const char* name;
  double (*value)(const SlotNumbers&);
  double mean;
  double order;  // variance ~ N^-order with the sobol sampler
};

inline double smooth(const SlotNumbers& n) {
  return double(n.u[0]) * n.u[0] * std::exp(double(n.u[1]));
}
// The edge at 1/3 cuts one of N = 2^m strata, always at 1/3 or 2/3 of the stratum's width, so the
// variance is exactly 2/9 / N^2.
inline constexpr float kThird = 1.0f / 3.0f;
inline double axis_edge(const SlotNumbers& n) { return n.u[0] < kThird ? 1.0 : 0.0; }
inline double tilted_edge(const SlotNumbers& n) {
  return n.u[1] < 0.3f + 0.37f * n.u[0] ? 1.0 : 0.0;
}
inline double disc(const SlotNumbers& n) {
  const double x = n.u[0] - 0.5, y = n.u[1] - 0.5;
  return x * x + y * y < 0.16 ? 1.0 : 0.0;
}
// Couples the random numbers for the position in the pixel with those for the lens.
inline double coupled(const SlotNumbers& n) {
  const double x = n.u[0] - n.u[2], y = n.u[1] - n.u[3];
  return std::exp(-4.0 * (x * x + y * y));
}

// Returns the integral of exp(-c (a - b)^2) over the unit square.
inline double gauss_pair(double c) {
  return std::sqrt(kPiDouble / c) * std::erf(std::sqrt(c)) - (1.0 - std::exp(-c)) / c;
}

}  // namespace emberline
