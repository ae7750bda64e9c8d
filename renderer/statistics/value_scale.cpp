#include "renderer/statistics/value_scale.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace emberline {
namespace {

// Of the values that are not 0: what lies above is shown as the brightest.
constexpr double kQuantile = 0.995;
// Ticks are products of doubles: a value so many steps outside is still inside.
constexpr double kRounding = 1e-9;
// Values whose logarithms are about to leave double's range are not told apart.
constexpr double kSmallest = 1e-300;

double upper_quantile(const Plane& plane) {
  std::vector<float> values;
  values.reserve(plane.values.size());
  for (const float value : plane.values) {
    if (std::isfinite(value) && value != 0.0f) values.push_back(value);
  }
  // 1000 values: the 995th, five are above it.
  const auto rank =
      std::max<ptrdiff_t>(0, ptrdiff_t(std::ceil(kQuantile * double(values.size()))) - 1);
  std::ranges::nth_element(values, values.begin() + rank);
  return double(values[size_t(rank)]);
}

ValueRange around(double value, bool logarithmic) {
  if (logarithmic)
    return value > kSmallest ? ValueRange{value / 10, value * 10} : ValueRange{1, 10};
  if (value == 0.0) return {0, 1};
  return value > 0 ? ValueRange{0, 2 * value} : ValueRange{2 * value, 0};
}

// The least of 1, 2 or 5 times a power of ten that divides `length` into at most `parts`.
double nice_step(double length, int parts) {
  const double least = length / parts, power = std::pow(10.0, std::floor(std::log10(least)));
  for (const double step : {power, 2 * power, 5 * power}) {
    if (step * (1 + kRounding) >= least) return step;
  }
  return 10 * power;
}

}  // namespace

ValueRange automatic_range(const Plane& plane, bool logarithmic) {
  const PlaneStatistics s = plane_statistics(plane);
  if (s.values == 0) return around(0.0, logarithmic);
  if (s.constant()) return around(s.minimum, logarithmic);
  if (!logarithmic) {
    const double least = std::min(0.0, s.minimum), most = upper_quantile(plane);
    return {least, most > least ? most : std::max(0.0, s.maximum)};
  }
  double least = HUGE_VAL;
  for (const float value : plane.values) {
    if (value > 0.0f && std::isfinite(value)) least = std::min(least, double(value));
  }
  return least < s.maximum ? ValueRange{least, s.maximum} : around(s.maximum, true);
}

ValueScale::ValueScale(const ValueRange& range, bool logarithmic)
    : range_(range), logarithmic_(logarithmic) {
  assert(range.least < range.most && (!logarithmic || range.least > 0));
}

double ValueScale::position(double value) const {
  if (!std::isfinite(value)) return NAN;
  if (!logarithmic_) return (value - range_.least) / (range_.most - range_.least);
  if (value <= 0.0) return -HUGE_VAL;
  return std::log(value / range_.least) / std::log(range_.most / range_.least);
}

std::vector<ScaleTick> ValueScale::linear_ticks(int most, double factor) const {
  const double least = range_.least * factor, greatest = range_.most * factor;
  const double step = nice_step(greatest - least, most - 1);
  const int decimals = std::max(0, -int(std::floor(std::log10(step) + kRounding)));
  std::vector<ScaleTick> ticks;
  for (double i = std::ceil(least / step - kRounding); i <= greatest / step + kRounding; ++i) {
    const double value = i * step + 0.0;  // no "-0"
    const bool plain = value == 0.0 || (std::abs(value) < 1e6 && decimals < 6);
    ticks.push_back(
        {value / factor, plain ? fmt::format("{:.{}f}", value, decimals) : number_text(value)});
  }
  return ticks;
}

std::vector<double> ValueScale::decade_ticks(int most, double factor) const {
  const double least = std::log10(range_.least * factor) - kRounding;
  const double greatest = std::log10(range_.most * factor) + kRounding;
  const auto gather = [&](std::initializer_list<int> digits, int every) {
    std::vector<double> ticks;
    for (int exponent = int(std::floor(least)); exponent <= greatest; ++exponent) {
      if (exponent % every != 0) continue;
      for (const int digit : digits) {
        const double value = digit * std::pow(10.0, exponent), place = std::log10(value);
        if (place >= least && place <= greatest) ticks.push_back(value);
      }
    }
    return ticks;
  };
  std::vector<double> ticks = gather({1, 2, 5}, 1);
  for (int every = 1; int(ticks.size()) > most; ++every) ticks = gather({1}, every);
  return ticks;
}

std::vector<ScaleTick> ValueScale::ticks(int most, double factor) const {
  std::vector<ScaleTick> ticks;
  if (logarithmic_) {
    for (const double value : decade_ticks(most, factor)) {
      ticks.push_back({value / factor, number_text(value)});
    }
  }
  // Within less than a factor of five there may be no such number at all, or one.
  return ticks.size() < 2 ? linear_ticks(most, factor) : ticks;
}

std::string number_text(double value) {
  if (value == std::round(value) && std::abs(value) < 1e6) return fmt::format("{:.0f}", value);
  return fmt::format("{:.4g}", value);
}

ToldUnit told_unit(const std::string& unit, double size) {
  if (unit != "s" || !(size > 0.0)) return {1, unit};
  constexpr std::pair<double, const char*> kUnits[] = {{1, "s"}, {1e3, "ms"}, {1e6, "us"}};
  for (const auto& [factor, name] : kUnits) {
    if (size * factor >= 1.0) return {factor, name};
  }
  return {1e9, "ns"};
}

}  // namespace emberline
