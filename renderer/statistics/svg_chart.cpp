#include "renderer/statistics/svg_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string_view>

namespace emberline {
namespace {

constexpr double kTextSize = 13;
constexpr double kLetter = 0.56 * kTextSize;  // mean advance of a sans-serif letter, about
constexpr double kLine = 1.45 * kTextSize;

// Okabe & Ito's, but for black, which would vanish on a dark page: there the text's own colour.
// Yellow comes last, as it is faint on white.
constexpr const char* kColours[] = {"#0072b2", "#d55e00", "#009e73",      "#cc79a7",
                                    "#e69f00", "#56b4e9", "currentColor", "#f0e442"};
constexpr const char* kDashes[] = {"", "7 3", "2 3", "9 3 2 3", "12 4"};
constexpr int kMarkers = 7;  // cases of marker()

int style_of(const LineChart& chart, size_t series) {
  const int style = chart.series[series].style;
  return style >= 0 ? style : int(series);
}
const char* colour(int style) { return kColours[size_t(style) % std::size(kColours)]; }
const char* dash(int style) { return kDashes[size_t(style) % std::size(kDashes)]; }

// A coordinate with two decimals, the shortest way: one picture's text then has one form.
std::string number(double value) {
  std::string text = fmt::format("{:.2f}", value);
  while (text.back() == '0') text.pop_back();
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

double text_width(std::string_view text) {
  const auto letters = std::ranges::count_if(
      text, [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; });
  return kLetter * double(letters);
}

std::string marker(int style, double x, double y) {
  const auto path = [&](std::string_view d) {
    return fmt::format(R"(<path d="M{} {}{}")", number(x), number(y), d);
  };
  switch (style % kMarkers) {
    case 0:
      return fmt::format(R"(<circle cx="{}" cy="{}" r="3.5")", number(x), number(y));
    case 1:
      return path("m-3.2 -3.2h6.4v6.4h-6.4z");
    case 2:
      return path("m0 -4.2l4.2 7.2h-8.4z");
    case 3:
      return path("m0 -4.6l4.6 4.6l-4.6 4.6l-4.6 -4.6z");
    case 4:
      return path("m0 4.2l4.2 -7.2h-8.4z");
    case 5:
      return path("m-1.4 -4.2h2.8v2.8h2.8v2.8h-2.8v2.8h-2.8v-2.8h-2.8v-2.8h2.8z");
    default:
      return path("m-4.2 -1.6h8.4v3.2h-8.4z");
  }
}

std::string text_at(double x, double y, std::string_view anchor, std::string_view text) {
  return fmt::format(R"(<text x="{}" y="{}" text-anchor="{}">{}</text>)", number(x), number(y),
                     anchor, escape_html(text));
}

struct LegendEntry {
  std::string name;
  int style;
  bool marker;
  double x = 0, y = 0;  // of its sample's left end
};

// The plot's place within the picture.
struct Frame {
  double left, right, top, bottom;
  AxisRange x_range, y_range;
  double x(double value) const { return left + (right - left) * x_range.place(value); }
  double y(double value) const { return bottom - (bottom - top) * y_range.place(value); }
};

constexpr double kSample = 26;  // a legend entry's piece of line

// Entries one behind the other, wrapped; returns the number of lines.
int place_legend(std::vector<LegendEntry>& entries, double left, double right) {
  double x = left;
  int line = entries.empty() ? 0 : 1;
  for (LegendEntry& entry : entries) {
    const double width = kSample + 6 + text_width(entry.name) + 16;
    if (x > left && x + width > right) x = left, ++line;
    entry.x = x;
    entry.y = kLine * line;
    x += width;
  }
  return line;
}

Frame make_frame(int width, int height, const AxisRange& x, const AxisRange& y, int legend_lines) {
  double labels = 0;
  for (const AxisTick& tick : y.ticks()) labels = std::max(labels, text_width(tick.label));
  double last = 0;  // may stand half outside the plot
  for (const AxisTick& tick : x.ticks()) last = std::max(last, text_width(tick.label));
  return {kLine + labels + 14,
          width - std::max(14.0, last / 2 + 2),
          kLine + 12,
          height - 2 * kLine - 10 - legend_lines * kLine,
          x,
          y};
}

// As many labels as fit side by side.
int tick_count(const Frame& frame) {
  double widest = 0;
  for (const AxisTick& tick : frame.x_range.ticks()) {
    widest = std::max(widest, text_width(tick.label));
  }
  return std::clamp(int((frame.right - frame.left) / (widest + 18)), 2, 8);
}

std::string axes(const Frame& f, const ChartAxis& x, const ChartAxis& y) {
  std::string svg = R"(<g stroke="currentColor" stroke-opacity="0.16">)";
  const std::vector<AxisTick> x_ticks = f.x_range.ticks(tick_count(f)), y_ticks = f.y_range.ticks();
  for (const AxisTick& tick : x_ticks) {
    svg += fmt::format(R"(<path d="M{} {}V{}"/>)", number(f.x(tick.value)), number(f.top),
                       number(f.bottom));
  }
  for (const AxisTick& tick : y_ticks) {
    svg += fmt::format(R"(<path d="M{} {}H{}"/>)", number(f.left), number(f.y(tick.value)),
                       number(f.right));
  }
  svg += "</g>\n";
  svg += fmt::format(
      R"(<path d="M{} {}V{}H{}" fill="none" stroke="currentColor" stroke-opacity="0.7"/>)",
      number(f.left), number(f.top), number(f.bottom), number(f.right));
  svg += "\n<g>";
  for (const AxisTick& tick : x_ticks) {
    if (tick.label.empty()) continue;
    svg += text_at(f.x(tick.value), f.bottom + kLine, "middle", tick.label);
  }
  for (const AxisTick& tick : y_ticks) {
    if (tick.label.empty()) continue;
    svg += text_at(f.left - 6, f.y(tick.value) + 0.35 * kTextSize, "end", tick.label);
  }
  svg += "</g>\n";
  svg += text_at((f.left + f.right) / 2, f.bottom + 2 * kLine + 2, "middle", x.label) + "\n";
  const double middle = (f.top + f.bottom) / 2;
  svg += fmt::format(
      R"svg(<text x="{}" y="{}" text-anchor="middle" transform="rotate(-90 {} {})">{}</text>)svg",
      number(kTextSize), number(middle), number(kTextSize), number(middle), escape_html(y.label));
  return svg + "\n";
}

std::string legend(const std::vector<LegendEntry>& entries, double top) {
  std::string svg;
  for (const LegendEntry& e : entries) {
    const double y = top + e.y;
    const double middle = y - 0.35 * kTextSize;
    svg +=
        fmt::format(R"(<path d="M{} {}h{}" stroke="{}" stroke-width="2" stroke-dasharray="{}"/>)",
                    number(e.x), number(middle), kSample, colour(e.style), dash(e.style));
    if (e.marker) {
      svg += marker(e.style, e.x + kSample / 2, middle) +
             fmt::format(R"( fill="{}"/>)", colour(e.style));
    }
    svg += text_at(e.x + kSample + 6, y, "start", e.name) + "\n";
  }
  return svg;
}

std::string begin(const std::string& title, int width, int height) {
  return fmt::format(R"(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {} {}" role="img" )"
                     R"(aria-label="{}" font-family="system-ui, sans-serif" font-size="{}" )"
                     R"(fill="currentColor" style="color-scheme:light dark">)",
                     width, height, escape_html(title), number(kTextSize)) +
         "\n" +
         fmt::format(R"(<text x="{}" y="{}" text-anchor="middle" font-weight="600">{}</text>)",
                     number(width / 2.0), number(kLine), escape_html(title)) +
         "\n";
}

std::string no_data(const Frame& f) {
  return text_at((f.left + f.right) / 2, (f.top + f.bottom) / 2, "middle", "no data") + "\n";
}

// Writes the parts of a line, or of its band, that hang together.
class SeriesWriter {
 public:
  SeriesWriter(const Frame& frame, const LineChart& chart, size_t index)
      : frame_(frame),
        chart_(chart),
        series_(chart.series[index]),
        style_(style_of(chart, index)) {}

