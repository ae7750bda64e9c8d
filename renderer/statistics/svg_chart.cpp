#include "renderer/statistics/svg_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <ranges>
#include <string_view>
#include <type_traits>
#include <utility>

#include "renderer/statistics/value_scale.h"

namespace emberline {
namespace {

constexpr double kTextSize = 13;
constexpr double kLetter = 0.56 * kTextSize;  // approximate mean advance of a sans-serif letter
constexpr double kLine = 1.45 * kTextSize;

// Okabe & Ito's colours, with the text colour instead of black, which would be invisible on a dark
// page. Yellow is last, because it is faint on white.
constexpr const char* kColours[] = {"#0072b2", "#d55e00", "#009e73",      "#cc79a7",
                                    "#e69f00", "#56b4e9", "currentColor", "#f0e442"};
constexpr const char* kDashes[] = {"", "7 3", "2 3", "9 3 2 3", "12 4"};
// The shapes of markers, as SVG paths relative to the data point. The empty path stands for a
// circle.
constexpr const char* kMarkers[] = {"",
                                    "m-3.2 -3.2h6.4v6.4h-6.4z",
                                    "m0 -4.2l4.2 7.2h-8.4z",
                                    "m0 -4.6l4.6 4.6l-4.6 4.6l-4.6 -4.6z",
                                    "m0 4.2l4.2 -7.2h-8.4z",
                                    "m-1.4 -4.2h2.8v2.8h2.8v2.8h-2.8v2.8h-2.8v-2.8h-2.8v-2.8h2.8z",
                                    "m-4.2 -1.6h8.4v3.2h-8.4z"};

int style_of(const LineChart& chart, size_t series) {
  const int style = chart.series[series].style;
  return style >= 0 ? style : int(series);
}
const char* colour(int style) { return kColours[size_t(style) % std::size(kColours)]; }
const char* dash(int style) { return kDashes[size_t(style) % std::size(kDashes)]; }

// Formats a coordinate with at most two decimals, without trailing zeros and without "-0", so that
// the same coordinate always has the same text.
std::string number(double value) {
  std::string text = fmt::format("{:.2f}", value);
  while (text.back() == '0') text.pop_back();
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

template <typename T>
auto written(const T& value) {
  if constexpr (std::is_same_v<T, double>) {
    return number(value);
  } else {
    return value;
  }
}

// Like fmt::format(), but formats floating-point numbers with number().
std::string svg(const char* format, const auto&... values) {
  return fmt::format(fmt::runtime(format), written(values)...);
}

double text_width(std::string_view text) {
  const auto letters = std::ranges::count_if(
      text, [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; });
  return kLetter * double(letters);
}

// Returns the marker's tag without its closing bracket, so that the caller can add attributes or
// contents.
std::string marker(int style, double x, double y) {
  const std::string path = kMarkers[size_t(style) % std::size(kMarkers)];
  if (path.empty()) return svg(R"(<circle cx="{}" cy="{}" r="3.5" fill="{}")", x, y, colour(style));
  return svg(R"(<path d="M{} {}{}" fill="{}")", x, y, path, colour(style));
}

std::string text_at(double x, double y, std::string_view anchor, std::string_view text) {
  return svg(R"(<text x="{}" y="{}" text-anchor="{}">{}</text>)", x, y, anchor, escape_html(text));
}

struct LegendEntry {
  std::string name;
  int style;
  bool marker;
  double x = 0, y = 0;  // left end of the line next to the name
};

// The position of the plot within the picture.
struct Frame {
  double left, right, top, bottom;
  AxisRange x_range, y_range;
  double x(double value) const { return left + (right - left) * x_range.position(value); }
  double y(double value) const { return bottom - (bottom - top) * y_range.position(value); }
};

constexpr double kSampleLength = 26;  // length of the line in a legend entry

// Places entries side by side, in as many lines as they need; returns the number of lines.
int place_legend(std::vector<LegendEntry>& entries, double left, double right) {
  double x = left;
  int line = entries.empty() ? 0 : 1;
  for (LegendEntry& entry : entries) {
    const double width = kSampleLength + 6 + text_width(entry.name) + 16;
    if (x > left && x + width > right) x = left, ++line;
    entry.x = x;
    entry.y = kLine * line;
    x += width;
  }
  return line;
}

double widest_label(const std::vector<AxisTick>& ticks) {
  double widest = 0;
  for (const AxisTick& tick : ticks) widest = std::max(widest, text_width(tick.label));
  return widest;
}

Frame make_frame(int width, int height, const AxisRange& x, const AxisRange& y, int legend_lines) {
  const double last = widest_label(x.ticks());  // half of the last label may extend beyond the plot
  return {kLine + widest_label(y.ticks()) + 14,
          width - std::max(14.0, last / 2 + 2),
          kLine + 12,
          height - 2 * kLine - 10 - legend_lines * kLine,
          x,
          y};
}

// Returns the number of tick labels that fit side by side below the plot.
int tick_count(const Frame& frame) {
  const double widest = widest_label(frame.x_range.ticks());
  return std::clamp(int((frame.right - frame.left) / (widest + 18)), 2, 8);
}

std::string axes(const Frame& f, const ChartAxis& x, const ChartAxis& y) {
  std::string lines = R"(<g stroke="currentColor" stroke-opacity="0.16">)", labels = "<g>";
  for (const AxisTick& tick : f.x_range.ticks(tick_count(f))) {
    const double at = f.x(tick.value);
    lines += svg(R"(<path d="M{} {}V{}"/>)", at, f.top, f.bottom);
    if (!tick.label.empty()) labels += text_at(at, f.bottom + kLine, "middle", tick.label);
  }
  for (const AxisTick& tick : f.y_range.ticks()) {
    const double at = f.y(tick.value);
    lines += svg(R"(<path d="M{} {}H{}"/>)", f.left, at, f.right);
    if (!tick.label.empty()) {
      labels += text_at(f.left - 6, at + 0.35 * kTextSize, "end", tick.label);
    }
  }
  const double middle = (f.top + f.bottom) / 2;
  return lines + "</g>\n" +
         svg(R"(<path d="M{} {}V{}H{}" fill="none" stroke="currentColor" stroke-opacity="0.7"/>)",
             f.left, f.top, f.bottom, f.right) +
         "\n" + labels + "</g>\n" +
         text_at((f.left + f.right) / 2, f.bottom + 2 * kLine + 2, "middle", x.label) + "\n" +
         svg(R"svg(<text x="{0}" y="{1}" text-anchor="middle" transform="rotate(-90 {0} {1})">)svg",
             kTextSize, middle) +
         escape_html(y.label) + "</text>\n";
}

std::string legend(const std::vector<LegendEntry>& entries, double top) {
  std::string text;
  for (const LegendEntry& e : entries) {
    const double y = top + e.y, middle = y - 0.35 * kTextSize;
    text += svg(R"(<path d="M{} {}h{}" stroke="{}" stroke-width="2" stroke-dasharray="{}"/>)", e.x,
                middle, kSampleLength, colour(e.style), dash(e.style));
    if (e.marker) text += marker(e.style, e.x + kSampleLength / 2, middle) + "/>";
    text += text_at(e.x + kSampleLength + 6, y, "start", e.name) + "\n";
  }
  return text;
}

std::string begin(const std::string& title, int width, int height) {
  return svg(R"(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {} {}" role="img" )"
             R"(aria-label="{}" font-family="system-ui, sans-serif" font-size="{}" )"
             R"(fill="currentColor" style="color-scheme:light dark">)"
             "\n",
             width, height, escape_html(title), kTextSize) +
         svg(R"(<text x="{}" y="{}" text-anchor="middle" font-weight="600">{}</text>)"
             "\n",
             width / 2.0, kLine, escape_html(title));
}

std::string no_data(const Frame& f) {
  return text_at((f.left + f.right) / 2, (f.top + f.bottom) / 2, "middle", "no data") + "\n";
}

bool drawable(const LineChart& chart, const ChartPoint& p) {
  return AxisRange::drawable(chart.x.scale, p.x) && AxisRange::drawable(chart.y.scale, p.y);
}

// Writes the line, the intervals and the markers of a series. Points that cannot be drawn divide
// the line into segments.
class SeriesWriter {
 public:
  SeriesWriter(const Frame& frame, const LineChart& chart, size_t index)
      : frame_(frame),
        chart_(chart),
        series_(chart.series[index]),
        style_(style_of(chart, index)) {}

