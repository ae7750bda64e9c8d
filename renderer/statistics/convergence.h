// Convergence of the mean of N samples: variance against N for samplers alone, on integrands with
// known means.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/statistics/integrands.h"

namespace emberline {

// An integrand, and the convergence order of jittered samples on it: an edge cuts about sqrt(N) of
// N cells, so N^-1.5; a smooth function varies within a cell in proportion to its side, so N^-2
// (Mitchell 1996, "Consequences of Stratified Sampling in Graphics").
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
  std::optional<double> expected;  // from theory or long measurements, if known
};

// Curves for every integrand, over `pixels` pixels with `seed`. A sampler that must know N in
// advance is created for each N. Throws UsageError for an unknown name. Parallel, with the same
// bits for any number of threads.
std::vector<ConvergenceCurve> convergence_curves(const std::string& sampler, uint32_t pixels,
                                                 uint32_t seed);

}  // namespace emberline