  std::string write() const {
    std::string svg;
    std::vector<ChartPoint> run;
    const auto finish_run = [&] {
      svg += connected(run);
      run.clear();
    };
    for (const ChartPoint& p : series_.points) {
      if (drawable(p)) {
        run.push_back(p);
      } else {
        finish_run();
      }
    }
    finish_run();
    return svg;
  }

  bool drawable(const ChartPoint& p) const {
    return AxisRange::drawable(chart_.x.scale, p.x) && AxisRange::drawable(chart_.y.scale, p.y);
  }

 private:
  static bool has_interval(const ChartPoint& p) {
    return !std::isnan(p.low) && !std::isnan(p.high);
  }
  double y_within(double value) const {
    if (!AxisRange::drawable(chart_.y.scale, value)) {
      return value > 1 ? frame_.top : frame_.bottom;
    }
    return std::clamp(frame_.y(value), frame_.top, frame_.bottom);
  }

  std::string connected(const std::vector<ChartPoint>& run) const {
    if (run.empty()) return "";
    return (series_.spread == ChartSpread::kBand ? band(run) : bars(run)) + line(run) +
           markers(run);
  }

  std::string line(const std::vector<ChartPoint>& run) const {
    if (run.size() < 2) return "";
    std::string points;
    for (const ChartPoint& p : run) {
      if (!points.empty()) points += ' ';
      points += number(frame_.x(p.x)) + "," + number(frame_.y(p.y));
    }
    return fmt::format(
               R"(<polyline points="{}" fill="none" stroke="{}" stroke-width="2" stroke-dasharray="{}" stroke-linejoin="round"/>)",
               points, colour(style_), dash(style_)) +
           "\n";
  }

