// The rows of the setting table, with the help of each setting.
#include <cmath>
#include <iterator>

#include "integrators/integrator.h"
#include "io/display/working_space.h"
#include "io/exr/writer.h"
#include "renderer/drivers/adaptive/error_estimator.h"
#include "renderer/drivers/adaptive/judged_channels.h"
#include "renderer/drivers/bisection_picture.h"
#include "renderer/drivers/bisection_schedule.h"
#include "renderer/drivers/bucket_schedule.h"
#include "renderer/drivers/driver_table.h"
#include "renderer/engine/half_layers.h"
#include "renderer/engine/render_plan.h"
#include "renderer/engine/setting_kinds.h"
#include "renderer/film/channels.h"
#include "renderer/film/cryptomatte_sums.h"
#include "renderer/film/filter.h"
#include "renderer/scene/embree_isa.h"
#include "samplers/pixel_samples.h"

namespace emberline {
namespace {

using namespace setting_kinds;
using enum SettingGroup;
using H = HelpSection;
using S = FrameSettings;

// In metres. The limit is larger than any scene, but squared distances are still finite in double.
// The precision of the picture is limited only by float rounding in the rebased scene.
constexpr double kMaxDistance = 1e15;
constexpr double kMaxLensScale =
    1e9;  // f-stops may be 1e-9 to 1e9, because scenes may have any scale
constexpr float kMinClamp = 1e-6f, kMaxClamp = 1e9f;
constexpr int kMaxLightSamples = PixelSamples::kAuxiliarySlots + 1;
constexpr double kMinTimeLimit = 0.001, kMaxTimeLimit = 1e9;  // a millisecond to thirty years
constexpr double kMaxTime = 1e6;  // seconds of either sign; at 1e6 s, double resolves 1e-10 s
constexpr double kMaxShutterFrames = 1e6;
constexpr double kMinFps = 1e-3, kMaxFps = 1e6;
constexpr int kMaxPixels = 65536;  // per side
constexpr uint32_t kMaxParts = 65536;
constexpr int kMaxCryptomatteLevels = 64;
constexpr int kMaxTurntableFrame = 999'999'999;
constexpr uint32_t kMaxTurntableCount = 1'000'000;

constexpr NamedValue<EnvironmentSampling> kEnvironmentSamplings[] = {
    {"guided",
     "a short survey decides how light samples are divided among the environment and the kinds of "
     "lights, and which directions of the environment are visible and get samples",
     EnvironmentSampling::kGuided},
    {"light", "light samples depend only on the emitted light", EnvironmentSampling::kByLight}};

constexpr NamedValue<Guiding> kGuidings[] = {
    {"auto",
     "in rooms; a short survey finds out whether the scene is mostly closed and where its indirect "
     "light comes from; frames of fewer than 16384 pixels are not guided",
     Guiding::kAuto},
    {"on", "paths are guided wherever the survey finds a surface that can be", Guiding::kOn},
    {"off", "paths follow the materials only", Guiding::kOff}};

constexpr NamedValue<bool> kBackfaces[] = {
    {"cull", "they are invisible, as glTF requires", false},
    {"show", "they look as if they were double-sided", true}};

constexpr NamedValue<TurntableCenter> kTurntableCenters[] = {
    {"bounds", "the middle of the scene's bounds", TurntableCenter::kBounds},
    {"look-at", "the point of `look-at`, which stays in the middle of the frame",
     TurntableCenter::kLookAt}};

template <auto Member>
Setting point(const std::string& name, const OptionText& help) {
  const std::string expected =
      fmt::format("X,Y,Z with numbers from -{} to {}", kMaxDistance, kMaxDistance);
  return numbers<Member, 3, double>(
      name, kView, "X,Y,Z", ',', expected, help,
      [](const std::array<double, 3>& v) -> std::optional<Vec3d> {
        if (std::ranges::any_of(v, [](double c) { return std::abs(c) > kMaxDistance; })) return {};
        return Vec3d(v[0], v[1], v[2]);
      });
}

Setting size() {
  const auto read = [](FrameSettings& settings, std::string_view text) {
    std::array<int, 2> v;
    if (!parse_numbers(text, 'x', v) ||
        std::ranges::any_of(v, [](int side) { return side < 1 || side > kMaxPixels; })) {
      reject_value("size", text, fmt::format("WxH with 1 to {} pixels per side", kMaxPixels));
    }
    settings.width = v[0];
    settings.height = v[1];
  };
  const auto text = [](const FrameSettings& s) { return fmt::format("{}x{}", s.width, s.height); };
  return {"size",
          kSample,
          "WxH",
          {.section = H::kView,
           .brief = "width and height of the frame in pixels",
           .full = "Set the width and height of the frame in pixels.",
           .example = "--size 1920x1080"},
          read,
          text};
}

Setting crop() {
  return numbers<&FrameSettings::crop, 4, int>(
      "crop", kView, "X0,Y0,X1,Y1", ',', "X0,Y0,X1,Y1 in whole pixels",
      {.section = H::kView,
       .full = "Render only these pixels of the frame. X1 and Y1 are excluded.",
       .example = "--crop 640,0,1280,720"},
      [](const std::array<int, 4>& v) {
        return std::optional(Rect{v[0], v[1], v[2], v[3]});
      });
}

Setting part() {
  return numbers<&FrameSettings::part, 2, uint32_t>(
      "part", kPart, "K/N", '/', fmt::format("K/N with 1 <= K <= N <= {}", kMaxParts),
      {.section = H::kParts,
       .full =
           "Render only every N-th bucket, starting with the K-th. This writes no picture, only "
           "the checkpoint OUTPUT.part-K-of-N.checkpoint; `emberline merge` joins the parts.",
       .example = "--part 3/8"},
      [](const std::array<uint32_t, 2>& v) -> std::optional<FramePart> {
        if (v[0] < 1 || v[0] > v[1] || v[1] > kMaxParts) return {};
        return FramePart{v[0], v[1]};
      });
}

Setting sample_range() {
  return numbers<&FrameSettings::sample_range, 2, uint32_t>(
      "sample-range", kPart, "A-B", '-', fmt::format("A-B with 0 <= A < B <= {}", kMaxSamples),
      {.section = H::kParts,
       .full = "Render only the samples A to B - 1 of each pixel. This writes no picture, only a "
               "checkpoint for `emberline merge`.",
       .example = "--sample-range 0-64"},
      [](const std::array<uint32_t, 2>& v) -> std::optional<SampleSpan> {
        if (v[0] >= v[1] || v[1] > kMaxSamples) return {};
        return SampleSpan{v[0], v[1]};
      });
}

Setting judge() {
  Setting setting = word<&S::judge>(
      "judge", kCounts, "LIST",
      {.section = H::kSamples,
       .full = fmt::format(
           "Choose the channels whose errors decide about samples: RGB, A, light.* and names of "
           "`aov`. A pixel is finished when each of them has met its threshold, which may follow "
           "the name: RGB,A:0.005. Channels without a threshold have that of `noise-threshold`. "
           "The errors of R G B and of layers "
           "of light are measured as displayed, that of Z as a fraction of the depth, all others "
           "in the channel's unit; errors at silhouettes count in proportion to the coverage. {} "
           "stands for RGB, A with `transparent`, shadow with `catcher` or "
           "`catcher-plane`, and light.*, the layers of `light-groups`.",
           kJudgeDelivered),
       .fallback = "RGB",
       .example = "--driver adaptive --noise-threshold 0.01 --judge RGB,shadow:0.02"});
  setting.read = [](FrameSettings& settings, std::string_view text) {
    if (text != kJudgeDelivered) parse_judged(text);
    settings.judge = text;
  };
  return setting;
}

Setting catcher_plane() {
  const auto read = [](FrameSettings& settings, std::string_view text) {
    CatcherPlane plane;
    if (text != "bottom") {
      plane.height = parse_number<double>(text);
      if (!plane.height || std::abs(*plane.height) > kMaxDistance) {
        reject_value("catcher-plane", text,
                     fmt::format("bottom or a number from -{} to {}", kMaxDistance, kMaxDistance));
      }
    }
    settings.catcher_plane = plane;
  };
  return {"catcher-plane",
          kChannels,
          "Y|bottom",
          {.section = H::kOutput,
           .full = "Add a grey floor at this height in metres, and make it a shadow catcher. "
                   "`bottom` is just below the lowest point of the scene at rest. The floor "
                   "extends 100 times as far as the scene.",
           .example = "--catcher-plane bottom --transparent"},
          read,
          member_text<&FrameSettings::catcher_plane>};
}

Setting turntable() {
  const auto read = [](FrameSettings& settings, std::string_view text) {
    const size_t slash = text.find('/');
    const bool single = slash != std::string_view::npos;
    Turntable turn;
    if (single) turn.frame = parse_number<int>(text.substr(0, slash));
    const auto count = parse_number<uint32_t>(single ? text.substr(slash + 1) : text);
    if (!count || *count < 1 || *count > kMaxTurntableCount || single != turn.frame.has_value() ||
        std::abs(turn.frame.value_or(0)) > kMaxTurntableFrame) {
      reject_value("turntable", text,
                   fmt::format("N or K/N with N from 1 to {}", kMaxTurntableCount));
    }
    turn.count = *count;
    settings.turntable = turn;
  };
  return {"turntable",
          kTurn,
          "N|K/N",
          {.section = H::kView,
           .full = "Render N frames (`frames` 1-N) while the camera moves once around a vertical "
                   "axis. K/N renders only frame K. The scene itself stands still unless "
                   "`animation` is given.",
           .example = "--turntable 120 -o turn.####.png"},
          read,
          member_text<&FrameSettings::turntable>};
}

Setting shutter() {
  return numbers<&FrameSettings::shutter, 2, double>(
      "shutter", kLoading, "OPEN,CLOSE", ',',
      fmt::format("OPEN,CLOSE with -{0} <= OPEN <= CLOSE <= {0}", kMaxShutterFrames),
      {.section = H::kScene,
       .brief = "motion blur; 0,0.5 is a shutter of 180 degrees",
       .full = "Open and close the shutter at these times, measured in frames relative to the "
               "frame's time. Objects that move in between are blurred. 0,0.5 is a shutter of 180 "
               "degrees, and -0.25,0.25 is the same, centred on the frame's time.",
       .example = "--time 1 --shutter 0,0.5"},
      [](const std::array<double, 2>& v) -> std::optional<Shutter> {
        if (!(v[0] <= v[1]) || !(v[0] >= -kMaxShutterFrames) || !(v[1] <= kMaxShutterFrames))
          return {};
        return Shutter{v[0], v[1]};
      });
}

Setting sun() {
  return numbers<&FrameSettings::sun, 2, double>(
      "sun", kLight, "ELEVATION,AZIMUTH", ',',
      "ELEVATION,AZIMUTH in degrees, from -90 to 90 and from -360 to 360",
      {.section = H::kLight,
       .brief = "light the scene with a clear sky and the sun, in degrees",
       .full = "Light the scene with a clear sky and the sun. ELEVATION is the sun's angle above "
               "the horizon in degrees. AZIMUTH is its direction: 0 is -Z (north), and 90 is +X "
               "(east). With the sun below the horizon it is twilight, then night.",
       .example = "--sun 30,120"},
      [](const std::array<double, 2>& v) -> std::optional<SunPosition> {
        if (!(std::abs(v[0]) <= 90) || !(std::abs(v[1]) <= 360)) return {};
        return SunPosition{v[0], v[1]};
      });
}

// read() replaces aliases with the names of channels, which rules and files use.
Setting aovs() {
  std::string aliases;
  for (const AovAlias& alias : aov_aliases()) {
    if (alias.name == "lightpath") continue;  // gets its own line below
    aliases += fmt::format("{}{} for {}", aliases.empty() ? "" : ", ", alias.name, alias.list);
  }
  Setting setting = names<&S::aovs>("aov",
                                    {.section = H::kOutput,
                                     .brief = "add channels to the EXR, such as albedo,N,Z",
                                     .full = "Add these channels to the EXR, a comma-separated "
                                             "list. Names from other programs also work: " +
                                             aliases + ".",
                                     .example = "--aov albedo,N,Z"},
                                    aov_table(), nullptr);
  setting.choices.push_back(
      {"lightpath",
       "the six layers by light path, which add up to R G B: direct, indirect, "
       "emission, transmission, reflection and environment"});
  setting.read = [](FrameSettings& settings, std::string_view text) {
    settings.aovs = canonical_aovs(text);
  };
  return setting;
}

// The rows are in the order in which files and reports list them.
std::vector<Setting> edit_settings() {
  return {
      word<&S::edits>(
          "edits", kEdits, "FILE",
          {.section = H::kScene,
           .brief = "apply the edits in this .json file to the scene",
           .full = "Apply the edits in this .json file to the view, lights, environment and "
                   "materials. `camera`, `look-from` and `fov-y` override its view.",
           .example = "--edits look.json"}),
      word<&S::variant>("variant", kEdits, "NAME|INDEX",
                        {.section = H::kScene,
                         .full = "Use the materials of this variant, given by name or index.",
                         .fallback = "the file's default",
                         .example = "--variant 1"}),
  };
}

std::vector<Setting> channel_settings() {
  return {
      aovs(),
      names<&S::cryptomattes>("cryptomatte",
                              {.section = H::kOutput,
                               .full = "Add Cryptomatte layers to the EXR, a comma-separated list. "
                                       "Compositing programs extract mattes by name from them.",
                               .example = "--cryptomatte object,material"},
                              cryptomatte_table(),
                              [](std::string_view list) { parse_cryptomattes(list); }),
      // The default is omitted, because it has no effect without `cryptomatte`.
      omit_default(number<&S::cryptomatte_levels>(
          "cryptomatte-levels", kChannels, 1, kMaxCryptomatteLevels,
          {.section = H::kOutput,
           .full = "Store this many ids per pixel in each Cryptomatte layer. The channel "
                   "dropped.NAME has the coverage of the ids that do not fit.",
           .fallback = "6",
           .example = "--cryptomatte object --cryptomatte-levels 8"})),
      word<&S::catchers>(
          "catcher", kChannels, "NAME|INDEX,...",
          {.section = H::kOutput,
           .full = "Make these nodes, and all nodes below them, shadow catchers: they stand in for "
                   "surfaces of a plate. With `transparent`, they are invisible and alpha has the "
                   "shadows on them, so that the picture can be laid over the plate. The layer "
                   "`shadow` contains the factors by which the shadows darken the plate. Write a "
                   "comma in a name as \\,. `emberline info` lists the nodes.",
           .example = "--catcher floor --transparent"}),
      catcher_plane(),
      word<&S::holdouts>("holdout", kChannels, "NAME|INDEX,...",
                         {.section = H::kOutput,
                          .full = "Make these nodes, and all nodes below them, holdouts: they "
                                  "stand in for objects in a plate, hide what is behind them and "
                                  "have alpha 0. Write a comma in a name as \\,.",
                          .example = "--holdout table"}),
      names<&S::half>("half",
                      {.section = H::kOutput,
                       .full = "Store these layers of the EXR as half floats, a comma-separated "
                               "list. Half floats have eleven significant bits and a range from "
                               "6e-8 to 65504.",
                       .example = "--half RGBA,albedo"},
                      half_layer_table(), [](std::string_view list) { parse_half_layers(list); }),
      choice<&S::exr_compression>("exr-compression", kChannels, "compression",
                                  {.section = H::kOutput,
                                   .full = "Choose the compression of the EXR.",
                                   .example = "--exr-compression dwab"},
                                  exr_compression_table()),
      choice<&S::exr_parts>("exr-parts", kChannels, "parts",
                            {.section = H::kOutput,
                             .full = "Choose how the layers are divided into parts of the EXR.",
                             .example = "--exr-parts layers"},
                            exr_parts_table()),
      word<&S::plan>(
          "plan", kPart, "FILE",
          {.section = H::kParts,
           .full = "Give each pixel the number of samples that `emberline plan` wrote to this "
                   "file. Crops and parts of the frame then have the pixels of the whole frame. "
                   "The scene and all settings that affect samples must be as they were when the "
                   "plan was made.",
           .example = "--driver adaptive --plan frame.plan --part 3/8"}),
      part(),
      sample_range(),
      turntable(),
      omit_default(choice<&S::turntable_center>(
          "turntable-center", kTurn, "centre",
          {.section = H::kView,
           .full = "Choose the point that the axis of `turntable` goes through.",
           .fallback = "bounds",
           .example = "--look-from 3,2,5 --look-at 0,1,0 --turntable-center look-at"},
          std::span<const NamedValue<TurntableCenter>>(kTurntableCenters))),
      flag<&S::light_groups>(
          "light-groups", kChannels,
          {.section = H::kOutput,
           .full = "Add a layer light.NAME to the EXR for each light, each emissive material and "
                   "the environment. The layers add up to R G B, so that lights can be changed "
                   "in compositing."}),
      flag<&S::denoise>(
          "denoise", kChannels,
          {.section = H::kOutput,
           .brief = "also write a denoised picture",
           .full = "Also write a denoised picture. The EXR gets denoised.{R,G,B} in addition to R "
                   "G B, and denoised.error, an estimate of the remaining error. .png and .jpg "
                   "files show the denoised picture. This uses two sample streams and adds the "
                   "channels of `aov` denoising."}),
  };
}

std::vector<Setting> count_settings() {
  return {
      named<&S::driver>("driver", kCounts, "driver",
                        {.section = H::kSamples,
                         .brief = "rendering order: bucket, bisection or adaptive",
                         .full = "Choose how samples are distributed over the frame and time.",
                         .example = "--driver adaptive"},
                        driver_table()),
      named<&S::sampler>("sampler", kCounts, "sampler",
                         {.section = H::kSamples,
                          .full = "Choose the sequence that samples are taken from.",
                          .example = "--sampler blue_noise"},
                         sampler_table()),
      number<&S::streams>("streams", kCounts, 1, 2,
                          {.section = H::kSamples,
                           .full = "Take the samples of each pixel from one or two independent "
                                   "streams. Two streams give two independent half images, whose "
                                   "difference measures the noise.",
                           .fallback = "1, or the number that the estimator needs"}),
      number<&S::spp>("spp", kCounts, 1u, kMaxSamples,
                      {.section = H::kSamples,
                       .brief = "samples per pixel; adaptive sampling takes this average [64]",
                       .full = "Take this many samples per pixel. Adaptive sampling takes this "
                               "many on average.",
                       .fallback = "64, or no limit if a threshold or `max-spp` is given",
                       .example = "--spp 256"}),
      number<&S::noise_threshold>(
          "noise-threshold", kCounts, 1e-6f, 1.0f,
          {.section = H::kSamples,
           .brief = "finish a pixel when its error is this small, such as 0.01",
           .full = "Finish a pixel when its expected RMS error in the displayed picture (sRGB, 0 "
                   "to 1) is at most this. 0.02 leaves visible noise, 0.005 hardly any, and 0.002 "
                   "is half of an 8-bit step. 2% means 0.02.",
           .fallback = "none",
           .example = "--driver adaptive --noise-threshold 0.01"},
          parse_share),
      number<&S::min_spp>(
          "min-spp", kCounts, 1u, kMaxSamples,
          {.section = H::kSamples,
           .full = "Take at least this many samples before a pixel may be finished.",
           .fallback = "the estimator's minimum"}),
      number<&S::max_spp>(
          "max-spp", kCounts, 1u, kMaxSamples,
          {.section = H::kSamples,
           .full = "Take at most this many samples of any pixel.",
           .fallback = "4096 if there is a threshold and neither `spp` nor `time-budget`"}),
      named<&S::estimator>("estimator", kCounts, "estimator",
                           {.section = H::kSamples,
                            .full = "Choose how adaptive sampling estimates the error of a pixel.",
                            .fallback = std::string(kDefaultEstimator)},
                           estimator_table()),
      choice<&S::allocation>(
          "allocation", kCounts, "allocation",
          {.section = H::kSamples,
           .full = "Choose which error adaptive sampling reduces as fast as possible.",
           .fallback = std::string(name_of(error_metric_table(), kDefaultAllocation))},
          error_metric_table()),
      judge(),
      flag<&S::unbiased>(
          "unbiased", kCounts,
          {.section = H::kSamples,
           .full = "Combine the rounds of adaptive sampling with weights that do not "
                   "depend on the samples. This removes the bias of adaptive "
                   "stopping and leaves more noise."}),
      number<&S::time_limit_s>(
          "time-limit", kCounts, kMinTimeLimit, kMaxTimeLimit,
          {.section = H::kLimits,
           .brief = "stop after this many seconds and write the unfinished picture",
           .full = "Stop rendering after this many seconds and write the unfinished picture. With "
                   "`driver` bucket, pixels that it has not reached stay black.",
           .fallback = "none",
           .example = "--driver adaptive --time-limit 60"}),
      number<&S::time_budget_s>(
          "time-budget", kCounts, kMinTimeLimit, kMaxTimeLimit,
          {.section = H::kLimits,
           .brief = "take as many samples as fit into this many seconds of rendering",
           .full =
               "Take as many samples as fit into this many seconds of rendering. The pace of the "
               "first samples decides how many, and is checked twice. Every pixel gets samples, "
               "with every driver. The picture depends on the speed of the machine; to repeat "
               "it, give its EXR to `plan`.",
           .fallback = "none",
           .example = "--driver adaptive --time-budget 60"}),
  };
}

std::vector<Setting> sample_settings() {
  return {
      named<&S::integrator>("integrator", kSample, "integrator",
                            {.section = H::kSamples, .full = "Choose what each sample computes."},
                            integrator_table()),
      number<&S::max_depth>("max-depth", kSample, 0, 100000,
                            {.section = H::kSamples,
                             .brief = "longest light path; 1 is direct light only",
                             .full = "Follow light paths for at most this many scattering events. "
                                     "1 is direct light only.",
                             .example = "--max-depth 4"}),
      omit_default(number<&S::light_samples>(
          "light-samples", kSample, 1, kMaxLightSamples,
          {.section = H::kSamples,
           .full = "Take this many light samples at visible surfaces, including those seen in "
                   "mirrors or through smooth glass.",
           .fallback = "1"})),
      number<&S::clamp_indirect>(
          "clamp-indirect", kSample, kMinClamp, kMaxClamp,
          {.section = H::kSamples,
           .brief = "limit indirect light to this brightness, for fewer fireflies",
           .full = "Scale down indirect light that would add more than this to a sample. This "
                   "removes fireflies and some of the light; `aov` clamped records the loss.",
           .fallback = "no clamping",
           .example = "--clamp-indirect 10 --aov clamped"}),
      named<&S::filter>("filter", kSample, "filter",
                        {.section = H::kSamples, .full = "Choose the pixel filter."},
                        filter_table()),
      number<&S::filter_radius>("filter-radius", kSample, 0.01f, PixelFilter::kMaxRadius,
                                {.section = H::kSamples,
                                 .full = "Set the radius of the pixel filter in pixels.",
                                 .fallback = "the filter's default"}),
      number<&S::seed>(
          "seed", kSeed, 0u, 0xffffffffu,
          {.section = H::kSamples,
           .full = "Set the seed of the random numbers. Different seeds give different noise."}),
      flag<&S::static_noise>(
          "static-noise", kSample,
          {.section = H::kSamples,
           .full = "Give all frames of an animation or a turntable the same random numbers. By "
                   "default each frame has noise of its own."}),
      number<&S::bucket_size>(
          "bucket-size", kSchedule, 1, kMaxBucketSize,
          {.section = H::kSamples, .full = "Set the width and height of a bucket in pixels."}),
      choice<&S::bucket_order>(
          "bucket-order", kSchedule, "order",
          {.section = H::kSamples,
           .full = "Choose the order in which buckets are rendered. A frame with `time-budget` "
                   "has an order of its own."},
          bucket_order_table()),
      choice<&S::bisection_axis>(
          "bisection-axis", kSchedule, "axis",
          {.section = H::kSamples, .full = "Choose how `driver` bisection divides the frame."},
          bisection_axis_table()),
      choice<&S::reconstruction>(
          "reconstruction", kSchedule, "reconstruction",
          {.section = H::kSamples,
           .full = "Choose how progressive drivers fill pixels that have no sample yet."},
          reconstruction_table()),
  };
}

std::vector<Setting> view_settings() {
  return {
      size(),
      crop(),
      word<&S::camera>("camera", kView, "NAME|INDEX",
                       {.section = H::kView,
                        .brief = "use this camera of the file",
                        .full = "Use this camera of the file, given by its name, the name of its "
                                "node, or its index.",
                        .fallback = "the first",
                        .example = "--camera 1"}),
      point<&S::look_from>("look-from",
                           {.section = H::kView,
                            .brief = "place the camera at this point",
                            .full = "Place the camera at this point, instead of using one of the "
                                    "file's cameras. Coordinates are in metres.",
                            .example = "--look-from 3,2,5 --look-at 0,1,0"}),
      point<&S::look_at>("look-at",
                         {.section = H::kView,
                          .brief = "point the camera at this point",
                          .full = "Point the camera at this point. Coordinates are in metres.",
                          .example = "--look-from 3,2,5 --look-at 0,1,0"}),
      number<&S::fov_y>("fov-y", kView, 0.05, 179.9,
                        {.section = H::kView,
                         .full = "Set the vertical field of view in degrees.",
                         .fallback = "the camera's, or 40",
                         .example = "--fov-y 35"}),
      number<&S::f_stop>("f-stop", kView, 1.0 / kMaxLensScale, kMaxLensScale,
                         {.section = H::kView,
                          .full = "Blur what is out of focus, as a lens with this f-number does on "
                                  "film that is 24 mm high.",
                          .fallback = "a pinhole, with everything in focus",
                          .example = "--f-stop 2.8 --focus-distance 4"}),
      number<&S::focus_distance>("focus-distance", kView, 1.0 / kMaxDistance, kMaxDistance,
                                 {.section = H::kView,
                                  .full = "Focus at this distance along the view, in metres.",
                                  .fallback = "the distance of `look-at`",
                                  .example = "--f-stop 2.8 --focus-distance 4"}),
      flag<&S::panorama>(
          "panorama", kView,
          {.section = H::kView,
           .full = "Render all directions around the camera as a latitude-longitude map, which "
                   "`env` can read. The frame should be twice as wide as it is high.",
           .example = "--panorama --size 2048x1024"}),
  };
}

std::vector<Setting> light_settings() {
  return {
      word<&S::environment>(
          "env", kLight, "FILE",
          {.section = H::kLight,
           .brief = "light the scene with this panorama: .hdr, .exr",
           .full = "Light the scene with this latitude-longitude environment map: .hdr, .exr or "
                   "another picture.",
           .example = "--env sky.hdr"}),
      sun(),
      number<&S::environment_strength>("env-strength", kLight, 0.0f, 1e9f,
                                       {.section = H::kLight,
                                        .full = "Multiply the environment's light by this factor.",
                                        .example = "--env sky.hdr --env-strength 2"}),
      number<&S::environment_rotation>(
          "env-rotation", kLight, -36000.0f, 36000.0f,
          {.section = H::kLight,
           .full = "Rotate the environment about the vertical axis by this many degrees. 90 moves "
                   "what was at +X to -Z.",
           .example = "--env sky.hdr --env-rotation 90"}),
      omit_default(choice<&S::environment_sampling>(
          "env-sampling", kSample, "sampling",
          {.section = H::kLight, .full = "Choose where light samples go.", .fallback = "guided"},
          std::span<const NamedValue<EnvironmentSampling>>(kEnvironmentSamplings))),
      omit_default(
          choice<&S::guiding>("guiding", kSample, "guiding",
                              {.section = H::kLight,
                               .full = "Choose whether paths are guided to indirect light.",
                               .fallback = "auto"},
                              std::span<const NamedValue<Guiding>>(kGuidings))),
      flag<&S::transparent>(
          "transparent", kSample,
          {.section = H::kLight,
           .brief = "make the background transparent",
           .full = "Hide the environment from the camera, so that the background is transparent. "
                   "It still lights the scene."}),
      omit_default(choice<&S::working_space>(
          "working-space", kLight, "space",
          {.section = H::kOutput,
           .full = "Choose the primaries in which the picture is rendered and written.",
           .fallback = "rec709"},
          working_space_table())),
      choice<&S::show_backfaces>(
          "backfaces", kLight, "treatment",
          {.section = H::kScene,
           .full = "Choose what happens to single-sided faces that are seen from behind."},
          std::span<const NamedValue<bool>>(kBackfaces)),
  };
}

std::vector<Setting> loading_settings() {
  return {
      word<&S::animation>("animation", kLoading, "NAME|INDEX|all",
                          {.section = H::kScene,
                           .brief = "pose the scene with this animation",
                           .full = "Pose the scene with this animation, given by name or index, or "
                                   "with all of them.",
                           .fallback = "the first if a time is given, else none",
                           .example = "--animation 0 --time 1.5"}),
      number<&S::time>("time", kLoading, -kMaxTime, kMaxTime,
                       {.section = H::kScene,
                        .brief = "seconds into the animation",
                        .full = "Show the scene at this time of the animation, in seconds. Beyond "
                                "the ends of the animation the scene stands still.",
                        .fallback = "0",
                        .example = "--time 1.5"}),
      number<&S::frame>("frame", kLoading, -kMaxTime * kMaxFps, kMaxTime * kMaxFps,
                        {.section = H::kScene,
                         .full = "Show the scene at this frame of the animation. Fractions are "
                                 "allowed.",
                         .example = "--frame 36 --fps 24"}),
      // The default is omitted, because it has no effect without an animation.
      omit_default(number<&S::fps>("fps", kLoading, kMinFps, kMaxFps,
                                   {.section = H::kScene,
                                    .full = "Set the frames per second, for `frame`, `frames` and "
                                            "`shutter`.",
                                    .fallback = "24"})),
      shutter(),
      flag<&S::lenient>(
          "lenient", kLoading,
          {.section = H::kScene,
           .full = "Accept damaged input, with warnings: use truncated images, and replace images "
                   "that cannot be decoded and impossible material values."}),
      choice<&S::isa>("isa", kSample, "instruction set",
                      {.section = H::kLimits,
                       .full = "Trace rays with Embree's kernels for this instruction set, so that "
                               "all machines of a farm give the same bits.",
                       .fallback = "the widest that the machine supports"},
                      embree_isa_table()),
      word<&S::resource_root>(
          "resource-root", kLoading, "DIR",
          {.section = H::kScene,
           .full = "Allow the scene to read files in this folder and its subfolders.",
           .fallback = "the scene's folder"}),
  };
}

std::vector<Setting> make_table() {
  std::vector<Setting> table;
  for (const auto& make_rows : {edit_settings, channel_settings, count_settings, sample_settings,
                                view_settings, light_settings, loading_settings}) {
    std::ranges::move(make_rows(), std::back_inserter(table));
  }
  return table;
}

}  // namespace

std::span<const Setting> setting_table() {
  static const std::vector<Setting> table = make_table();
  return table;
}

}  // namespace emberline
