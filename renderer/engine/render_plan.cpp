#include "renderer/engine/render_plan.h"

#include <algorithm>
#include <cmath>

#include "integrators/indirect_survey.h"
#include "renderer/core/hash.h"
#include "renderer/drivers/adaptive/error_estimator.h"
#include "renderer/drivers/adaptive/judged_channels.h"
#include "renderer/drivers/bucket_schedule.h"
#include "renderer/engine/frame_scene.h"
#include "renderer/engine/open_scene.h"
#include "renderer/engine/setting_rules.h"
#include "renderer/film/cryptomatte_sums.h"
#include "renderer/lights/environment_guide.h"
#include "renderer/lights/light_guide.h"
#include "renderer/scene/camera_solids.h"
#include "renderer/scene/empty_pixels.h"
#include "renderer/scene/light_survey.h"

namespace emberline {
namespace {

constexpr uint32_t kDefaultSamples = 64;
// The maximum number of samples for a pixel that never meets the threshold, if no other limit is
// given.
constexpr uint32_t kDefaultMaxSamples = 4096;

// Returns the shutter time in frames, or 1 if the shutter interval is empty.
double shutter_frames_of(const FrameSettings& settings) {
  return is_instant(settings) ? 1.0 : settings.shutter->close - settings.shutter->open;
}

// Returns the requested number of streams. The default is two for denoising, and otherwise
// `fallback`.
StreamCount streams_of(const FrameSettings& o, StreamCount fallback) {
  if (o.streams) return static_cast<StreamCount>(*o.streams);
  return aovs_of(o).contains(Aov::kDenoising) ? StreamCount::kTwo : fallback;
}

// The two halves get alternate blocks of samples. If pixels have few samples, shortens the blocks,
// so that each half still gets one.
void shorten_half_blocks(uint32_t samples, RenderPlan& plan) {
  if (!plan.aovs.contains(Aov::kDenoising) || samples >= kMinStreamSamples) return;
  plan.half_block = (samples + 1) / 2;
}

void plan_uniform(const FrameSettings& o, RenderPlan& plan) {
  // A frame with a time budget begins with this many samples.
  const uint32_t first = plan.aovs.contains(Aov::kDenoising) ? kMinStreamSamples : 1;
  plan.samples_per_pixel = o.time_budget_s ? first : o.spp.value_or(kDefaultSamples);
  if (o.sample_range) {
    plan.first_sample = o.sample_range->first;
    plan.samples_per_pixel = o.sample_range->end - o.sample_range->first;
  }
  plan.streams = streams_of(o, StreamCount::kOne);
  if (!o.sample_range) shorten_half_blocks(plan.samples_per_pixel, plan);
}

const EstimatorEntry& estimator_of(const FrameSettings& o) {
  return find_estimator(o.estimator.empty() ? kDefaultEstimator : std::string_view(o.estimator));
}

void plan_adaptive(const FrameSettings& o, RenderPlan& plan) {
  const EstimatorEntry& estimator = estimator_of(o);
  AdaptiveSettings& a = plan.driver_settings.adaptive;
  a.estimator = estimator.name;
  a.allocation = o.allocation.value_or(kDefaultAllocation);
  plan.streams = streams_of(o, estimator.streams);
  a.threshold = o.noise_threshold.value_or(0.0f);
  a.min_samples = o.min_spp.value_or(0);
  a.max_samples = o.max_spp.value_or(0);
  a.unbiased = o.unbiased;
  a.judged = judged_channels_of(o);
  a.is_open = o.time_budget_s.has_value();
  const bool has_streams = plan.streams == StreamCount::kTwo;
  // An estimator that uses two streams ensures by itself that each half has samples.
  a.two_halves = has_streams && estimator.streams == StreamCount::kOne;
  if (a.is_open) {
    // Only the pilot; the rest of the time decides the budget.
    a.budget = std::max(has_streams ? kMinStreamSamples : RenderPlan::kStreamBlock, a.min_samples);
  } else if (o.spp) {
    a.budget = *o.spp;
  } else if (o.unbiased || (a.threshold <= 0.0f && a.max_samples == 0)) {
    a.budget = kDefaultSamples;
  } else if (a.max_samples == 0) {
    a.max_samples = std::max(kDefaultMaxSamples, a.min_samples);
  }
  plan.samples_per_pixel = a.budget;
  const uint32_t sample_limit = a.max_samples > 0 ? a.max_samples : kMinStreamSamples;
  shorten_half_blocks(a.budget > 0 ? std::min(a.budget, sample_limit) : sample_limit, plan);
}

}  // namespace

RenderPlan::RenderPlan(const FrameSettings& s, const PrepareOptions& options)
    : driver(&driver_of(s)),
      width(s.width),
      height(s.height),
      crop(crop_of(s)),
      is_uniform(samples_uniformly(s)),
      time_budget_s(s.time_budget_s.value_or(0)),
      seed(sampling_seed(s)),
      aovs(aovs_of(s)),
      shutter_frames(shutter_frames_of(s)),
      clamp_indirect(s.clamp_indirect.value_or(0.0f)),
      find_empty_pixels(options.find_empty_pixels),
      filter(PixelFilter::create(s.filter, s.filter_radius)) {
  check_rules(s);
  driver_settings.bucket_size = s.bucket_size;
  driver_settings.bucket_order = s.bucket_order;
  driver_settings.part = s.part.value_or(FramePart{});
  driver_settings.bisection_axis = s.bisection_axis;
  driver_settings.reconstruction = s.reconstruction;
  driver_settings.cryptomattes = int(parse_cryptomattes(s.cryptomattes).size());
  driver_settings.cryptomatte_levels = s.cryptomatte_levels;
  driver_settings.explained = options.explained;
  driver_settings.keep_tree = options.keep_tree;
  driver_settings.is_extension = options.is_extension;
  driver_settings.plan = options.sample_plan;
  is_uniform ? plan_uniform(s, *this) : plan_adaptive(s, *this);
  integrator = create_integrator(s.integrator, {.max_depth = s.max_depth,
                                                .transparent = s.transparent,
                                                .clamp_indirect = clamp_indirect,
                                                .light_samples = s.light_samples});
  guides_lights = s.environment_sampling == EnvironmentSampling::kGuided && s.max_depth > 0 &&
                  (find_integrator(s.integrator).supports_light_groups ||
                   find_integrator(s.integrator).uses_indirect_guide);
  max_depth = s.max_depth;
  // With a depth of 1 there is no indirect light.
  if (s.max_depth > 1 && find_integrator(s.integrator).uses_indirect_guide) guiding = s.guiding;
  build.show_backfaces = s.show_backfaces;
  build.isa = s.isa;
  build.unread_uv = find_integrator(s.integrator).shows_uv || aovs.contains(Aov::kUv);
  sampler = create_sampler(s.sampler, {streams, std::max(1u, samples_per_pixel), width, height});
  if (options.aovs) aovs = *options.aovs;
}

namespace {

// The survey of indirect light traces 1.5 to 3 paths per pixel of a smaller frame, and a guide from
// so few paths saves little.
constexpr uint64_t kMinGuidedPixels = 16384;

std::shared_ptr<const LightGuide> make_catcher_guide(const Scene& scene) {
  const EnvironmentLight* const light = scene.lights().environment();
  if (!light) return nullptr;
  auto guide = std::make_shared<EnvironmentGuide>(*light);
  guide->set_regions(SkyRegions::single_region());
  return std::make_shared<LightGuide>(LightGuide{.environment = std::move(guide)});
}

}  // namespace

std::unique_ptr<RenderJob> RenderPlan::prepare(const OpenScene& scene, const Camera& camera,
                                               const std::stop_token& stop) const {
  return prepare(scene, camera, scene.parts(), stop);
}

std::unique_ptr<RenderJob> RenderPlan::prepare(const OpenScene& scene, const Camera& camera,
                                               const SceneParts& parts,
                                               const std::stop_token& stop) const {
  Frame whole = frame(scene.scene(), camera, parts, stop, scene.memory());
  whole.shutter_frames = shutter_frames_of(scene.settings());
  return std::make_unique<RenderJob>(std::move(whole), drivers());
}

std::unique_ptr<RenderJob> RenderPlan::prepare_stage(const OpenScene& scene, const Camera& camera,
                                                     const StageOptions& stage) const {
  DriverSettings settings = driver_settings;
  settings.explained = stage.explained;
  Frame part = frame(scene.scene(), camera, {.light_groups = stage.light_groups});
  part.shutter_frames = shutter_frames_of(scene.settings());
  part.crop = stage.crop;
  part.samples_per_pixel = stage.samples_per_pixel;
  part.time_budget_s = 0;
  part.exact_counts =
      is_uniform || find_driver(stage.driver).distribution == SampleDistribution::kUniform;
  return std::make_unique<RenderJob>(std::move(part), driver_factory(stage.driver, settings));
}

Frame RenderPlan::frame(const Scene& scene, const Camera& camera, const SceneParts& parts,
                        const std::stop_token& stop,
                        const std::shared_ptr<MemoryBudget>& memory) const {
  const std::shared_ptr<const LightGuide> light_guide =
      guides_lights ? find_light_guide(scene, camera, width, height, stop) : nullptr;
  const bool too_small = uint64_t(width) * uint64_t(height) < kMinGuidedPixels;
  IndirectSurvey indirect;
  if (guiding == Guiding::kOn || (guiding == Guiding::kAuto && !too_small)) {
    indirect =
        survey_indirect_light({scene, camera, width, height, max_depth, light_guide.get(), memory},
                              guiding == Guiding::kOn, stop);
  }
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
          .time_budget_s = time_budget_s,
          .exact_counts = is_uniform && time_budget_s == 0,
          .clamp_indirect = clamp_indirect,
          .light_groups = parts.light_groups,
          .cryptomattes = parts.cryptomattes,
          .roles = parts.roles,
          .empty_pixels = find_empty_pixels
                              ? EmptyPixels::find(scene, camera, width, height, filter.radius())
                              : nullptr,
          .camera_solids = CameraSolids::find(scene, camera),
          .guide = light_guide,
          .catcher_guide = aovs.contains(Aov::kShadow) ? make_catcher_guide(scene) : nullptr,
          .indirect = std::move(indirect)};
}

