#include "renderer/statistics/value_scale.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "renderer/core/readable.h"
#include "renderer/statistics/value_list.h"

namespace emberline {
namespace {

// The dark end of a logarithmic range is this quantile of the positive values.
constexpr double kDarkQuantile = 0.005;
// Tolerance, as a fraction of a step, for ticks that rounding puts slightly outside the range.
constexpr double kTickRounding = 1e-9;
// If all values of a plane equal a smaller constant, a logarithmic range around it would reach the
// limits of double.
constexpr double kMinConstant = 1e-300;

template <typename Predicate>
std::vector<float> finite_values(const Plane& plane, const Predicate& predicate) {
  std::vector<float> values;
  values.reserve(plane.values.size());
  for (const float value : plane.values) {
    if (std::isfinite(value) && predicate(value)) values.push_back(value);
  }
  return values;
}

ValueRange range_around(double value, bool logarithmic) {
  if (logarithmic)
    return value > kMinConstant ? ValueRange{value / 10, value * 10} : ValueRange{1, 10};
  if (value == 0.0) return {0, 1};
  return value > 0 ? ValueRange{0, 2 * value} : ValueRange{2 * value, 0};
}

// Finds a round step with at most `max` multiples in the range.
double tick_step(double min, double greatest, int max) {
  double step = nice_step(greatest - min, max + 1);
  const auto multiples = [&] {
    return std::floor(greatest / step + kTickRounding) - std::ceil(min / step - kTickRounding) + 1;
  };
  while (multiples() > max) step = nice_step(1.5 * step, 1);  // the next larger step
  return step;
}

}  // namespace

ValueRange automatic_range(const Plane& plane, bool logarithmic, double bright) {
  const PlaneStatistics s = plane_statistics(plane);
  if (s.values == 0) return range_around(0.0, logarithmic);
  if (s.constant()) return range_around(s.minimum, logarithmic);
  if (logarithmic) {
    std::vector<float> positive = finite_values(plane, [](float v) { return v > 0.0f; });
    if (positive.empty()) return range_around(0.0, true);
    const double min = nearest_rank_quantile(std::move(positive), kDarkQuantile);
    return min < s.maximum ? ValueRange{min, s.maximum} : range_around(s.maximum, true);
  }
  const double min = std::min(0.0, s.minimum);
  const double max =
      nearest_rank_quantile(finite_values(plane, [](float v) { return v != 0.0f; }), bright);
  return {min, max > min ? max : std::max(0.0, s.maximum)};
}

ValueScale::ValueScale(const ValueRange& range, bool logarithmic)
    : range_(range), logarithmic_(logarithmic) {
  assert(range.min < range.max && (!logarithmic || range.min > 0));
}

double ValueScale::position(double value) const {
  if (!std::isfinite(value)) return NAN;
  if (!logarithmic_) return (value - range_.min) / (range_.max - range_.min);
  if (value <= 0.0) return -HUGE_VAL;
  return std::log(value / range_.min) / std::log(range_.max / range_.min);
}

std::vector<AxisTick> ValueScale::linear_ticks(int max, double factor) const {
  const double min = range_.min * factor, greatest = range_.max * factor;
  const double step = tick_step(min, greatest, max);
  std::vector<AxisTick> ticks;
  for (double i = std::ceil(min / step - kTickRounding); i <= greatest / step + kTickRounding;
       ++i) {
    const double value = i * step;
    ticks.push_back({value / factor, tick_label(value, step)});
  }
  return ticks;
}

std::vector<double> ValueScale::decade_ticks(int max, double factor) const {
  const double min = std::log10(range_.min * factor) - kTickRounding;
  const double greatest = std::log10(range_.max * factor) + kTickRounding;
  const auto gather = [&](std::initializer_list<int> digits, int every) {
    std::vector<double> ticks;
    for (int exponent = int(std::floor(min)); exponent <= greatest; ++exponent) {
      if (exponent % every != 0) continue;
      for (const int digit : digits) {
        const double value = digit * std::pow(10.0, exponent), logarithm = std::log10(value);
        if (logarithm >= min && logarithm <= greatest) ticks.push_back(value);
      }
    }
    return ticks;
  };
  std::vector<double> ticks = gather({1, 2, 5}, 1);
  if (ticks.size() < 2) return {};  // the range is narrower than a factor of five
  for (int every = 1; int(ticks.size()) > max; ++every) ticks = gather({1}, every);
  return ticks;
}

std::vector<AxisTick> ValueScale::ticks(int max, double factor) const {
  std::vector<AxisTick> ticks;
  if (logarithmic_) {
    for (const double value : decade_ticks(max, factor)) {
      ticks.push_back({value / factor, number_text(value)});
    }
  }
  return ticks.empty() ? linear_ticks(max, factor) : ticks;
}

std::string number_text(double value) {
  const double size = std::abs(value);
  if (!std::isfinite(value)) return readable_number(value);
  if (value == 0.0) return "0";  // no "-0"
  if (size >= 1e-4 && size < 1e6) {
    return with_separators(size >= 1e3 ? fmt::format("{:.0f}", value)
                                       : fmt::format("{:.4g}", value));
  }
  const std::string text = fmt::format("{:.3e}", value);
  const size_t e = text.find('e');
  std::string mantissa = text.substr(0, e);
  mantissa.erase(mantissa.find_last_not_of('0') + 1);
  if (mantissa.ends_with('.')) mantissa.pop_back();
  return power_of_ten_text(mantissa, std::stoi(text.substr(e + 1)));
}

DisplayUnit display_unit(const std::string& unit, double size) {
  if (unit != "s" || !(size > 0.0)) return {1, unit};
  constexpr std::pair<double, const char*> kUnits[] = {{1, "s"}, {1e3, "ms"}, {1e6, "µs"}};
  for (const auto& [factor, name] : kUnits) {
    if (size * factor >= 1.0) return {factor, name};
  }
  return {1e9, "ns"};
}

}  // namespace emberline
