#include "renderer/output/option_rules.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "renderer/core/file_suffix.h"
#include "renderer/engine/render_plan.h"
#include "renderer/output/report_page.h"

namespace emberline {
namespace {

// A condition that cannot be checked in the frame settings alone, because it is about another
// option of `render` or about ranges of frames.
struct OptionState {
  std::string_view name, value;
  bool (*holds)(const RenderOptions& options);
};

// Whether all frames of a turntable are requested, not just one of them.
bool is_full_turntable(const RenderOptions& o) {
  return o.frames.empty() && o.turntable && !o.turntable->frame && !o.frame;
}

constexpr OptionState kStates[] = {
    // A replay writes no outputs, so the rules that require an EXR do not apply to it.
    {"output", "FILE.exr",
     [](const RenderOptions& o) { return o.replay || std::ranges::any_of(o.outputs, is_exr); }},
    {"report", "FILE.html",
     [](const RenderOptions& o) { return std::ranges::any_of(o.reports, is_page); }},
    {"snapshots", "", [](const RenderOptions& o) { return !o.snapshots.empty(); }},
    {"tree", "", [](const RenderOptions& o) { return !o.trees.empty(); }},
    {"explain", "", [](const RenderOptions& o) { return o.explained.has_value(); }},
    {"replay", "", [](const RenderOptions& o) { return o.replay.has_value(); }},
    {"display", "tev", [](const RenderOptions& o) { return o.viewer.has_value(); }},
    {"skip-existing", "", [](const RenderOptions& o) { return o.skip_existing; }},
    {"stop-on-error", "", [](const RenderOptions& o) { return o.stop_on_error; }},
    {"range-report", "", [](const RenderOptions& o) { return !o.range_report.empty(); }},
    {"frames", "", [](const RenderOptions& o) { return !o.frames.empty(); }},
    {"frames", "A-B", [](const RenderOptions& o) { return o.frames.size() > 1; }},
    {"turntable", "N", is_full_turntable},
    {"turntable", "2 or more",
     [](const RenderOptions& o) { return is_full_turntable(o) && o.turntable->count > 1; }},
    {"turntable", "K/N", [](const RenderOptions& o) { return o.turntable && o.turntable->frame; }},
};

std::string pixel_violation(const FrameSettings& settings) {
  const Vec2i pixel = *static_cast<const RenderOptions&>(settings).explained;
  const std::string message = outside_message(pixel, crop_of(settings));
  return message.empty() ? "" : "`explain`: " + message;
}

std::vector<SettingRule> make_rules() {
  return {
      {.about = {{"explain"}, {"tree"}},
       .needs = find_drivers(
           [](const DriverEntry& d) { return d.distribution == SampleDistribution::kByError; }),
       .reason = "{} does not choose sample counts for the whole frame"},
      {.about = {{"explain"}, {"tree"}, {"snapshots"}},
       .excludes = {{"plan"}},
       .unless = {{"replay"}},
       .reason = "a planned frame is rendered bucket by bucket, without further decisions"},
      {.about = {{"plan"}},
       .excludes = {{"frames", "A-B"}, {"turntable", "2 or more"}},
       .reason = "a plan belongs to a single frame"},
      {.about = {{"explain"}}, .violation = pixel_violation},
      {.about = {{"snapshots"}},
       .needs = find_drivers([](const DriverEntry& driver) { return !driver.tiles; }),
       .unless = {{"replay"}},
       .reason = "{} has no picture of the whole frame before the end"},
      {.about = {{"light-groups"}, {"cryptomatte"}},
       .needs = {{"output", "FILE.exr"}},
       .reason = "it adds layers to an EXR"},
      {.about = {{"part"}, {"sample-range"}},
       .excludes = {{"snapshots"}, {"report", "FILE.html"}},
       .reason = "a part of a frame has no picture; only the merged frame has one"},
      {.about = {{"working-space"}},
       .excludes = {{"display", "tev"}, {"snapshots"}},
       .reason = "both support only `working-space` rec709"},
      {.about = {{"skip-existing"}},
       .excludes = {{"part"}, {"sample-range"}},
       .reason = "a part writes no picture; `resume` skips finished work"},
      {.about = {{"stop-on-error"}, {"range-report"}},
       .needs = {{"frames"}, {"turntable", "N"}},
       .unless = {{"replay"}},
       .reason = "it has a meaning only for several frames"},
      {.about = {{"frames"}, {"turntable", "N"}},
       .excludes = {{"time"}},
       .reason = "`fps` sets the time of each frame"},
      {.about = {{"frames"}},
       .excludes = {{"frame"}, {"turntable", "K/N"}},
       .reason = "those select a single frame"},
      {.about = {{"frames", "A-B"}, {"turntable", "2 or more"}},
       .excludes = {{"replay"}, {"explain"}},
       .reason = "`replay` and `explain` apply to a single frame; choose one with `frames` N"},
  };
}

}  // namespace

std::span<const SettingRule> option_rules() {
  static const std::vector<SettingRule> rules = make_rules();
  return rules;
}

bool option_holds(const RenderOptions& options, const SettingCondition& condition) {
  for (const OptionState& state : kStates) {
    if (state.name == condition.name && state.value == condition.value) return state.holds(options);
  }
  return setting_holds(options, condition);
}

void check_options(const RenderOptions& options) {
  check_rules(options);
  check_rules(option_rules(), options,
              [&](const SettingCondition& condition) { return option_holds(options, condition); });
}

std::string outside_message(const Vec2i& pixel, const Rect& crop) {
  if (crop.contains(pixel.x, pixel.y)) return "";
  return fmt::format("pixel {},{} is outside the rendered pixels; valid is {} to {} and {} to {}",
                     pixel.x, pixel.y, crop.x0, crop.x1 - 1, crop.y0, crop.y1 - 1);
}

}  // namespace emberline