  std::string write() const {
    std::string text;
    std::vector<ChartPoint> run;
    for (const ChartPoint& p : series_.points) {
      if (drawable(chart_, p)) {
        run.push_back(p);
      } else {
        text += write_segment(std::exchange(run, {}));
      }
    }
    return text + write_segment(run);
  }

 private:
  static bool has_interval(const ChartPoint& p) {
    return !std::isnan(p.low) && !std::isnan(p.high);
  }
  double clamp_y(double value) const {
    if (!AxisRange::drawable(chart_.y.scale, value)) {
      return value > 1 ? frame_.top : frame_.bottom;
    }
    return std::clamp(frame_.y(value), frame_.top, frame_.bottom);
  }

  std::string write_segment(const std::vector<ChartPoint>& run) const {
    if (run.empty()) return "";
    return (series_.spread == ChartSpread::kBand ? band(run) : bars(run)) + line(run) +
           markers(run);
  }

  std::string line(const std::vector<ChartPoint>& run) const {
    if (run.size() < 2) return "";
    std::string points;
    for (const ChartPoint& p : run) points += point_text(p.x, frame_.y(p.y));
    points.pop_back();
    return svg(
        R"(<polyline points="{}" fill="none" stroke="{}" stroke-width="2" stroke-dasharray="{}" stroke-linejoin="round"/>)"
        "\n",
        points, colour(style_), dash(style_));
  }

