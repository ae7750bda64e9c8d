// Tests charts: positions match the values, and invalid values do no harm.
#include "renderer/statistics/svg_chart.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <clocale>
#include <cmath>
#include <set>
#include <sstream>

#include "support/markup.h"

namespace emberline::test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

LineChart chart_of(std::vector<ChartPoint> points, AxisScale scale = AxisScale::kLinear) {
  return {"title", {"x", scale}, {"y", scale}, {{"series", std::move(points)}}};
}

ParsedMarkup well_formed(const Markup& svg) {
  ParsedMarkup read = read_markup(svg.html);
  EXPECT_EQ(read.fault, "") << svg.html;
  for (const Element& element : read.elements) {
    for (const auto& [name, value] : element.attributes) {
      if (name == "aria-label") continue;
      EXPECT_EQ(value.find("nan"), std::string::npos) << svg.html;
      EXPECT_EQ(value.find("inf"), std::string::npos) << svg.html;
    }
  }
  return read;
}

using Place = std::pair<double, double>;
std::vector<Place> polyline(const ParsedMarkup& read, size_t index = 0) {
  std::vector<Place> places;
  for (const Element& element : read.elements) {
    if (element.name != "polyline" || index-- > 0) continue;
    std::istringstream words(element.attributes.at("points"));
    double x, y;
    char comma;
    while (words >> x >> comma >> y) places.emplace_back(x, y);
    break;
  }
  return places;
}

// On linear axes, equal steps are equal distances, and larger values are higher.
TEST(LineChart, LinearPlaces) {
  const auto line = polyline(well_formed(line_chart(chart_of({{0, 0}, {1, 5}, {2, 10}}))));
  ASSERT_EQ(line.size(), 3u);
  EXPECT_NEAR(line[1].first - line[0].first, line[2].first - line[1].first, 0.02);
  EXPECT_NEAR(line[1].second - line[0].second, line[2].second - line[1].second, 0.02);
  EXPECT_GT(line[1].first, line[0].first);
  EXPECT_LT(line[1].second, line[0].second);
}

// On logarithmic axes, equal factors are equal distances, so 1/N is a straight line.
TEST(LineChart, LogarithmicPlaces) {
  std::vector<ChartPoint> points;
  for (int i = 0; i < 5; ++i) points.push_back({std::pow(4.0, i), 3 / std::pow(4.0, i)});
  const auto line = polyline(well_formed(line_chart(chart_of(points, AxisScale::kLog))));
  ASSERT_EQ(line.size(), 5u);
  for (size_t i = 2; i < 5; ++i) {
    EXPECT_NEAR(line[i].first - line[i - 1].first, line[1].first - line[0].first, 0.02);
    EXPECT_NEAR(line[i].second - line[i - 1].second, line[1].second - line[0].second, 0.02);
  }
}

TEST(LineChart, InvalidPointsInterruptTheLine) {
  const auto read = well_formed(line_chart(
      chart_of({{1, 1}, {2, 2}, {3, kNan}, {4, 4}, {5, 5}, {kInfinity, 1}, {1e300, 1}})));
  EXPECT_EQ(read.count("polyline"), 2u);
  EXPECT_EQ(read.count("title"), 4u);  // one per marker
  const auto zero =
      well_formed(line_chart(chart_of({{1, 1}, {2, 0}, {0, 3}, {4, 4}}, AxisScale::kLog)));
  EXPECT_EQ(zero.count("polyline"), 0u);
  EXPECT_EQ(zero.count("title"), 2u);
}

TEST(LineChart, EmptyAndSinglePoints) {
  for (const AxisScale scale : {AxisScale::kLinear, AxisScale::kLog}) {
    for (const std::vector<ChartPoint>& points :
         {std::vector<ChartPoint>{}, {{kNan, 1}}, {{0, 0}}, {{3, 7}}, {{3, 7}, {3, 7}}}) {
      well_formed(line_chart(chart_of(points, scale)));
    }
  }
  EXPECT_NE(well_formed(line_chart(chart_of({}))).text.find("no data"), std::string::npos);
  EXPECT_EQ(well_formed(line_chart(chart_of({{3, 7}}))).text.find("no data"), std::string::npos);
  LineChart none;
  EXPECT_NE(well_formed(line_chart(none)).text.find("no data"), std::string::npos);
  // An isolated point is visible even without markers.
  LineChart lonely = chart_of({{3, 7}});
  lonely.series[0].markers = false;
  lonely.series[0].name.clear();
  EXPECT_EQ(well_formed(line_chart(lonely)).count("circle"), 1u);
}

