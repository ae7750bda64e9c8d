#include "renderer/statistics/convergence.h"

#include <array>
#include <cmath>
#include <memory>

#include "renderer/core/names.h"
#include "renderer/statistics/row_sums.h"
#include "renderer/statistics/value_list.h"

namespace emberline {
namespace {

const ConvergenceIntegrand kIntegrands[] = {
    {{"smooth", smooth, (std::numbers::e - 1.0) / 3.0, 2.9}, 2.0},
    {{"axis edge", axis_edge, kThird, 2.0}, 1.5},
    {{"tilted edge", tilted_edge, 0.3 + 0.37 / 2, 1.49}, 1.5},
    {{"disc", disc, 0.16 * kPiDouble, 1.57}, 1.5},
    {{"4D coupled", coupled, gauss_pair(4.0) * gauss_pair(4.0), 2.0}, 1.0},
};
constexpr size_t kIntegrandCount = std::size(kIntegrands);
constexpr uint32_t kMinCount = 16, kMaxCount = 4096;

std::vector<uint32_t> counts() {
  std::vector<uint32_t> list;
  for (uint32_t n = kMinCount; n <= kMaxCount; n *= 2) list.push_back(n);
  return list;
}

// Sums of squared errors, by count and integrand.
struct Errors {
  std::vector<double> squares = std::vector<double>(counts().size() * kIntegrandCount);
  Errors& operator+=(const Errors& other) {
    for (size_t i = 0; i < squares.size(); ++i) squares[i] += other.squares[i];
    return *this;
  }
};

// For each N in counts()[first .. last), computes one pixel's mean of N samples, with the sampler's
// weights, and adds its squared error to `errors`.
void add_errors(const Sampler& sampler, const PixelKey& pixel, size_t first, size_t last,
                Errors& errors) {
  const std::vector<uint32_t> all = counts();
  std::vector<std::array<double, kIntegrandCount>> values;
  values.reserve(all[last - 1]);
  for_each_sample(sampler, pixel, 0, all[last - 1], [&](uint32_t, const SlotNumbers& numbers) {
    std::array<double, kIntegrandCount>& v = values.emplace_back();
    for (size_t i = 0; i < kIntegrandCount; ++i) v[i] = kIntegrands[i].integrand.value(numbers);
  });
  for (size_t n = first; n < last; ++n) {
    std::array<double, kIntegrandCount> sums = {};
    for (uint32_t k = 0; k < all[n]; ++k) {
      const auto weight = double(sampler.integration_weight(k, all[n]));
      for (size_t i = 0; i < kIntegrandCount; ++i) sums[i] += weight * values[k][i];
    }
    for (size_t i = 0; i < kIntegrandCount; ++i) {
      const double error = sums[i] / all[n] - kIntegrands[i].integrand.mean;
      errors.squares[n * kIntegrandCount + i] += error * error;
    }
  }
}

Errors measure(const SamplerEntry& entry, uint32_t pixels, uint32_t seed) {
  const std::vector<uint32_t> all = counts();
  std::vector<std::unique_ptr<Sampler>> samplers;  // one for all counts, or one for each count
  if (entry.counts == SampleCounts::kAny) {
    samplers.push_back(create_sampler(entry.name, {}));
  } else {
    for (const uint32_t n : all)
      samplers.push_back(create_sampler(entry.name, {.samples_per_pixel = n}));
  }
  // Sums the errors of pixels in groups of kRow, so that there are few partial sums.
  constexpr uint32_t kRow = 64;
  return sum_rows<Errors>(int((pixels + kRow - 1) / kRow), [&](int y) {
    Errors errors;
    const uint32_t width = std::min(kRow, pixels - uint32_t(y) * kRow);
    for (uint32_t x = 0; x < width; ++x) {
      const PixelKey pixel = {x, uint32_t(y), seed};
      if (samplers.size() == 1) {
        add_errors(*samplers[0], pixel, 0, all.size(), errors);
      } else {
        for (size_t n = 0; n < all.size(); ++n) add_errors(*samplers[n], pixel, n, n + 1, errors);
      }
    }
    return errors;
  });
}

// Fits a least-squares line to log variance against log N, and returns its slope, negated.
double fitted_order(const ConvergenceCurve& curve) {
  std::vector<double> counts, variances;
  for (size_t i = 0; i < curve.counts.size(); ++i) {
    counts.push_back(std::log(curve.counts[i]));
    variances.push_back(std::log(curve.variance[i]));
  }
  return -least_squares_slope(counts, variances);
}

std::optional<double> expected_order(ConvergenceRate rate, const ConvergenceIntegrand& integrand) {
  if (rate == ConvergenceRate::kSobol) return integrand.integrand.order;
  if (rate == ConvergenceRate::kJittered) return integrand.stratified_order;
  return rate == ConvergenceRate::kIndependent ? std::optional(1.0) : std::nullopt;
}

}  // namespace

std::span<const ConvergenceIntegrand> convergence_integrands() { return kIntegrands; }

std::vector<ConvergenceCurve> convergence_curves(const std::string& sampler, uint32_t pixels,
                                                 uint32_t seed) {
  const SamplerEntry& entry = find_named(sampler_table(), "`samplers`", "sampler", sampler);
  const Errors errors = measure(entry, pixels, seed);
  std::vector<ConvergenceCurve> curves;
  for (size_t i = 0; i < kIntegrandCount; ++i) {
    ConvergenceCurve& curve = curves.emplace_back();
    curve.sampler = sampler;
    curve.integrand = kIntegrands[i].integrand.name;
    curve.counts = counts();
    for (size_t n = 0; n < curve.counts.size(); ++n) {
      curve.variance.push_back(errors.squares[n * kIntegrandCount + i] / pixels);
    }
    curve.order = fitted_order(curve);
    curve.expected = expected_order(entry.rate, kIntegrands[i]);
  }
  return curves;
}

}  // namespace emberline
