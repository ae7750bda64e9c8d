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

// The window writes no layers, so rules about layers must not reject its settings.
RenderPlan plan_of(RenderOptions options, const ViewSettings& settings) {
  options.light_groups = false;
  options.half.clear();
  return RenderPlan(options, {.aovs = wanted_aovs(settings),
                              .find_empty_pixels = false,
                              .keep_tree = settings.overlay == ViewOverlay::kTree});
}

}  // namespace

bool is_live(const RenderOptions& options) { return options.driver == kLiveDriver; }

bool renders_buckets(const RenderOptions& options) { return main_driver(options).tiles; }

bool is_allowed(const RenderOptions& options, std::string_view setting) {
  FrameSettings settings = options;
  settings.driver = main_driver(options).name;
  return setting_is_allowed(settings, setting);
}

bool can_relight(const RenderOptions& options) {
  return !renders_buckets(options) && find_integrator(options.integrator).tells_lights_apart;
}

RenderOptions main_options(const ViewSettings& settings) {
  RenderOptions options = settings.render;
  const DriverEntry& driver = main_driver(options);
  options.driver = driver.name;
  options.crop = settings.crop;
  options.cryptomattes.clear();
  options.catchers.clear();
  options.holdouts.clear();
  options.cryptomatte_levels = FrameSettings().cryptomatte_levels;
  // Otherwise every change of view would wait for a survey.
  options.environment_sampling = EnvironmentSampling::kByLight;
  options.denoise = false;  // from --settings; the window shows the raw frame
  if (options.allocation == ErrorMetric::kDenoised) options.allocation.reset();
  const bool ends_itself = options.noise_threshold || options.max_spp || driver.tiles;
  if (!options.spp && !ends_itself) options.spp = kViewSamples;
  return options;
}

AovSet wanted_aovs(const ViewSettings& settings) {
  AovSet aovs = AovSet::parse(settings.render.aovs);
  // Only drivers of the whole frame report stop reasons while rendering; buckets need the channel.
  const bool told = settings.overlay == ViewOverlay::kStop && !renders_buckets(settings.render);
  const std::optional<Aov> aov = overlay_aov(settings.overlay);
  if (aov && !told) aovs.insert(*aov);
  if (settings.denoise) LiveDenoiser::add_channels(aovs);
  return aovs;
}

bool frames_serve(const ViewSettings& a, const ViewSettings& b) {
  if (!same_samples(a.render, b.render) || a.region != b.region || a.crop != b.crop ||
      a.light_groups != b.light_groups) {
    return false;
  }
  if (b.overlay == ViewOverlay::kTree && a.overlay != ViewOverlay::kTree) return false;
  const AovSet have = wanted_aovs(a), wanted = wanted_aovs(b);
  return std::ranges::all_of(aov_table(), [&](const NamedValue<Aov>& entry) {
    return have.contains(entry.value) || !wanted.contains(entry.value);
  });
}

PreparedSettings::PreparedSettings(const ViewSettings& settings)
    : options(main_options(settings)),
      live(is_live(settings.render)),
      plan(plan_of(options, settings)),
      light_groups(settings.light_groups && can_relight(options)) {}

}  // namespace emberline
