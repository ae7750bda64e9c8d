// Measures how the mean of N samples converges: the variance as a function of N, for a sampler
// without a scene, on integrands with known means.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/statistics/integrands.h"

namespace emberline {

// An integrand, and the convergence order of jittered samples on it. An edge cuts about sqrt(N) of
// N cells, so the variance is ~ N^-1.5; a smooth function varies within a cell in proportion to the
// cell's side, so it is ~ N^-2 (Mitchell 1996, "Consequences of Stratified Sampling in Graphics").
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
  std::optional<double> expected;  // order from theory or long measurements, if known
};

// Computes a curve for every integrand, over `pixels` pixels with `seed`. Samplers that must know N
// in advance are created for each N. Throws UsageError for an unknown name. Runs in parallel; the
// result is the same to the bit for any number of threads.
std::vector<ConvergenceCurve> convergence_curves(const std::string& sampler, uint32_t pixels,
                                                 uint32_t seed);

}  // namespace emberline