  std::string markers(const std::vector<ChartPoint>& run) const {
    // A point without neighbours always gets a marker, because without one it would be invisible.
    if (!series_.markers && run.size() > 1) return "";
    std::string text;
    for (const ChartPoint& p : run) {
      const std::string tag = marker(style_, frame_.x(p.x), frame_.y(p.y));
      text += svg("{}><title>{}</title></{}>\n", tag, tooltip(p), tag.substr(1, tag.find(' ') - 1));
    }
    return text;
  }

  // Returns the text of a marker's tooltip.
  std::string tooltip(const ChartPoint& p) const {
    std::string text = series_.name + ": " + number_text(p.x) + ", " + number_text(p.y);
    if (has_interval(p)) text += " (" + number_text(p.low) + " to " + number_text(p.high) + ")";
    return escape_html(text);
  }

  std::string bars(const std::vector<ChartPoint>& run) const {
    std::string text;
    for (const ChartPoint& p : run) {
      if (!has_interval(p)) continue;
      text += svg(
          R"(<path d="M{0} {1}V{2}m-4 0h8M{0} {1}m-4 0h8" fill="none" stroke="{3}" stroke-width="1.5"/>)"
          "\n",
          frame_.x(p.x), clamp_y(p.low), clamp_y(p.high), colour(style_));
    }
    return text;
  }

  std::string band(const std::vector<ChartPoint>& run) const {
    std::vector<ChartPoint> known;
    std::ranges::copy_if(run, std::back_inserter(known), has_interval);
    if (known.size() < 2) return bars(known);
    std::string points;
    for (const ChartPoint& p : known) points += point_text(p.x, clamp_y(p.high));
    for (const ChartPoint& p : known | std::views::reverse)
      points += point_text(p.x, clamp_y(p.low));
    points.pop_back();
    return svg(R"(<polygon points="{}" fill="{}" fill-opacity="0.18"/>)"
               "\n",
               points, colour(style_));
  }