  std::string markers(const std::vector<ChartPoint>& run) const {
    // A point without neighbours would else not be seen at all.
    if (!series_.markers && run.size() > 1) return "";
    std::string svg;
    for (const ChartPoint& p : run) {
      svg += marker(style_, frame_.x(p.x), frame_.y(p.y)) +
             fmt::format(R"( fill="{}"><title>{}</title></)", colour(style_), described(p)) +
             (style_ % kMarkers == 0 ? "circle>" : "path>") + "\n";
    }
    return svg;
  }

  // What a pointer over the marker reads.
  std::string described(const ChartPoint& p) const {
    std::string text = fmt::format("{}: {:.4g}, {:.4g}", series_.name, p.x, p.y);
    if (has_interval(p)) text += fmt::format(" ({:.4g} to {:.4g})", p.low, p.high);
    return escape_html(text);
  }

  std::string bars(const std::vector<ChartPoint>& run) const {
    std::string svg;
    for (const ChartPoint& p : run) {
      if (!has_interval(p)) continue;
      const std::string x = number(frame_.x(p.x)), low = number(y_within(p.low)),
                        high = number(y_within(p.high));
      svg +=
          fmt::format(
              R"(<path d="M{0} {1}V{2}m-4 0h8M{0} {1}m-4 0h8" fill="none" stroke="{3}" stroke-width="1.5"/>)",
              x, low, high, colour(style_)) +
          "\n";
    }
    return svg;
  }

  std::string band(const std::vector<ChartPoint>& run) const {
    std::vector<ChartPoint> known;
    std::ranges::copy_if(run, std::back_inserter(known), has_interval);
    if (known.size() < 2) return bars(known);
    std::string points;
    for (const ChartPoint& p : known) {
      points += number(frame_.x(p.x)) + "," + number(y_within(p.high)) + " ";
    }
    for (auto p = known.rbegin(); p != known.rend(); ++p) {
      points += number(frame_.x(p->x)) + "," + number(y_within(p->low)) + " ";
    }
    points.pop_back();
    return fmt::format(R"(<polygon points="{}" fill="{}" fill-opacity="0.18"/>)", points,
                       colour(style_)) +
           "\n";
  }

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
      if (!AxisRange::drawable(chart.x.scale, p.x) || !AxisRange::drawable(chart.y.scale, p.y)) {
        continue;
      }
      xs.push_back(p.x);
      ys.push_back(p.y);
      // An interval down to almost nothing must not squeeze the points of a logarithmic plot.
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

  std::string svg = begin(chart.title, chart.width, chart.height) + axes(frame, chart.x, chart.y);
  for (size_t s = 0; s < chart.series.size(); ++s) {
    svg += SeriesWriter(frame, chart, s).write();
  }
  if (xs.empty()) svg += no_data(frame);
  svg += legend(entries, frame.bottom + 2 * kLine + 6);
  return {svg + "</svg>\n"};
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

  std::string svg = begin(histogram.title, histogram.width, histogram.height) +
                    axes(frame, histogram.x, histogram.y);
  for (const Histogram::Bar& bar : bars) {
    const double left = frame.x(std::min(bar.from, bar.to));
    const double right = frame.x(std::max(bar.from, bar.to)), top = frame.y(bar.count);
    // A gap between bars, where they are wide enough for one.
    const double gap = right - left > 4 ? 1 : 0;
    svg +=
        fmt::format(
            R"(<rect x="{}" y="{}" width="{}" height="{}" fill="{}"><title>{:.6g} to {:.6g}: {:.9g}</title></rect>)",
            number(left), number(top), number(std::max(right - left - gap, 0.5)),
            number(std::max(frame.bottom - top, 0.0)), kColours[0], bar.from, bar.to, bar.count) +
        "\n";
  }
  if (bars.empty()) svg += no_data(frame);
  return {svg + "</svg>\n"};
}

}  // namespace emberline
