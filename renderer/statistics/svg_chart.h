// Charts as SVG text: for pages (inline) and as files of their own. Lines and text take the colour
// of the text around them, so that a chart suits a light page and a dark one. Equal charts give
// equal text, in any locale.
//
// Series are told apart by colour (Okabe & Ito 2008, "Color Universal Design", which colour-blind
// readers can tell apart) and by marker and dash, so that they are still on paper without colour.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "renderer/statistics/chart_axis.h"
#include "renderer/statistics/html_page.h"

namespace emberline {

struct ChartPoint {
  double x = 0, y = 0;
  // The interval that y is known to; NaN: none.
  double low = std::numeric_limits<double>::quiet_NaN();
  double high = std::numeric_limits<double>::quiet_NaN();
};

enum class ChartSpread : uint8_t { kBars, kBand };

// A point that cannot be drawn (AxisRange::drawable) is left out and interrupts the line. The end
// of an interval that cannot be drawn (0 on a logarithmic axis) is where the plot ends.
struct ChartSeries {
  std::string name;  // empty: not in the legend
  std::vector<ChartPoint> points = {};
  int style = -1;  // colour, marker and dash; -1: as the series' place in the chart
  bool markers = true;
  ChartSpread spread = ChartSpread::kBars;
};

struct ChartAxis {
  std::string label;
  AxisScale scale = AxisScale::kLinear;
  bool from_zero = false;  // a linear axis includes 0
};

struct LineChart {
  std::string title;
  ChartAxis x, y;
  std::vector<ChartSeries> series;
  int width = 560, height = 360;  // its proportions, and the size of its text: 13 of these units
};

// Without a single point that can be drawn: axes, and the words "no data".
Markup line_chart(const LineChart& chart);

struct Histogram {
  struct Bar {
    double from = 0, to = 0;  // along x
    double count = 0;
  };
  std::string title;
  ChartAxis x, y;  // y begins at 0, or on a logarithmic axis below the least count
  std::vector<Bar> bars;
  int width = 560, height = 300;
};

Markup histogram_chart(const Histogram& histogram);

}  // namespace emberline
