#include "renderer/statistics/study/range.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "renderer/core/readable.h"
#include "renderer/output/rgb_file.h"
#include "renderer/statistics/flicker.h"
#include "renderer/statistics/html_page.h"
#include "renderer/statistics/study/files.h"
#include "renderer/statistics/study_summary.h"
#include "renderer/statistics/svg_chart.h"
#include "renderer/statistics/value_list.h"

namespace emberline {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr StudyMetric kMetric = StudyMetric::kRelMseTrimmed;

double error_of(const FrameStudy& study, size_t method) {
  const std::vector<CurvePoint> curve = study_curve(study.results, method, kMetric);
  const bool is_reached =
      !curve.empty() && curve.back().budget == study.results.settings.budgets.back();
  return is_reached ? curve.back().error.value : kUnknown;
}

double speedup_of(const FrameStudy& study, size_t method) {
  const size_t last = study.results.settings.budgets.size() - 1;
  const std::optional<Speedup> speedup =
      equal_error_speedup(study.results, method, kMetric, StudyAxis::kCpu, last);
  return speedup ? speedup->ratio.value : kUnknown;
}

double flicker_of(const FrameStudy& study, size_t method) {
  return study.flicker.empty() ? kUnknown : study.flicker[method];
}

struct Quantity {
  const char* name;
  double (*of)(const FrameStudy& study, size_t method);
};
constexpr Quantity kQuantities[] = {
    {"relmse_trimmed", error_of}, {"speedup", speedup_of}, {"flicker", flicker_of}};

// The values of a quantity in all frames that have it.
std::optional<ValueSummary> over_frames(std::span<const FrameStudy> studies,
                                        const Quantity& quantity, size_t method) {
  std::vector<double> values;
  for (const FrameStudy& study : studies) values.push_back(quantity.of(study, method));
  return summary_of_finite(std::move(values));
}

const std::vector<StudyMethod>& methods_of(std::span<const FrameStudy> studies) {
  return studies.front().results.methods;
}

std::string number(double value) { return std::isfinite(value) ? readable_number(value, 3) : "-"; }

std::vector<std::vector<std::string>> summary_rows(std::span<const FrameStudy> studies) {
  std::vector<std::vector<std::string>> rows = {
      {"method", "relmse_trimmed", "largest", "speedup", "least", "flicker", "largest"}};
  for (size_t m = 0; m < methods_of(studies).size(); ++m) {
    std::vector<std::string>& row = rows.emplace_back();
    row.push_back(methods_of(studies)[m].name);
    for (const Quantity& quantity : kQuantities) {
      const std::optional<ValueSummary> summary = over_frames(studies, quantity, m);
      const double worst = !summary                     ? kUnknown
                           : quantity.of == &speedup_of ? summary->least
                                                        : summary->largest;
      row.push_back(number(summary ? summary->median : kUnknown));
      row.push_back(number(worst));
    }
  }
  return rows;
}

std::string explanation(std::span<const FrameStudy> studies) {
  const StudySettings& s = studies.front().results.settings;
  return fmt::format(
      "Medians over {} frames at {} {}, with the worst frame beside each; speedup in processor "
      "time at equal relmse_trimmed, against {}",
      studies.size(), s.budgets.back(), s.by_time ? "seconds" : "samples per pixel", s.baseline);
}

LineChart chart_of(std::span<const FrameStudy> studies, const Quantity& quantity,
                   const std::string& title, const std::string& label) {
  LineChart chart;
  chart.title = title;
  chart.x = {"frame"};
  chart.y = {label, AxisScale::kLog};
  for (size_t m = 0; m < methods_of(studies).size(); ++m) {
    ChartSeries series{methods_of(studies)[m].name, {}, int(m)};
    for (const FrameStudy& study : studies) {
      series.points.push_back({double(study.frame), quantity.of(study, m)});
    }
    std::ranges::sort(series.points, {}, &ChartPoint::x);
    chart.series.push_back(std::move(series));
  }
  return chart;
}

// Returns null for a missing value. Json also writes numbers that are not finite as null.
Json summary_json(const std::optional<ValueSummary>& summary) {
  if (!summary) return nullptr;
  return {{"median", summary->median},
          {"mean", summary->mean},
          {"least", summary->least},
          {"largest", summary->largest}};
}

}  // namespace

