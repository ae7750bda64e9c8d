#include "renderer/session/prepared_settings.h"

#include <algorithm>

#include "renderer/engine/live_denoiser.h"
#include "renderer/engine/setting_rules.h"
#include "renderer/engine/setting_table.h"
#include "renderer/session/overlay_picture.h"

namespace emberline {
namespace {

const DriverEntry& main_driver(const RenderOptions& options) {
  return find_driver(is_live(options) ? "adaptive" : options.driver);
}

bool same_samples(const RenderOptions& a, const RenderOptions& b) {
  const auto texts = [](const RenderOptions& options) {
    using enum SettingGroup;
    return setting_texts(options, {kSample, kSeed, kSchedule, kCounts});
  };
  return a.threads == b.threads && texts(a) == texts(b);
}

// Plans the frame without the options for layers. The session writes no layers, so the rules about
// them must not reject its settings.
RenderPlan plan_of(RenderOptions options, const ViewSettings& settings) {
  options.light_groups = false;
  options.half.clear();
  return RenderPlan(options, {.aovs = required_aovs(settings),
                              .find_empty_pixels = false,
                              .keep_tree = settings.overlay == ViewOverlay::kTree});
}

}  // namespace

bool is_live(const RenderOptions& options) { return options.driver == kLiveDriver; }

bool is_main_driver_tiled(const RenderOptions& options) { return main_driver(options).tiles; }

bool main_driver_allows(const RenderOptions& options, std::string_view setting) {
  FrameSettings settings = options;
  settings.driver = main_driver(options).name;
  return setting_is_allowed(settings, setting);
}

bool can_relight(const RenderOptions& options) {
  return !is_main_driver_tiled(options) &&
         find_integrator(options.integrator).supports_light_groups;
}

RenderOptions main_options(const ViewSettings& settings) {
  RenderOptions options = settings.render;
  const DriverEntry& driver = main_driver(options);
  options.driver = driver.name;
  options.crop = settings.crop;
  options.cryptomattes.clear();
  // A session records no shadows, and its light groups do not influence the choice of samples.
  std::vector<JudgedChannel> judged = judged_channels_of(options);
  std::erase_if(judged, [](const JudgedChannel& channel) {
    return channel.name == "shadow" || channel.name == "light.*";
  });
  set_judged_channels(judged, options);
  // A session's frame has several stages, so its driver cannot plan for a time budget. The budget
  // becomes a time limit.
  if (const std::optional<double> budget = std::exchange(options.time_budget_s, std::nullopt)) {
    options.time_limit_s = std::min(*budget, options.time_limit_s.value_or(*budget));
  }
  options.catchers.clear();
  options.catcher_plane.reset();
  options.holdouts.clear();
  options.plan.clear();
  options.cryptomatte_levels = FrameSettings().cryptomatte_levels;
  // With a survey, every change of view would have to wait for a new one.
  options.environment_sampling = EnvironmentSampling::kByLight;
  options.guiding = Guiding::kOff;
  options.static_noise = true;  // edits set time and view, so no frame number applies
  options.denoise = false;      // may come from --settings; ViewSettings::denoise replaces it
  const bool is_limited = options.noise_threshold || options.max_spp || driver.tiles;
  if (!options.spp && !is_limited) options.spp = kViewSamples;
  return options;
}

AovSet required_aovs(const ViewSettings& settings) {
  AovSet aovs = AovSet::parse(settings.render.aovs);
  // Drivers that render the whole frame at once report stop reasons while rendering; bucket frames
  // need the channel for stop reasons.
  const bool reports_stops =
      settings.overlay == ViewOverlay::kStop && !is_main_driver_tiled(settings.render);
  const std::optional<Aov> aov = overlay_aov(settings.overlay);
  if (aov && !reports_stops) aovs.insert(*aov);
  if (settings.denoise) LiveDenoiser::add_channels(aovs);
  return aovs;
}

bool frame_satisfies(const ViewSettings& a, const ViewSettings& b) {
  if (!same_samples(a.render, b.render) || a.region != b.region || a.crop != b.crop ||
      a.light_groups != b.light_groups) {
    return false;
  }
  if (b.overlay == ViewOverlay::kTree && a.overlay != ViewOverlay::kTree) return false;
  const AovSet recorded = required_aovs(a), required = required_aovs(b);
  return std::ranges::all_of(aov_table(), [&](const NamedValue<Aov>& entry) {
    return recorded.contains(entry.value) || !required.contains(entry.value);
  });
}

PreparedSettings::PreparedSettings(const ViewSettings& settings)
    : options(main_options(settings)),
      live(is_live(settings.render)),
      plan(plan_of(options, settings)),
      light_groups(settings.light_groups && can_relight(options)) {}

}  // namespace emberline
