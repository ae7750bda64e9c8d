// Measures how a sampler converges: computes the variance of the mean of N samples as a function of
// N. Uses integrands with known means instead of a scene.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/statistics/integrands.h"

namespace emberline {

// An integrand, and the convergence order of jittered samples on it. An edge cuts about sqrt(N) of
// N cells, so the variance is ~ N^-1.5. A smooth function varies within a cell in proportion to the
// cell's side, so its variance is ~ N^-2 (Mitchell 1996, "Consequences of Stratified Sampling in
// Graphics").
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

// Computes a curve for every integrand, from the errors of `pixels` pixels that are sampled with
// `seed`. Samplers that must know N in advance are created for each N. Throws UsageError for an
// unknown name. Runs in parallel; the result is bit-identical for any number of threads.
std::vector<ConvergenceCurve> convergence_curves(const std::string& sampler, uint32_t pixels,
                                                 uint32_t seed);

}  // namespace emberline