void measure_flicker(FrameStudy& frame, const FrameStudy& next, const LoadLimits& limits) {
  const auto read = [&](const FrameStudy& study, const std::string& name) {
    const std::string path = (std::filesystem::path(study.folder) / name).string();
    LayerChoice choice;
    choice.reads_motion = true;
    return read_rgb(path, LoadProgress({}, {}, limits), choice);
  };
  const RgbFile reference = read(frame, frame.results.reference.exr);
  const RgbFile next_reference = read(next, next.results.reference.exr);
  frame.flicker.clear();
  for (size_t m = 0; m < frame.results.methods.size(); ++m) {
    const std::string& name = frame.results.methods[m].pictures.exr;
    const std::string& next_name = next.results.methods[m].pictures.exr;
    if (name.empty() || next_name.empty()) {
      frame.flicker.push_back(kUnknown);
      continue;
    }
    const RgbFile picture = read(frame, name), next_picture = read(next, next_name);
    frame.flicker.push_back(
        flicker({picture.pixels, reference.pixels, reference.motion},
                {next_picture.pixels, next_reference.pixels, next_reference.motion},
                frame.results.reference.rel_mse_epsilon)
            .value);
  }
}

std::string study_range_csv(std::span<const FrameStudy> studies) {
  std::string text;
  for (const FrameStudy& study : studies) {
    const std::string csv = study_csv(study.results, study.frame);
    text += text.empty() ? csv : csv.substr(csv.find('\n') + 1);  // one header
  }
  return text;
}

std::string study_range_json(std::span<const FrameStudy> studies) {
  Json json = {{"frames", Json::array()}, {"summary", Json::array()}};
  const std::vector<StudyMethod>& methods = methods_of(studies);
  for (const FrameStudy& study : studies) {
    Json& frame = json["frames"].emplace_back(
        Json{{"frame", study.frame},
             {"folder", std::filesystem::path(study.folder).filename().string()},
             {"methods", Json::array()}});
    for (size_t m = 0; m < methods.size(); ++m) {
      Json& method = frame["methods"].emplace_back(Json{{"method", methods[m].name}});
      for (const Quantity& quantity : kQuantities) method[quantity.name] = quantity.of(study, m);
    }
  }
  for (size_t m = 0; m < methods.size(); ++m) {
    Json& method = json["summary"].emplace_back(Json{{"method", methods[m].name}});
    for (const Quantity& quantity : kQuantities) {
      method[quantity.name] = summary_json(over_frames(studies, quantity, m));
    }
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string study_range_table(std::span<const FrameStudy> studies) {
  return explanation(studies) + "\n\n" + aligned_table(summary_rows(studies));
}

std::string study_range_page(std::span<const FrameStudy> studies, const std::string& command_line) {
  const StudySettings& settings = studies.front().results.settings;
  HtmlPage page("Speed against error: " + std::filesystem::path(settings.scene).filename().string(),
                explanation(studies));
  const std::vector<std::vector<std::string>> rows = summary_rows(studies);
  PageTable table{"", {}, {}};
  for (const std::string& name : rows.front()) table.columns.push_back({name, name != "method"});
  for (size_t i = 1; i < rows.size(); ++i) {
    table.rows.emplace_back(rows[i].begin(), rows[i].end());
  }
  page.table(table);
  page.figures(std::vector<PageFigure>{
      {line_chart(chart_of(studies, kQuantities[0], "Error of each frame", "relmse_trimmed")), ""},
      {line_chart(chart_of(studies, kQuantities[2], "Flicker until the next frame", "flicker")),
       "How much the relative error of a picture changes until the next frame, at points that move "
       "with the scene. Independent errors give about the sum of both relmse_trimmed; errors that "
       "move with things give about 0."}});
  page.section("Frames");
  std::vector<std::string> pages;
  for (const FrameStudy& study : studies) {
    pages.push_back(std::filesystem::path(study.folder).filename().string() + "/study.html");
  }
  page.list(pages);
  page.section("To run this study again");
  page.code(command_line);
  return page.finish();
}

}  // namespace emberline
