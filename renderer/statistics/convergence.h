// How fast the mean of N samples converges: variance against N for the samplers alone, on
// integrands whose means are known.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/statistics/integrands.h"

namespace emberline {

// An integrand, and the order that jittered samples have on it: cells that an edge cuts are about
// sqrt(N) of N, so N^-1.5; a smooth function varies within a cell as its side, so N^-2 (Mitchell
// 1996, "Consequences of Stratified Sampling in Graphics").
struct ConvergenceIntegrand {
  Integrand integrand;
  double stratified_order;
};
std::span<const ConvergenceIntegrand> convergence_integrands();

struct ConvergenceCurve {
  std::string sampler, integrand;
  std::vector<uint32_t> counts;    // N: 16, 32 .. 4096
  std::vector<double> variance;    // mean squared error of the mean of N samples
  double order = 0;                // fitted: variance ~ N^-order
  std::optional<double> expected;  // by theory or long measurement, where there is one
};

// Of every integrand, over `pixels` pixels with `seed`. A sampler that has to know N beforehand is
// made for each. Throws UsageError for an unknown name. Parallel, the same bits for any number of
// threads.
std::vector<ConvergenceCurve> convergence_curves(const std::string& sampler, uint32_t pixels,
                                                 uint32_t seed);

}  // namespace emberline
