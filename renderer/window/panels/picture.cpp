// The render and display tabs.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>

#include "renderer/core/readable.h"
#include "renderer/engine/setting_table.h"
#include "renderer/session/overlay_picture.h"
#include "renderer/session/prepared_settings.h"
#include "renderer/statistics/colour_map.h"
#include "renderer/window/panels/action_widgets.h"
#include "renderer/window/panels/panels.h"
#include "renderer/window/panels/theme.h"
#include "renderer/window/panels/widgets.h"
#include "renderer/window/picture/histogram.h"
#include "renderer/window/workbench/clock.h"

namespace emberline {
namespace {

constexpr int kMaxSliderSamples = 65536;
constexpr int kMaxSliderDepth = 64;

struct FrameSize {
  int width, height;
};
constexpr std::array kFrameSizes = {FrameSize{640, 360},   FrameSize{960, 540},
                                    FrameSize{1280, 720},  FrameSize{1920, 1080},
                                    FrameSize{2560, 1440}, FrameSize{3840, 2160}};

std::vector<widgets::Choice> choices_of_setting(std::string_view name) {
  return widgets::choices_of(find_setting(name)->choices);
}

bool choose_setting(const widgets::Row& row, std::string_view name, RenderOptions& options) {
  const Setting& setting = *find_setting(name);
  std::string value = setting.text(options);
  if (!widgets::choose(row, value, choices_of_setting(name))) return false;
  setting.read(options, value);
  return true;
}

// Resets settings that the chosen driver or threshold does not allow, instead of rejecting the
// choice.
void reset_excluded_settings(RenderOptions& options) {
  if (!main_driver_allows(options, "noise-threshold")) options.noise_threshold.reset();
  if (main_driver_allows(options, "estimator")) return;
  options.estimator.clear();
  options.allocation.reset();
  options.min_spp.reset();
  options.max_spp.reset();
  options.unbiased = false;
}

bool choose_driver(RenderOptions& options) {
  std::vector<widgets::Choice> drivers = {
      {kLiveDriver, title_case(kLiveDriver),
       "Fills the whole picture by bisection, then adds samples where the error is largest"}};
  std::ranges::copy(choices_of_setting("driver"), std::back_inserter(drivers));
  if (!widgets::choose({"Driver", "Which pixels get their samples first"}, options.driver, drivers))
    return false;
  reset_excluded_settings(options);
  return true;
}

bool set_limits(RenderOptions& options) {
  bool changed = false;
  bool limited = options.spp.has_value();
  if (widgets::check({"Limit Samples",
                      "Stop after a number of samples. Otherwise the picture keeps improving."},
                     limited)) {
    options.spp = limited ? std::optional<uint32_t>(64) : std::nullopt;
    changed = true;
  }
  if (options.spp) {
    int spp = int(std::min<uint32_t>(*options.spp, kMaxSliderSamples));
    if (widgets::slide({"Samples", "Samples per pixel; an average with adaptive sampling"}, spp, 1,
                       kMaxSliderSamples, true)) {
      options.spp = uint32_t(spp);
      changed = true;
    }
  }
  if (!main_driver_allows(options, "noise-threshold")) return changed;
  bool threshold = options.noise_threshold.has_value();
  if (widgets::check({"Noise Threshold",
                      "Stop sampling a pixel when its expected error in the displayed picture is "
                      "at most the threshold"},
                     threshold)) {
    options.noise_threshold = threshold ? std::optional<float>(0.01f) : std::nullopt;
    reset_excluded_settings(options);
    changed = true;
  }
  if (options.noise_threshold) {
    changed |= widgets::slide(
        {"Threshold", "Largest error of a finished pixel: 0.02 shows noise, 0.005 hardly any"},
        *options.noise_threshold, 0.0005f, 0.1f, "%.4f", true);
  }
  return changed;
}

bool choose_size(RenderOptions& options) {
  std::vector<std::string> names;
  for (const FrameSize& size : kFrameSizes) {
    names.push_back(fmt::format("{} × {}", size.width, size.height));
  }
  const std::string now = fmt::format("{} × {}", options.width, options.height);
  const auto listed = std::ranges::find(names, now);
  int index = listed == names.end() ? -1 : int(listed - names.begin());
  if (!widgets::choose_index({"Size", "Width and height of the picture in pixels"}, index,
                             widgets::choices_of_names(names), now))
    return false;
  options.width = kFrameSizes[size_t(index)].width;
  options.height = kFrameSizes[size_t(index)].height;
  return true;
}

void draw_actions(Workbench& bench) {
  const float half = widgets::half_width();
  action_button(bench, bench.session.settings().paused ? "Resume" : "Pause", Action::kPause, half);
  ImGui::SameLine();
  action_button(bench, "Restart", Action::kRestart, half);
}

void draw_histogram(Workbench& bench) {
  static Histogram histogram;  // there is one window, with one thread
  if (!bench.picture()) return;
  histogram.update(bench.picture(), window_time_s());
  const float height = 5.0f * ImGui::GetFontSize();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float width = ImGui::GetContentRegionAvail().x;
  ImGui::Dummy({width, height});
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddRectFilled(at, {at.x + width, at.y + height}, ImGui::GetColorU32(ImGuiCol_FrameBg));
  constexpr std::array kInks = {IM_COL32(213, 94, 0, 150), IM_COL32(0, 158, 115, 150),
                                IM_COL32(86, 180, 233, 150)};
  for (size_t c = 0; c < kInks.size(); ++c) {
    for (int i = 0; i < Histogram::kBins; ++i) {
      const float bar = histogram.height(c, i);
      if (bar <= 0.0f) continue;
      const float x0 = at.x + width * float(i) / Histogram::kBins;
      const float x1 = at.x + width * float(i + 1) / Histogram::kBins;
      list.AddRectFilled({x0, at.y + height * (1.0f - bar)}, {x1, at.y + height}, kInks[c]);
    }
  }
  ImGui::TextColored(muted_colour(), "Black %s", readable_percent(histogram.black()).c_str());
  const std::string clipped = "Clipped " + readable_percent(histogram.clipped());
  ImGui::SameLine(ImGui::GetContentRegionMax().x - ImGui::CalcTextSize(clipped.c_str()).x);
  ImGui::TextColored(histogram.clipped() > 0.01 ? warning_colour() : muted_colour(), "%s",
                     clipped.c_str());
}

// Lets the user choose an enumerator. `table` must have a row for each enumerator, in the order of
// the enum.
template <typename Enum, typename Table>
bool choose_value(const widgets::Row& row, Enum& value, const Table& table) {
  int index = int(value);
  if (!widgets::choose_index(row, index, widgets::choices_of(table))) return false;
  value = Enum(index);
  return true;
}

bool choose_heatmap_style(HeatmapStyle& style) {
  bool changed =
      choose_value({"Colours", "Colour map of the overlay"}, style.colours, colour_map_table());
  changed |=
      widgets::check({"Logarithmic", "Use a logarithmic scale for the colours"}, style.logarithmic);
  return changed;
}

bool choose_display(DisplaySettings& display, const DisplayNames& names) {
  bool changed = false;
  std::vector<widgets::Choice> displays;
  for (const auto& entry : names.displays) displays.push_back({entry.name, entry.name, ""});
  const auto used = std::ranges::find_if(
      names.displays, [&](const auto& entry) { return entry.name == display.display; });
  const auto& active_display = used == names.displays.end() ? names.displays.front() : *used;
  const std::vector<widgets::Choice> views = widgets::choices_of_names(active_display.views);
  const std::vector<widgets::Choice> looks = widgets::choices_of_names(names.looks);
  std::string name = display.display.empty() ? active_display.name : display.display;
  if (displays.size() > 1 &&
      widgets::choose({"Display", "Display device that the picture is shown on"}, name, displays)) {
    display.display = name;
    display.view.clear();
    changed = true;
  }
  name = display.view.empty() && !active_display.views.empty() ? active_display.views.front()
                                                               : display.view;
  if (widgets::choose({"View", "View transform from scene values to the display"}, name, views)) {
    display.view = name;
    changed = true;
  }
  if (!looks.empty())
    changed |= widgets::choose({"Look", "Look applied before the view transform"}, display.look,
                               looks, "None");
  return changed;
}

std::string format_samples(const SessionPicture& picture) {
  const double pixels = double(picture.width) * double(picture.height);
  return fmt::format("{:.1f} samples/px", double(picture.samples) / pixels);
}

std::string describe_display(const DisplaySettings& display) {
  std::string words = fmt::format("exposure {:+.2f}", display.exposure);
  if (!display.view.empty()) words += ", " + display.view;
  if (!display.look.empty()) words += ", " + display.look;
  return words;
}

// Describes pictures A and B of the wipe, so that a different exposure is not mistaken for
// different light.
void draw_sides(Workbench& bench) {
  const StoredPicture& stored = bench.comparison.stored();
  if (!stored.picture || !bench.picture()) return;
  const bool overlay = !stored.picture->overlay_legend.empty();
  ImGui::BeginDisabled(overlay);
  bool graded_as_a = bench.comparison.graded_as_a();
  if (widgets::check(
          {"Grade B Like A",
           "Show B with the display settings of A. Otherwise B keeps its own exposure, view "
           "and look."},
          graded_as_a)) {
    bench.comparison.set_graded_as_a(graded_as_a);
  }
  ImGui::EndDisabled();
  widgets::muted_paragraph("A (left): current picture, " + format_samples(*bench.picture()) + ", " +
                           describe_display(bench.session.settings().display));
  widgets::muted_paragraph(fmt::format("B (right): kept {} ago, {}, {}",
                                       readable_seconds(window_time_s() - stored.time_s),
                                       format_samples(*stored.picture),
                                       overlay       ? "with its overlay"
                                       : graded_as_a ? "graded like A"
                                                     : describe_display(stored.display)));
}

void draw_comparison(Workbench& bench) {
  Comparison& comparison = bench.comparison;
  const Wipe wipe = comparison.wipe();
  const float half = widgets::half_width();
  action_button(bench, "Keep as B", Action::kStoreSnapshot, half);
  ImGui::SameLine();
  ImGui::BeginDisabled(!comparison.stored().picture);
  action_button(bench, wipe == Wipe::kStored ? "End Wipe" : "Wipe A/B", Action::kWipe, half);
  ImGui::EndDisabled();
  ImGui::BeginDisabled(!bench.session.settings().denoise);
  const bool raw = wipe == Wipe::kRaw;
  action_button(bench, raw ? "End Wipe##raw" : "Wipe Denoised/Raw", Action::kWipeRaw, -1.0f);
  ImGui::EndDisabled();
  if (wipe != Wipe::kNone) {
    float wipe_position = 100.0f * comparison.wipe_position();
    if (widgets::slide({"Wipe", "Position of the wipe, from the left edge"}, wipe_position, 0.0f,
                       100.0f, "%.0f %%")) {
      comparison.set_wipe_position(0.01f * wipe_position);
    }
  }
  draw_sides(bench);
}

}  // namespace

void draw_sampling(Workbench& bench) {
  draw_actions(bench);
  if (const std::string problem = bench.session.problem(); !problem.empty()) {
    ImGui::PushStyleColor(ImGuiCol_Text, error_colour());
    widgets::paragraph(problem);
    ImGui::PopStyleColor();
  }
  ViewSettings settings = bench.session.settings();
  RenderOptions& options = settings.render;
  widgets::heading("Method");
  bool changed = choose_driver(options);
  changed |=
      choose_setting({"Integrator", "What is computed for each sample"}, "integrator", options);
  changed |= choose_setting({"Sampler", "How the samples are distributed"}, "sampler", options);
  if (main_driver_allows(options, "estimator")) {
    changed |= widgets::choose({"Estimator", "How the adaptive driver estimates the error"},
                               options.estimator, choices_of_setting("estimator"),
                               title_case(kDefaultEstimator).c_str());
  }
  if (is_main_driver_tiled(options)) {
    changed |= widgets::slide({"Bucket Size", "Width and height of a bucket in pixels"},
                              options.bucket_size, 8, 256);
    changed |=
        choose_setting({"Bucket Order", "Which bucket is rendered first"}, "bucket-order", options);
  }
  widgets::heading("Samples");
  changed |= set_limits(options);
  changed |=
      widgets::slide({"Max Depth", "Largest number of scattering events. 1 is direct light only."},
                     options.max_depth, 0, kMaxSliderDepth);
  widgets::heading("Frame");
  changed |= choose_size(options);
  if (changed) bench.settings.change(settings);
}

void draw_display(Workbench& bench) {
  ViewSettings settings = bench.session.settings();
  bool changed = false, reset = false;
  changed |= widgets::slide({"Exposure", "Brightness of the displayed picture in stops",
                             settings.display.exposure != 0.0f, &reset},
                            settings.display.exposure, -8.0f, 8.0f, "%+.2f");
  if (reset) {
    settings.display.exposure = 0.0f;
    changed = true;
  }
  changed |= choose_display(settings.display, bench.display_names);
  changed |=
      choose_value({"Overlay", "Show a heatmap instead of the picture (O shows the next one)"},
                   settings.overlay, overlay_table());
  const ViewOverlay overlay = settings.overlay;
  if (overlay != ViewOverlay::kNone && overlay != ViewOverlay::kTree &&
      overlay != ViewOverlay::kStop) {
    changed |= choose_heatmap_style(settings.render.heatmap_style);
  }
  if (changed) bench.settings.change(settings);
  bool denoise = settings.denoise;
  if (widgets::check(
          {"Denoise",
           "Denoise the displayed picture (N). Saved pictures and pixel values stay raw."},
          denoise)) {
    bench.act(Action::kDenoise);
  }
  widgets::heading("Display Histogram");
  draw_histogram(bench);
  widgets::heading("Compare");
  draw_comparison(bench);
  widgets::heading("Region");
  if (settings.region) {
    const Rect& r = *settings.region;
    ImGui::Text("%d × %d at %d, %d", r.width(), r.height(), r.x0, r.y0);
    ImGui::SameLine();
    small_action_button(bench, "Remove", Action::kClearRegion);
  } else {
    widgets::muted_paragraph("Ctrl+drag over the picture to select a region to sample first.");
  }
}

}  // namespace emberline
