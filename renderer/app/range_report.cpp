#include "renderer/app/range_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "renderer/app/frame_range.h"
#include "renderer/core/shortened.h"
#include "renderer/engine/process_usage.h"

namespace emberline {
namespace {

using Json = nlohmann::ordered_json;

struct OutcomeEntry {
  const char* name;
  const char* text;  // of so many frames
  FrameFate fate;
};
constexpr OutcomeEntry kOutcomes[] = {{"done", "rendered", FrameFate::kDone},
                                      {"skipped", "skipped", FrameFate::kSkipped},
                                      {"stopped", "stopped", FrameFate::kStopped},
                                      {"failed", "failed", FrameFate::kFailed}};

Json outcome_json(const FrameOutcome& o) {
  Json json = {{"frame", o.frame},
               {"state", kOutcomes[size_t(o.fate)].name},
               {"exit_code", o.exit_code},
               {"output", o.outputs}};
  if (o.fate == FrameFate::kSkipped) return json;
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

}  // namespace

std::vector<int> RangeReport::of_fate(FrameFate fate) const {
  std::vector<int> list;
  for (const FrameOutcome& outcome : frames) {
    if (outcome.fate == fate) list.push_back(outcome.frame);
  }
  return list;
}

std::string describe(const RangeReport& report) {
  std::string text;
  for (const OutcomeEntry& entry : kOutcomes) {
    const std::vector<int> list = report.of_fate(entry.fate);
    if (list.empty()) continue;
    text += fmt::format("{}{} {}", text.empty() ? "frames: " : ", ", list.size(), entry.text);
    const bool named = entry.fate == FrameFate::kStopped || entry.fate == FrameFate::kFailed;
    if (named) text += fmt::format(" ({})", shortened(frames_text(list)));
  }
  if (report.left.empty()) return text;
  return text + fmt::format("{}{} left: {}", text.empty() ? "frames: " : ", ", report.left.size(),
                            shortened(frames_text(report.left)));
}

std::string range_report_json(const RenderOptions& options, const RangeReport& report) {
  Json json;
  for (const OutcomeEntry& entry : kOutcomes)
    json[entry.name] = frames_text(report.of_fate(entry.fate));
  json["left"] = frames_text(report.left);
  json["exit_code"] = report.exit_code;
  json["time"] = {{"wall_s", report.wall_s}, {"cpu_s", report.cpu_s}};
  Json& frames = json["frames"] = Json::array();
  for (const FrameOutcome& outcome : report.frames) frames.push_back(outcome_json(outcome));
  for (const auto& [name, text] : settings_attributes(options)) {
    constexpr std::string_view kPrefix = "emberline:", kVersion = "emberline:version:";
    if (name.starts_with(kVersion)) {
      json["versions"][name.substr(kVersion.size())] = text;
    } else {
      json["settings"][name.substr(kPrefix.size())] = text;
    }
  }
  json["machine"] = {{"host", host_name()}, {"instruction_sets", instruction_sets()}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace emberline
