#include "renderer/engine/frame_plan.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "io/exr/writer.h"
#include "renderer/core/errors.h"
#include "renderer/drivers/adaptive/error_estimator.h"
#include "renderer/engine/frame_scene.h"
#include "renderer/engine/half_layers.h"
#include "renderer/engine/open_scene.h"
#include "renderer/film/cryptomatte_sums.h"
#include "renderer/film/path_layers.h"
#include "renderer/lights/environment_guide.h"
#include "renderer/lights/light_guide.h"
#include "renderer/scene/camera_solids.h"
#include "renderer/scene/empty_pixels.h"
#include "renderer/scene/light_survey.h"

namespace emberline {
namespace {

constexpr uint32_t kDefaultSamples = 64;
// Where a threshold alone is given, a pixel that never meets it ends somewhere.
constexpr uint32_t kDefaultMostSamples = 4096;

// Options that only mean something to adaptive sampling.
void refuse_adaptive_options(const FrameSettings& o, const std::string& reason) {
  const auto refuse = [&](const char* option) {
    throw UsageError(std::string(option) + ": " + reason);
  };
  if (o.noise_threshold) refuse("`noise-threshold`");
  if (o.min_spp) refuse("`min-spp`");
  if (o.max_spp) refuse("`max-spp`");
  if (!o.estimator.empty()) refuse("`estimator`");
  if (o.allocation) refuse("`allocation`");
  if (o.unbiased) refuse("`unbiased`");
}

// A sampler that has to know a pixel's count beforehand is of no use where the noise decides it.
void refuse_fixed_counts(const std::string& sampler) {
  std::string valid;
  bool refused = false;
  for (const SamplerEntry& entry : sampler_table()) {
    if (entry.counts == SampleCounts::kAny) {
      if (!valid.empty()) valid += ", ";
      valid += entry.name;
    } else if (entry.name == sampler) {
      refused = true;
    }
  }
  if (!refused) return;
  throw UsageError("`sampler`: " + sampler +
                   " needs to know each pixel's number of samples beforehand, which adaptive "
                   "sampling does not; valid names are " +
                   valid);
}

// The estimators that say how much a sample would bring, and not only which pixels are finished.
std::string sharing_estimators() {
  std::string names;
  for (const EstimatorEntry& entry : estimator_table()) {
    if (entry.batch > 0) continue;
    if (!names.empty()) names += ", ";
    names += entry.name;
  }
  return names;
}

// What has asked for the channels of denoising.
const char* option_of_halves(const FrameSettings& o) {
  if (o.allocation == ErrorMetric::kDenoised) return "`allocation` denoised";
  return o.denoise ? "`denoise`" : "`aov` denoising";
}

// As many as are asked for, or `least`.
StreamCount streams_of(const FrameSettings& o, StreamCount least) {
  const bool halves = aovs_of(o).contains(Aov::kDenoising);
  if (halves && o.streams == 1) {
    throw UsageError("{}: it compares two sample streams; leave `streams` out, or give 2",
                     option_of_halves(o));
  }
  if (o.streams) return static_cast<StreamCount>(*o.streams);
  return halves ? StreamCount::kTwo : least;
}

// Of two halves, where a pixel may have no more than so many samples.
void part_few_samples(uint32_t samples, FramePlan& plan) {
  if (!plan.aovs.contains(Aov::kDenoising) || samples >= kLeastStreamSamples) return;
  plan.half_block = (samples + 1) / 2;
}

void plan_even(const FrameSettings& o, FramePlan& plan) {
  refuse_adaptive_options(
      o, plan.driver->sharing == Sharing::kEvenWithoutThreshold
             ? fmt::format("without `noise-threshold` the {} driver gives every pixel `spp` "
                           "samples; give a threshold, or `driver` adaptive",
                           o.driver)
             : fmt::format("the {} driver gives every pixel `spp` samples; valid with `driver` "
                           "adaptive, or bucket with `noise-threshold`",
                           o.driver));
  plan.samples_per_pixel = o.spp.value_or(kDefaultSamples);
  if (o.sample_range) {
    if (o.spp) throw UsageError("`spp`: `sample-range` says how many samples each pixel gets");
    const std::vector<std::string_view> valid = extensible_samplers();
    if (std::ranges::find(valid, o.sampler) == valid.end()) {
      throw UsageError(
          "`sampler`: the samples of {} depend on how many there are; `sample-range` is valid with "
          "{}",
          o.sampler, fmt::join(valid, ", "));
    }
    plan.first_sample = o.sample_range->first;
    plan.samples_per_pixel = o.sample_range->end - o.sample_range->first;
  }
  plan.streams = streams_of(o, StreamCount::kOne);
  if (!o.sample_range) part_few_samples(plan.samples_per_pixel, plan);
}

void refuse_beside_denoised(const FrameSettings& o, const DriverEntry& driver) {
  if (o.allocation != ErrorMetric::kDenoised) return;
  if (driver.tiles) {
    throw UsageError(
        "`allocation` denoised: a tile knows nothing of the pixels around it, of which a denoised "
        "picture is made; valid with `driver` adaptive");
  }
  if (o.noise_threshold) {
    throw UsageError(
        "`allocation` denoised: the error of a denoised pixel is its neighbours' too, so that none "
        "can be finished alone; leave `noise-threshold` out, `spp` limits the frame");
  }
  if (o.unbiased) {
    throw UsageError(
        "`allocation` denoised: it looks at the means of all samples, which `unbiased` does not "
        "show; leave one of them out");
  }
}

void plan_by_error(const FrameSettings& o, FramePlan& plan) {
  refuse_fixed_counts(o.sampler);
  if (o.sample_range) {
    throw UsageError(
        "`sample-range`: adaptive sampling decides itself how many samples each pixel gets; give "
        "the parts a `seed` each");
  }
  const EstimatorEntry& estimator =
      find_estimator(o.estimator.empty() ? kDefaultEstimator : std::string_view(o.estimator));
  AdaptiveSettings& a = plan.driver_settings.adaptive;
  a.estimator = estimator.name;
  if (o.allocation) {
    a.allocation = *o.allocation;
    if (estimator.batch > 0) {
      throw UsageError(fmt::format(
          "`allocation`: the estimator {} only tells which pixels are finished, and the others "
          "share evenly; valid with {}",
          estimator.name, sharing_estimators()));
    }
    refuse_beside_denoised(o, *plan.driver);
  }
  if (o.streams && static_cast<StreamCount>(*o.streams) < estimator.streams) {
    throw UsageError(
        fmt::format("`streams` {}: the estimator {} compares two sample streams; leave `streams` "
                    "out, or give 2",
                    *o.streams, estimator.name));
  }
  plan.streams = streams_of(o, estimator.streams);
  a.threshold = o.noise_threshold.value_or(0.0f);
  a.min_samples = o.min_spp.value_or(0);
  a.max_samples = o.max_spp.value_or(0);
  a.unbiased = o.unbiased;
  if (o.unbiased && estimator.batch > 0) {
    throw UsageError(fmt::format(
        "`unbiased`: every pixel must take part in every round, and the estimator {} leaves the "
        "finished ones out; valid with {}",
        estimator.name, sharing_estimators()));
  }
  if (o.unbiased && o.max_spp) {
    throw UsageError(
        "`unbiased`: every pixel must take part in every round, which `max-spp` "
        "forbids; leave it out, `spp` limits the frame");
  }
  if (o.min_spp && o.max_spp && *o.min_spp > *o.max_spp) {
    throw UsageError(fmt::format("`min-spp` {} is above `max-spp` {}; valid is 1 to {}", *o.min_spp,
                                 *o.max_spp, *o.max_spp));
  }
  if (o.min_spp && o.spp && *o.min_spp > *o.spp) {
    throw UsageError(fmt::format("`min-spp` {} is above the average of `spp` {}; valid is 1 to {}",
                                 *o.min_spp, *o.spp, *o.spp));
  }
  if (o.spp) {
    a.budget = *o.spp;
  } else if (o.unbiased || (a.threshold <= 0.0f && a.max_samples == 0)) {
    a.budget = kDefaultSamples;
  } else if (a.max_samples == 0) {
    a.max_samples = std::max(kDefaultMostSamples, a.min_samples);
  }
  plan.samples_per_pixel = a.budget;
  // An estimator of two streams waits for the second by itself.
  a.two_halves = plan.streams == StreamCount::kTwo && estimator.streams == StreamCount::kOne;
  const uint32_t most = a.max_samples > 0 ? a.max_samples : kLeastStreamSamples;
  part_few_samples(a.budget > 0 ? std::min(a.budget, most) : most, plan);
}

void require(bool given, const char* option, bool other_given, const char* other) {
  if (given && !other_given) throw UsageError(std::string(option) + " requires " + other);
}

// What is asked of layers that there are none of, or that they do not bear.
void check_layers_of_file(const FrameSettings& s) {
  const AovSet aovs = aovs_of(s);
  for (const std::string& layer : parse_half_layers(s.half)) {
    const auto aov = std::ranges::find(aov_table(), layer, &NamedValue<Aov>::name);
    if (layer == "light") {
      require(true, "`half` light", s.light_groups, "`light-groups`");
    } else if (layer == "denoised") {
      require(true, "`half` denoised", denoises(s), "`denoise`");
    } else if (aov != aov_table().end() && !aovs.contains(aov->value)) {
      throw UsageError("`half` {0} requires `aov` {0}", layer);
    }
  }
  if (!is_lossy(s.exr_compression) || s.exr_parts == ExrParts::kLayers) return;
  const char* const blurred = !s.cryptomattes.empty()          ? "the ids of `cryptomatte`"
                              : aovs.contains(Aov::kVariance)  ? "`aov` variance"
                              : aovs.contains(Aov::kDenoising) ? "what denoising reads"
                              : aovs.contains(Aov::kNormal)    ? "`aov` N"
                              : aovs.contains(Aov::kPosition)  ? "`aov` P"
                              : aovs.contains(Aov::kVelocity)  ? "`aov` velocity"
                                                               : nullptr;
  if (!blurred) return;
  throw UsageError(
      "`exr-compression` {}: it would blur {}; add `exr-parts` layers, which keeps that part zip",
      name_of(exr_compression_table(), s.exr_compression), blurred);
}

// Settings that mean nothing without others.
void check_companions(const FrameSettings& s) {
  const FrameSettings none;
  const bool from = s.look_from.has_value(), at = s.look_at.has_value();
  require(from, "`look-from`", at || s.panorama, "`look-at`");
  require(at, "`look-at`", from, "`look-from`");
  if (s.panorama && (s.fov_y || s.f_stop || s.focus_distance)) {
    throw UsageError(
        "{}: `panorama` shows all around and is sharp everywhere; leave one of the two out",
        s.fov_y    ? "`fov-y`"
        : s.f_stop ? "`f-stop`"
                   : "`focus-distance`");
  }
  if (!s.environment.empty() && s.sun) {
    throw UsageError("`sun`: `env` gives a sky already; leave one of the two out");
  }
  const bool environment = !s.environment.empty() || s.sun;
  require(s.environment_strength != none.environment_strength, "`env-strength`", environment,
          "`env` or `sun`");
  require(s.environment_rotation != none.environment_rotation, "`env-rotation`", environment,
          "`env` or `sun`");
  require(AovSet::parse(s.aovs).contains(Aov::kClamped), "`aov` clamped",
          s.clamp_indirect.has_value(), "`clamp-indirect`");
  if (s.clamp_indirect && !find_integrator(s.integrator).tells_lights_apart) {
    throw UsageError("`clamp-indirect`: the integrator {} has no light to clamp; valid with path",
                     s.integrator);
  }
  if (s.light_samples > 1 && !find_integrator(s.integrator).tells_lights_apart) {
    throw UsageError("`light-samples`: the integrator {} samples no light; valid with path, direct",
                     s.integrator);
  }
  if (aovs_of(s).contains(Aov::kDenoising) && !find_integrator(s.integrator).tells_lights_apart) {
    throw UsageError("{}: not of the integrator {}; valid with path, direct", option_of_halves(s),
                     s.integrator);
  }
  const PathLayers layers(aovs_of(s));
  if (!layers.empty() && !find_integrator(s.integrator).tells_lights_apart) {
    throw UsageError("`aov` {}: the integrator {} knows no light; valid with path, direct",
                     name_of(aov_table(), aov_of(layers.list().front())), s.integrator);
  }
  require(AovSet::parse(s.aovs).contains(Aov::kShadow), "`aov` shadow", !s.catchers.empty(),
          "`catcher`");
  const char* const role = !s.catchers.empty()   ? "`catcher`"
                           : !s.holdouts.empty() ? "`holdout`"
                                                 : nullptr;
  if (role && !find_integrator(s.integrator).tells_lights_apart) {
    throw UsageError("{}: the integrator {} knows no light; valid with path, direct", role,
                     s.integrator);
  }
  require(s.cryptomatte_levels != none.cryptomatte_levels, "`cryptomatte-levels`",
          !s.cryptomattes.empty(), "`cryptomatte`");
  check_layers_of_file(s);
  if (!s.cryptomattes.empty() && s.unbiased) {
    throw UsageError(
        "`cryptomatte`: `unbiased` weighs rounds, which are not kept by object; leave one of the "
        "two out");
  }
  chosen_time(s);
}

}  // namespace

FramePlan::FramePlan(const FrameSettings& s, const PrepareOptions& options)
    : driver(&find_driver(s.driver)),
      width(s.width),
      height(s.height),
      crop(crop_of(s)),
      even(shares_evenly(s)),
      seed(s.seed),
      aovs(aovs_of(s)),
      shutter_frames(is_instant(s) ? 1.0 : s.shutter->close - s.shutter->open),
      clamp_indirect(s.clamp_indirect.value_or(0.0f)),
      find_empty_pixels(options.find_empty_pixels),
      filter(s.filter_radius ? PixelFilter::create(s.filter, *s.filter_radius)
                             : PixelFilter::create(s.filter)) {
  check_companions(s);
  if (s.part && !driver->tiles) {
    throw UsageError(
        "`part`: the driver {} has the whole frame at once; valid with `driver` bucket", s.driver);
  }
  driver_settings.bucket_size = s.bucket_size;
  driver_settings.bucket_order = s.bucket_order;
  driver_settings.part = s.part.value_or(FramePart{});
  driver_settings.bisection_axis = s.bisection_axis;
  driver_settings.reconstruction = s.reconstruction;
  driver_settings.cryptomattes = int(parse_cryptomattes(s.cryptomattes).size());
  driver_settings.cryptomatte_levels = s.cryptomatte_levels;
  driver_settings.explained = options.explained;
  driver_settings.keep_tree = options.keep_tree;
  driver_settings.extending = options.extending;
  even ? plan_even(s, *this) : plan_by_error(s, *this);
  integrator = create_integrator(s.integrator, {.max_depth = s.max_depth,
                                                .transparent = s.transparent,
                                                .clamp_indirect = clamp_indirect,
                                                .light_samples = s.light_samples});
  guides_lights = s.environment_sampling == EnvironmentSampling::kGuided && s.max_depth > 0 &&
                  find_integrator(s.integrator).tells_lights_apart;
  build.show_backfaces = s.show_backfaces;
  build.isa = s.isa;
  build.unread_uv = find_integrator(s.integrator).shows_uv || aovs.contains(Aov::kUv);
  sampler = create_sampler(s.sampler, {streams, std::max(1u, samples_per_pixel), width, height});
  if (options.aovs) aovs = *options.aovs;
}

namespace {

std::shared_ptr<const LightGuide> guide_by_all_light(const Scene& scene) {
  const EnvironmentLight* const light = scene.lights().environment();
  if (!light) return nullptr;
  auto guide = std::make_shared<EnvironmentGuide>(*light);
  guide->set_regions(SkyRegions::everywhere());
  return std::make_shared<LightGuide>(LightGuide{.environment = std::move(guide)});
}

}  // namespace

std::unique_ptr<RenderJob> FramePlan::prepare(const OpenScene& scene, const Camera& camera,
                                              const std::stop_token& stop) const {
  return std::make_unique<RenderJob>(frame(scene.scene(), camera, scene.parts(), stop), drivers());
}

Frame FramePlan::frame(const Scene& scene, const Camera& camera, const SceneParts& parts,
                       const std::stop_token& stop) const {
  return {.scene = scene,
          .camera = camera,
          .integrator = *integrator,
          .sampler = *sampler,
          .filter = filter,
          .width = width,
          .height = height,
          .crop = crop,
          .first_sample = first_sample,
          .samples_per_pixel = samples_per_pixel,
          .seed = seed,
          .streams = streams,
          .half_block = half_block,
          .aovs = aovs,
          .shutter_frames = shutter_frames,
          .exact_counts = even,
          .clamp_indirect = clamp_indirect,
          .light_groups = parts.light_groups,
          .cryptomattes = parts.cryptomattes,
          .roles = parts.roles,
          .empty_pixels = find_empty_pixels
                              ? EmptyPixels::find(scene, camera, width, height, filter.radius())
                              : nullptr,
          .camera_solids = CameraSolids::find(scene, camera),
          .guide = guides_lights ? find_light_guide(scene, camera, width, height, stop) : nullptr,
          .catcher_guide = aovs.contains(Aov::kShadow) ? guide_by_all_light(scene) : nullptr};
}

bool shares_evenly(const FrameSettings& settings) {
  switch (find_driver(settings.driver).sharing) {
    case Sharing::kEven:
      return true;
    case Sharing::kEvenWithoutThreshold:
      return !settings.noise_threshold;
    case Sharing::kByError:
      return false;
  }
  return true;
}

bool denoises(const FrameSettings& settings) {
  return settings.denoise || settings.allocation == ErrorMetric::kDenoised;
}

AovSet aovs_of(const FrameSettings& settings) {
  AovSet aovs = AovSet::parse(settings.aovs);
  if (denoises(settings)) aovs.insert(Aov::kDenoising);
  if (!settings.catchers.empty()) aovs.insert(Aov::kShadow);
  return aovs;
}

Rect crop_of(const FrameSettings& settings) {
  const Rect frame{0, 0, settings.width, settings.height};
  if (!settings.crop) return frame;
  const Rect& crop = *settings.crop;
  if (crop.empty() || crop.intersect(frame) != crop) {
    throw UsageError(
        fmt::format("`crop`: {},{},{},{} is not inside the frame; valid is 0 <= X0 < X1 <= {} and "
                    "0 <= Y0 < Y1 <= {}",
                    crop.x0, crop.y0, crop.x1, crop.y1, settings.width, settings.height));
  }
  return crop;
}

}  // namespace emberline