  // Formats a point of an SVG list of points, with a blank after it. `x` is a value of the chart;
  // `y` is already a coordinate of the picture.
  std::string point_text(double x, double y) const { return svg("{},{} ", frame_.x(x), y); }

  const Frame& frame_;
  const LineChart& chart_;
  const ChartSeries& series_;
  int style_;
};

}  // namespace

Markup line_chart(const LineChart& chart) {
  std::vector<double> xs, ys;
  std::vector<LegendEntry> entries;
  for (size_t s = 0; s < chart.series.size(); ++s) {
    const ChartSeries& series = chart.series[s];
    for (const ChartPoint& p : series.points) {
      if (!drawable(chart, p)) continue;
      xs.push_back(p.x);
      ys.push_back(p.y);
      // Makes the y axis include the interval. On a logarithmic axis, ignores an end that is almost
      // 0 or very high, because it would compress the points.
      const bool log = chart.y.scale == AxisScale::kLog;
      if (!log || p.low > 0.1 * p.y) ys.push_back(p.low);
      if (!log || p.high < 10 * p.y) ys.push_back(p.high);
    }
    if (!series.name.empty()) {
      entries.push_back({series.name, style_of(chart, s), series.markers});
    }
  }
  const AxisRange x_range(chart.x.scale, xs, chart.x.from_zero);
  const AxisRange y_range(chart.y.scale, ys, chart.y.from_zero);
  const int lines = place_legend(entries, 14, chart.width - 4);
  const Frame frame = make_frame(chart.width, chart.height, x_range, y_range, lines);

  std::string text = begin(chart.title, chart.width, chart.height) + axes(frame, chart.x, chart.y);
  for (size_t s = 0; s < chart.series.size(); ++s) text += SeriesWriter(frame, chart, s).write();
  if (xs.empty()) text += no_data(frame);
  return {text + legend(entries, frame.bottom + 2 * kLine + 6) + "</svg>\n"};
}

Markup histogram_chart(const Histogram& histogram) {
  const AxisScale x_scale = histogram.x.scale, y_scale = histogram.y.scale;
  std::vector<double> xs, ys;
  std::vector<Histogram::Bar> bars;
  for (const Histogram::Bar& bar : histogram.bars) {
    if (!AxisRange::drawable(x_scale, bar.from) || !AxisRange::drawable(x_scale, bar.to) ||
        !AxisRange::drawable(y_scale, bar.count) || bar.count < 0) {
      continue;
    }
    bars.push_back(bar);
    xs.insert(xs.end(), {bar.from, bar.to});
    ys.push_back(bar.count);
  }
  const Frame frame =
      make_frame(histogram.width, histogram.height, AxisRange(x_scale, xs, histogram.x.from_zero),
                 AxisRange(y_scale, ys, true), 0);

  std::string text = begin(histogram.title, histogram.width, histogram.height) +
                     axes(frame, histogram.x, histogram.y);
  for (const Histogram::Bar& bar : bars) {
    const double left = frame.x(std::min(bar.from, bar.to));
    const double right = frame.x(std::max(bar.from, bar.to)), top = frame.y(bar.count);
    // Bars that are wide enough are separated by a gap.
    const double gap = right - left > 4 ? 1 : 0;
    text += svg(R"(<rect x="{}" y="{}" width="{}" height="{}" fill="{}">)", left, top,
                std::max(right - left - gap, 0.5), std::max(frame.bottom - top, 0.0), kColours[0]) +
            fmt::format("<title>{:.6g} to {:.6g}: {:.9g}</title></rect>\n", bar.from, bar.to,
                        bar.count);
  }
  if (bars.empty()) text += no_data(frame);
  return {text + "</svg>\n"};
}

}  // namespace emberline