size_t RenderPlan::buckets() const {
  const DriverSettings& d = driver_settings;
  return bucket_schedule(crop, d.bucket_size, d.bucket_order, seed).size();
}

int64_t frame_number(const FrameSettings& settings) {
  if (settings.frame) return int64_t(std::floor(*settings.frame));
  return settings.turntable ? settings.turntable->frame.value_or(1) : 0;
}

uint32_t sampling_seed(const FrameSettings& settings) {
  if (settings.static_noise) return settings.seed;
  const auto add = [](uint32_t seed, int64_t number) {
    constexpr uint32_t kFrames = 0xf4a3e5u;  // sets these seeds apart from other hashes
    const auto bits = uint64_t(number);
    seed = hash_combine(hash_combine(seed, kFrames), uint32_t(bits));
    return hash_combine(seed, uint32_t(bits >> 32));
  };
  const int64_t number = frame_number(settings);
  const uint32_t seed = number == 0 ? settings.seed : add(settings.seed, number);
  // A turntable can show a single frame of an animation from all sides. The turntable's frame
  // number then makes the seeds differ.
  const int64_t turned = settings.turntable ? settings.turntable->frame.value_or(number) : number;
  return turned == number ? seed : add(seed, turned);
}

const DriverEntry& driver_of(const FrameSettings& settings) {
  return settings.plan.empty() ? find_driver(settings.driver) : planned_driver_entry();
}

