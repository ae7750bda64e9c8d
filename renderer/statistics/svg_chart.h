// Draws charts as SVG text, for use within pages or as separate files. Lines and text have the
// colour of the surrounding text, so charts look good on light and dark pages. Equal charts result
// in identical SVG text, in any locale.
//
// Series differ in colour (Okabe & Ito 2008, "Color Universal Design", for colour-blind readers).
// They also differ in their markers and dashes, for print without colour.
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
  // Confidence interval of y; both ends are NaN if there is none.
  double low = std::numeric_limits<double>::quiet_NaN();
  double high = std::numeric_limits<double>::quiet_NaN();
};

enum class ChartSpread : uint8_t { kBars, kBand };

// A point that cannot be drawn (AxisRange::drawable) is skipped and interrupts the line. If an end
// of an interval cannot be drawn (such as 0 on a logarithmic axis), it is moved to the plot's edge.
struct ChartSeries {
  std::string name;  // empty: not in the legend
  std::vector<ChartPoint> points = {};
  int style = -1;  // selects colour, marker and dash; -1: the index of the series
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
  int width = 560, height = 360;  // of the view box, in units in which the text size is 13
};

// If no point can be drawn, the chart shows axes and the words "no data".
Markup line_chart(const LineChart& chart);

struct Histogram {
  struct Bar {
    double from = 0, to = 0;  // along x
    double count = 0;
  };
  std::string title;
  ChartAxis x, y;  // y begins at 0, or below the smallest count if logarithmic
  std::vector<Bar> bars;
  int width = 560, height = 300;
};

Markup histogram_chart(const Histogram& histogram);

}  // namespace emberline
