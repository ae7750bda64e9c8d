#include "renderer/session/prepared_settings.h"

#include <algorithm>
#include <tuple>

#include "renderer/session/overlay_picture.h"

namespace emberline {
namespace {

// All options that a frame's samples depend on.
auto sampling_of(const RenderOptions& o) {
  return std::tie(o.driver, o.integrator, o.sampler, o.filter, o.filter_radius, o.spp, o.min_spp,
                  o.max_spp, o.noise_threshold, o.estimator, o.allocation, o.unbiased,
                  o.time_limit_s, o.max_depth, o.seed, o.streams, o.bucket_size, o.bucket_order,
                  o.bisection_axis, o.reconstruction, o.width, o.height, o.transparent, o.threads);
}

}  // namespace

const DriverEntry& main_driver(const RenderOptions& options) {
  return find_driver(options.driver == kLiveDriver ? "adaptive" : options.driver);
}

RenderOptions main_options(const ViewSettings& settings) {
  RenderOptions options = settings.render;
  const DriverEntry& driver = main_driver(options);
  options.driver = driver.name;
  options.crop.reset();
  const bool ends_itself = options.noise_threshold || options.max_spp || driver.tiles;
  if (!options.spp && !ends_itself) options.spp = kViewSamples;
  return options;
}

AovSet wanted_aovs(const ViewSettings& settings) {
  AovSet aovs = AovSet::parse(settings.render.aovs);
  // Why a pixel has ended a driver says that has its whole frame before it; buckets say it once.
  const bool told = settings.overlay == ViewOverlay::kStop && !main_driver(settings.render).tiles;
  const std::optional<Aov> aov = overlay_aov(settings.overlay);
  if (aov && !told) aovs.insert(*aov);
  return aovs;
}

bool frames_serve(const ViewSettings& a, const ViewSettings& b) {
  if (sampling_of(a.render) != sampling_of(b.render) || a.region != b.region ||
      a.light_groups != b.light_groups) {
    return false;
  }
  if (b.overlay == ViewOverlay::kTree && a.overlay != ViewOverlay::kTree) return false;
  const AovSet have = wanted_aovs(a), wanted = wanted_aovs(b);
  return std::ranges::all_of(aov_table(), [&](const AovEntry& entry) {
    return have.contains(entry.aov) || !wanted.contains(entry.aov);
  });
}

PreparedSettings::PreparedSettings(const ViewSettings& settings)
    : options(main_options(settings)),
      live(settings.render.driver == kLiveDriver),
      plan(options),
      light_groups(settings.light_groups && !plan.driver->tiles &&
                   find_integrator(options.integrator).tells_lights_apart) {
  plan.aovs = wanted_aovs(settings);
  plan.driver_settings.keep_tree = settings.overlay == ViewOverlay::kTree;
}

}  // namespace emberline