bool samples_uniformly(const FrameSettings& settings) {
  const SampleDistribution distribution = driver_of(settings).distribution;
  return distribution == SampleDistribution::kUniform ||
         (distribution == SampleDistribution::kUniformWithoutThreshold &&
          !settings.noise_threshold);
}

bool is_tiled(const FrameSettings& settings) { return driver_of(settings).tiles; }

std::optional<TimeLimit> time_limit_of(const FrameSettings& settings) {
  const std::optional<double>&limit = settings.time_limit_s, &budget = settings.time_budget_s;
  if (budget && !is_tiled(settings) && *budget <= limit.value_or(*budget)) {
    return TimeLimit{*budget, PixelStop::kTimeBudget};
  }
  if (limit) return TimeLimit{*limit, PixelStop::kTimeLimit};
  return std::nullopt;
}

std::string_view allocation_of(const FrameSettings& settings) {
  if (samples_uniformly(settings) || estimator_of(settings).batch != 0) return "";
  return name_of(error_metric_table(), settings.allocation.value_or(kDefaultAllocation));
}

std::vector<JudgedChannel> judged_channels_of(const FrameSettings& settings) {
  if (settings.judge.empty()) return {};
  if (settings.judge != kJudgeDelivered) return parse_judged(settings.judge);
  std::string list = "RGB";
  if (settings.transparent) list += ",A";
  if (aovs_of(settings).contains(Aov::kShadow)) list += ",shadow";
  if (settings.light_groups) list += ",light.*";
  return parse_judged(list);
}

void set_judged_channels(std::span<const JudgedChannel> channels, FrameSettings& settings) {
  settings.judge = judged_list(channels);
}

AovSet aovs_of(const FrameSettings& settings) {
  AovSet aovs = AovSet::parse(settings.aovs);
  if (settings.denoise) aovs.insert(Aov::kDenoising);
  if (has_catchers(settings)) aovs.insert(Aov::kShadow);
  return aovs;
}

Rect crop_of(const FrameSettings& settings) {
  return settings.crop.value_or(Rect{0, 0, settings.width, settings.height});
}

}  // namespace emberline
