// Measures how evenly two pairs of dimensions are distributed together, from their orders
// (owen_sobol.h) without any sample. If an integrand couples two pairs, the first 2^m points of a
// scrambled net have the variance of random numbers times a gain for each of its frequencies (Owen
// 1997, "Monte Carlo Variance of Scrambled Net Quadrature"): the sum over the points of +1, -1 or
// 0, depending on the binary digits in which they agree with the first. Here it is summed over all
// frequencies, with weights that fall by kDigitDecay per digit.
#pragma once

#include <bit>

#include "samplers/owen_sobol.h"

namespace emberline::test {

inline constexpr double kDigitDecay = 0.4;

// 1 + the weighted sum over one number's digits; v is the difference, lowest digit first.
inline double digit_sum(uint32_t v) {
  if (v == 0) return 1 / (1 - kDigitDecay);
  double sum = 1, weight = kDigitDecay;
  for (int k = std::countr_zero(v); k > 0; --k, weight *= kDigitDecay) sum += weight;
  return sum - weight;
}

// For a pair with the point of this index; for its first number alone; for its second.
inline double pair_sum(uint32_t index) {
  return digit_sum(index) * digit_sum(owen_sobol::pascal(index)) - 1;
}
inline double first_sum(uint32_t index) { return digit_sum(index) - 1; }
inline double second_sum(uint32_t index) { return digit_sum(owen_sobol::pascal(index)) - 1; }

}  // namespace emberline::test
