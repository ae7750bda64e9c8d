// Measures how evenly two pairs of dimensions are distributed together. It needs only the orders of
// the pairs (owen_sobol.h), and no samples. If an integrand couples two pairs, each of its
// frequencies contributes to the variance of the first 2^m points of a scrambled net. Its
// contribution is that for random numbers times a gain (Owen 1997, "Monte Carlo Variance of
// Scrambled Net Quadrature"). The gain is a sum over the points. A point's term is +1, -1 or 0,
// depending on the binary digits in which it agrees with the first point. This file adds up the
// gains of all frequencies, with weights that decrease by the factor kDigitDecay per digit.
#pragma once

#include <bit>

#include "samplers/owen_sobol.h"

namespace emberline::test {

inline constexpr double kDigitDecay = 0.4;

// Returns 1 plus the weighted sum over the digits of one number of a pair. v is the difference
// between two such numbers, whose first digit is in the lowest bit.
inline double digit_sum(uint32_t v) {
  if (v == 0) return 1 / (1 - kDigitDecay);
  double sum = 1, weight = kDigitDecay;
  for (int k = std::countr_zero(v); k > 0; --k, weight *= kDigitDecay) sum += weight;
  return sum - weight;
}

// These functions return the sums for the point of this index: for its pair of numbers, only for
// its first number, and only for its second number.
inline double pair_sum(uint32_t index) {
  return digit_sum(index) * digit_sum(owen_sobol::pascal(index)) - 1;
}
inline double first_sum(uint32_t index) { return digit_sum(index) - 1; }
inline double second_sum(uint32_t index) { return digit_sum(owen_sobol::pascal(index)) - 1; }

}  // namespace emberline::test
