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

// An integrand, and its convergence order with jittered sampling. A 2D edge cuts about sqrt(N) of
// the N cells, so the variance falls as N^-1.5. A smooth 2D integrand varies within a cell in
// proportion to the cell's side, so the variance falls as N^-2 (Mitchell 1996, "Consequences of
// Stratified Sampling in Graphics"). "4D coupled" is smooth too, but its variance falls only as
// N^-1: its two pairs of random numbers are jittered separately, so the part of the integrand that
// depends on both pairs is not stratified.
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
// `seed`. Creates a new sampler for each N if the sampler must know N in advance. Throws UsageError
// for an unknown name. Runs in parallel; the result is bit-identical for any number of threads.
std::vector<ConvergenceCurve> convergence_curves(const std::string& sampler, uint32_t pixels,
                                                 uint32_t seed);

}  // namespace emberline
