#include "renderer/statistics/chart_axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "renderer/core/readable.h"

namespace emberline {
namespace {

constexpr double kMaxDrawable = 1e100;
// Margin at both ends of a logarithmic axis, as a fraction of its length.
constexpr double kMargin = 0.04;
// Tolerance, as a fraction of a step, for ticks that rounding puts slightly outside the range.
constexpr double kRounding = 1e-9;

std::string superscript(int number) {
  constexpr const char* kDigits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = number < 0 ? "⁻" : "";
  for (const char digit : std::to_string(std::abs(number))) text += kDigits[digit - '0'];
  return text;
}

}  // namespace

double nice_step(double range, int max_parts) {
  const double min_step = range / max_parts;
  const double power = std::pow(10.0, std::floor(std::log10(min_step)));
  for (const double step : {power, 2 * power, 5 * power}) {
    if (step * (1 + kRounding) >= min_step) return step;
  }
  return 10 * power;
}

std::string power_of_ten_text(const std::string& mantissa, int exponent) {
  const std::string power = "10" + superscript(exponent);
  return mantissa == "1" ? power : mantissa + "×" + power;
}

std::string tick_label(double value, double step) {
  if (std::abs(value) < kRounding * step) return "0";
  const double size = std::abs(value);
  if (size >= 1e-4 && size < 1e6) {
    const int decimals = std::max(0, int(-std::floor(std::log10(step) + kRounding)));
    return with_separators(fmt::format("{:.{}f}", value, decimals));
  }
  const int exponent = int(std::floor(std::log10(size) + kRounding));
  const int digits = std::max(0, exponent - int(std::floor(std::log10(step) + kRounding)));
  return power_of_ten_text(fmt::format("{:.{}f}", value / std::pow(10.0, exponent), digits),
                           exponent);
}

bool AxisRange::drawable(AxisScale scale, double value) {
  if (!(std::abs(value) <= kMaxDrawable)) return false;
  return scale == AxisScale::kLinear || value >= 1.0 / kMaxDrawable;
}

AxisRange::AxisRange(AxisScale scale, std::span<const double> values, bool from_zero)
    : scale_(scale) {
  bool found = false;
  for (const double v : values) {
    if (!drawable(scale, v)) continue;
    min_ = found ? std::min(min_, v) : v;
    max_ = found ? std::max(max_, v) : v;
    found = true;
  }
  if (scale == AxisScale::kLog) {
    if (!found) min_ = 1, max_ = 10;
    if (!(max_ > min_ * 1.0001)) min_ /= 2, max_ *= 2;
    const double margin = std::pow(max_ / min_, kMargin);
    min_ /= margin, max_ *= margin;
    return;
  }
  if (!found) min_ = 0, max_ = 1;
  if (from_zero) min_ = std::min(min_, 0.0), max_ = std::max(max_, 0.0);
  // If the values are nearly equal, the length of the axis depends on their magnitude, not on their
  // difference.
  const double size = std::max(std::abs(min_), std::abs(max_));
  if (!(max_ - min_ > 1e-6 * size)) {
    const double around = size > 0 ? 0.5 * size : 0.5;
    min_ -= from_zero && min_ == 0 ? 0 : around;
    max_ += around;
  }
  const double step = nice_step(max_ - min_, 6);
  min_ = step * std::floor(min_ / step + kRounding);
  max_ = step * std::ceil(max_ / step - kRounding);
}

double AxisRange::position(double value) const {
  if (scale_ == AxisScale::kLinear) return (value - min_) / (max_ - min_);
  return std::log(value / min_) / std::log(max_ / min_);
}

std::vector<AxisTick> AxisRange::linear_ticks(int target_count) const {
  std::vector<AxisTick> ticks;
  // An axis needs at least two ticks, so use smaller steps until there are two.
  for (; ticks.size() < 2; ++target_count) {
    ticks.clear();
    const double step = nice_step(max_ - min_, target_count);
    const double first = std::ceil(min_ / step - kRounding), last = max_ / step + kRounding;
    for (double i = first; i <= last; ++i) ticks.push_back({i * step, tick_label(i * step, step)});
  }
  return ticks;
}

std::vector<AxisTick> AxisRange::log_ticks(int target_count) const {
  const int first = int(std::floor(std::log10(min_))), last = int(std::ceil(std::log10(max_)));
  const double decades = std::log10(max_ / min_);
  // If the range is narrower than about a factor of three, it may contain no power of ten.
  if (decades < 0.5) return linear_ticks(target_count);
  const int every = std::max(1, int(std::ceil(decades / target_count)));
  const int numbers = decades * 3 <= target_count + 1 ? 3 : 1;  // labels: 1, 2 and 5, or only 1
  std::vector<AxisTick> ticks;
  for (int exponent = first; exponent <= last; ++exponent) {
    const double power = std::pow(10.0, exponent);
    for (const int digit : {1, 2, 5}) {
      const double value = digit * power;
      if (value < min_ || value > max_ || (digit > 1 && every > 1)) continue;
      const bool labelled = digit == 1 ? exponent % every == 0 : numbers == 3;
      ticks.push_back({value, labelled ? tick_label(value, power) : std::string()});
    }
  }
  return ticks;
}

std::vector<AxisTick> AxisRange::ticks(int target_count) const {
  return scale_ == AxisScale::kLinear ? linear_ticks(target_count) : log_ticks(target_count);
}

}  // namespace emberline