// Intervals that reach 0 on a logarithmic axis end at the plot's edge and do not compress it.
TEST(LineChart, IntervalsStayInThePlot) {
  for (const ChartSpread spread : {ChartSpread::kBars, ChartSpread::kBand}) {
    LineChart chart =
        chart_of({{1, 10, 0, 12}, {2, 8, 1e-9, kInfinity}, {4, 6, 5, 7}, {8, 5}}, AxisScale::kLog);
    chart.series[0].spread = spread;
    const auto read = well_formed(line_chart(chart));
    const auto line = polyline(read);
    ASSERT_EQ(line.size(), 4u);
    // The range from 10 to 5 takes up a good part of the height.
    EXPECT_GT(line[3].second - line[0].second, 0.3 * chart.height);
    EXPECT_EQ(read.count("polygon"), spread == ChartSpread::kBand ? 1u : 0u);
  }
}

// A letter is about 7 units wide. No label along the axis may leave the picture.
TEST(LineChart, LabelsStayInThePicture) {
  for (const double most : {4500.0, 9e5, 1e-3, 7e8}) {
    const LineChart chart = chart_of({{most / 100, 1}, {most, 2e5}});
    const std::string svg = line_chart(chart).html;
    const AxisRange range(AxisScale::kLinear, std::vector{most / 100, most});
    const std::string label = range.ticks().back().label;
    const size_t at = svg.find(">" + label + "</text>");
    ASSERT_NE(at, std::string::npos) << label << svg;
    const double x = std::stod(svg.substr(svg.rfind("x=\"", at) + 3));
    const auto letters = std::ranges::count_if(label, [](char c) { return (c & 0xc0) != 0x80; });
    EXPECT_LE(x + 7.0 * double(letters) / 2, chart.width) << label;
  }
}

TEST(LineChart, SeriesAreDistinguishable) {
  LineChart chart = chart_of({});
  chart.series.clear();
  for (int s = 0; s < 40; ++s) {
    chart.series.push_back({std::to_string(s), {{0, double(s)}, {1, double(s + 1)}}});
  }
  const auto read = well_formed(line_chart(chart));
  std::set<std::string> looks, first_colours;
  for (const Element& e : read.elements) {
    if (e.name != "polyline") continue;
    looks.insert(e.attributes.at("stroke") + " " + e.attributes.at("stroke-dasharray"));
    if (first_colours.size() < 7) first_colours.insert(e.attributes.at("stroke"));
  }
  EXPECT_EQ(looks.size(), 40u);
  EXPECT_EQ(first_colours.size(), 7u);
}

TEST(LineChart, NamesAreText) {
  LineChart chart = chart_of({{1, 2}});
  chart.title = chart.x.label = chart.y.label = chart.series[0].name = "a<b>&\"c\"";
  const auto read = well_formed(line_chart(chart));
  EXPECT_EQ(read.count("b"), 0u);
  EXPECT_NE(read.text.find("a<b>&\"c\""), std::string::npos);
}

TEST(LineChart, EqualChartsGiveEqualTextInAnyLocale) {
  const LineChart chart = chart_of({{0.125, 1234.5}, {0.5, 2345.25}});
  const std::string before = line_chart(chart).html;
  const char* locale = std::setlocale(LC_ALL, "de_DE.UTF-8");
  EXPECT_EQ(line_chart(chart).html, before) << (locale ? locale : "locale not installed");
  std::setlocale(LC_ALL, "C");
}

TEST(HistogramChart, HeightsAreCounts) {
  const Histogram histogram{
      "t", {"samples"}, {"pixels"}, {{0, 1, 10}, {1, 2, 20}, {2, 3, 0}, {3, 4, 5}}};
  const auto read = well_formed(histogram_chart(histogram));
  std::vector<double> heights;
  for (const Element& e : read.elements) {
    if (e.name == "rect") heights.push_back(std::stod(e.attributes.at("height")));
  }
  ASSERT_EQ(heights.size(), 4u);
  EXPECT_NEAR(heights[1], 2 * heights[0], 0.05);
  EXPECT_NEAR(heights[3], 0.5 * heights[0], 0.05);
  EXPECT_EQ(heights[2], 0);
}

TEST(HistogramChart, LogarithmicHeightsEmptyAndBrokenBars) {
  Histogram histogram{"t",
                      {"x", AxisScale::kLog},
                      {"y", AxisScale::kLog},
                      {{1, 2, 1}, {2, 4, 1000}, {4, 8, 0}, {0, 1, 5}, {8, kNan, 5}, {8, 16, -1}}};
  const auto read = well_formed(histogram_chart(histogram));
  std::vector<double> heights;
  for (const Element& e : read.elements) {
    if (e.name == "rect") heights.push_back(std::stod(e.attributes.at("height")));
  }
  ASSERT_EQ(heights.size(), 2u);
  EXPECT_GT(heights[0], 3);  // a count of 1 is visible
  EXPECT_GT(heights[1], 3 * heights[0]);
  histogram.bars.clear();
  EXPECT_NE(well_formed(histogram_chart(histogram)).text.find("no data"), std::string::npos);
}

}  // namespace
}  // namespace emberline::test
