#include "renderer/app/range_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "renderer/app/commands.h"
#include "renderer/app/frame_animation.h"
#include "renderer/app/frame_range.h"
#include "renderer/core/file_suffix.h"
#include "renderer/core/log.h"
#include "renderer/core/readable.h"
#include "renderer/core/shortened.h"
#include "renderer/engine/process_usage.h"
#include "renderer/engine/render_plan.h"
#include "renderer/output/option_rules.h"
#include "renderer/output/outputs.h"
#include "renderer/statistics/html_page.h"
#include "renderer/statistics/svg_chart.h"

namespace emberline {
namespace {

using Json = nlohmann::ordered_json;

struct OutcomeEntry {
  const char* name;
  const char* text;  // to print after the number of frames
  FrameStatus status;
};
constexpr OutcomeEntry kOutcomes[] = {{"done", "rendered", FrameStatus::kDone},
                                      {"skipped", "skipped", FrameStatus::kSkipped},
                                      {"stopped", "stopped", FrameStatus::kStopped},
                                      {"failed", "failed", FrameStatus::kFailed}};

Json outcome_json(const FrameOutcome& o) {
  Json json = {{"frame", o.frame},
               {"state", kOutcomes[size_t(o.status)].name},
               {"exit_code", o.exit_code},
               {"output", o.outputs}};
  if (o.status == FrameStatus::kSkipped) return json;
  if (!o.error.empty()) {
    json["error"] = o.error;
    return json;
  }
  json["time"] = {{"load_s", o.times.load_s},     {"build_s", o.times.build_s},
                  {"render_s", o.times.render_s}, {"write_s", o.times.write_s},
                  {"wall_s", o.times.wall_s},     {"cpu_s", o.times.cpu_s}};
  json["samples"] = o.samples;
  json["rays"] = o.rays;
  json["failed_outputs"] = o.failed_outputs;
  return json;
}

// Calls visit(is_version, name, text) for each setting and version that files record.
template <typename Visit>
void visit_recorded(const RenderOptions& options, const Visit& visit) {
  for (const auto& [name, text] : settings_attributes(options)) {
    constexpr std::string_view kPrefix = "emberline:", kVersion = "emberline:version:";
    const bool is_version = name.starts_with(kVersion);
    visit(is_version, name.substr((is_version ? kVersion : kPrefix).size()), text);
  }
}

double samples_per_pixel(const RenderOptions& options, const FrameOutcome& outcome) {
  return double(outcome.samples) / double(crop_of(options).area());
}

bool is_rendered(const FrameOutcome& outcome) {
  return outcome.status == FrameStatus::kDone || outcome.status == FrameStatus::kStopped;
}

// Every step-th frame is shown in the animation, so that the page stays small.
struct AnimatedRange {
  std::vector<int> frames;  // in ascending order
  int step = 1;
};

AnimatedRange animated_range(const RangeReport& report, const std::string& image) {
  constexpr size_t kMaxAnimated = 120;
  std::vector<int> frames;
  for (const FrameOutcome& outcome : report.frames) {
    std::error_code unknown;
    const std::string path = expand_frame_number(image, outcome.frame);
    if (std::filesystem::exists(path, unknown)) frames.push_back(outcome.frame);
  }
  std::ranges::sort(frames);
  AnimatedRange range;
  range.step = int((frames.size() + kMaxAnimated - 1) / kMaxAnimated);
  for (size_t i = 0; i < frames.size(); i += size_t(range.step)) range.frames.push_back(frames[i]);
  return range;
}

void add_animation(HtmlPage& page, const RenderOptions& options, const RangeReport& report) {
  constexpr int kMaxSide = 480;  // pixels
  if (is_part(options) || options.outputs.empty()) return;
  const auto exr = std::ranges::find_if(options.outputs, is_exr);
  if (exr == options.outputs.end()) {
    return page.paragraph("With an .exr output, the frames would be shown here as an animation.");
  }
  if (report.exit_code == kExitStopped) {
    return page.paragraph("The range was stopped, so there is no animation yet.");
  }
  const AnimatedRange range = animated_range(report, *exr);
  if (range.frames.size() < 2) return;
  const double fps =
      std::clamp(options.fps / range.step, double(kMinAnimationFps), double(kMaxAnimationFps));
  ShowOptions show;
  show.image = *exr;
  show.frames = range.frames;
  show.fps = fps;
  show.display = options.display;
  show.limits = options.limits;
  try {
    const AnimatedFrames animated = animate_frames(show, kMaxSide, crop_of(options));
    if (animated.gif.empty()) return page.warning("No frame could be read for the animation.");
    const double shown_fps = 100.0 / std::round(100.0 / fps);  // as a GIF stores it
    page.figures(std::vector<PageFigure>{
        {picture_markup(animated.gif, "image/gif", animated.width, animated.height,
                        "the frames as an animation"),
         fmt::format("Frames {} at {} frames per second{}.",
                     shortened(format_frames(animated.frames)), readable_number(shown_fps),
                     options.denoise ? ", denoised" : "")}});
    if (animated.frames.size() < range.frames.size()) {
      const size_t missing = range.frames.size() - animated.frames.size();
      page.warning(fmt::format("{} frame{} could not be shown in the animation.", missing,
                               missing == 1 ? "" : "s"));
    }
  } catch (const std::exception& error) {
    log_warning(fmt::format("{}: without an animation: {}", options.range_report, error.what()));
    page.warning(fmt::format("The animation could not be made: {}", error.what()));
  }
}

void add_charts(HtmlPage& page, const RenderOptions& options, const RangeReport& report) {
  LineChart time, samples;
  time.title = "Time of each frame";
  time.y = {"seconds", AxisScale::kLinear, true};
  samples.title = "Samples per pixel of each frame";
  samples.y = {"samples per pixel", AxisScale::kLinear, true};
  time.x = samples.x = {"frame"};
  ChartSeries total{"total"}, rendering{"rendering"}, count{""};
  for (const FrameOutcome& outcome : report.frames) {
    if (!is_rendered(outcome)) continue;
    const double x = outcome.frame;
    total.points.push_back({x, outcome.times.wall_s});
    rendering.points.push_back({x, outcome.times.render_s});
    count.points.push_back({x, samples_per_pixel(options, outcome)});
  }
  constexpr size_t kMaxMarkers = 60;
  for (ChartSeries* series : {&total, &rendering, &count}) {
    std::ranges::sort(series->points, {}, &ChartPoint::x);
    series->markers = series->points.size() <= kMaxMarkers;
  }
  if (total.points.size() < 2) return;
  time.series = {total, rendering};
  samples.series = {count};
  page.figures(std::vector<PageFigure>{{line_chart(time), ""}, {line_chart(samples), ""}});
}

void add_frames(HtmlPage& page, const RenderOptions& options, const RangeReport& report) {
  constexpr size_t kMaxRows = 1000;
  page.section("Frames");
  PageTable table{"",
                  {{"frame", true},
                   {"state"},
                   {"total", true},
                   {"rendering", true},
                   {"samples per pixel", true},
                   {"rays", true},
                   {""}},
                  {}};
  for (const FrameOutcome& outcome : report.frames) {
    if (table.rows.size() == kMaxRows) {
      page.paragraph(fmt::format("The first {} of {} frames:", readable_count(kMaxRows),
                                 readable_count(report.frames.size())));
      break;
    }
    std::string note = outcome.error;
    for (const std::string& path : outcome.failed_outputs) {
      note += fmt::format("{}cannot write {}", note.empty() ? "" : "; ", path);
    }
    const bool is_bad = outcome.exit_code != 0;
    std::vector<PageCell> row = {std::to_string(outcome.frame),
                                 {kOutcomes[size_t(outcome.status)].text,
                                  is_bad ? PageCell::Tone::kBad : PageCell::Tone::kPlain}};
    const bool rendered = is_rendered(outcome);
    row.push_back(rendered ? readable_seconds(outcome.times.wall_s) : "");
    row.push_back(rendered ? readable_seconds(outcome.times.render_s) : "");
    row.push_back(rendered ? readable_number(samples_per_pixel(options, outcome), 4) : "");
    row.push_back(rendered ? readable_count(outcome.rays) : "");
    row.push_back(note);
    table.rows.push_back(std::move(row));
  }
  page.table(table);
}

void add_settings(HtmlPage& page, const RenderOptions& options) {
  PageTable settings{"", {{"setting"}, {"value"}}, {}};
  visit_recorded(options, [&](bool is_version, const std::string& name, const std::string& text) {
    if (!is_version) settings.rows.push_back({name, text});
  });
  page.section("Settings");
  page.code(options.command_line);
  page.table(settings);
}

}  // namespace

std::vector<int> RangeReport::frames_with_status(FrameStatus status) const {
  std::vector<int> list;
  for (const FrameOutcome& outcome : frames) {
    if (outcome.status == status) list.push_back(outcome.frame);
  }
  return list;
}

std::string describe(const RangeReport& report) {
  std::string text;
  for (const OutcomeEntry& entry : kOutcomes) {
    const std::vector<int> list = report.frames_with_status(entry.status);
    if (list.empty()) continue;
    text += fmt::format("{}{} {}", text.empty() ? "frames: " : ", ", list.size(), entry.text);
    const bool lists_frames =
        entry.status == FrameStatus::kStopped || entry.status == FrameStatus::kFailed;
    if (lists_frames) text += fmt::format(" ({})", shortened(format_frames(list)));
  }
  if (report.remaining.empty()) return text;
  return text + fmt::format("{}{} left: {}", text.empty() ? "frames: " : ", ",
                            report.remaining.size(), shortened(format_frames(report.remaining)));
}

std::string range_report_json(const RenderOptions& options, const RangeReport& report) {
  Json json;
  for (const OutcomeEntry& entry : kOutcomes)
    json[entry.name] = format_frames(report.frames_with_status(entry.status));
  json["left"] = format_frames(report.remaining);
  json["exit_code"] = report.exit_code;
  json["time"] = {{"wall_s", report.wall_s}, {"cpu_s", report.cpu_s}};
  Json& frames = json["frames"] = Json::array();
  for (const FrameOutcome& outcome : report.frames) frames.push_back(outcome_json(outcome));
  visit_recorded(options, [&](bool is_version, const std::string& name, const std::string& text) {
    json[is_version ? "versions" : "settings"][name] = text;
  });
  json["machine"] = {{"host", host_name()}, {"instruction_sets", instruction_sets()}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string range_report_page(const RenderOptions& options, const RangeReport& report) {
  const Rect crop = crop_of(options);
  HtmlPage page(
      std::filesystem::path(options.scene).filename().string(),
      fmt::format("{} x {} pixels; {}; {} in all. {}", crop.width(), crop.height(),
                  describe(report), readable_seconds(report.wall_s), readable_local_time()));
  add_animation(page, options, report);
  add_charts(page, options, report);
  add_frames(page, options, report);
  add_settings(page, options);
  return page.finish();
}

}  // namespace emberline
