#include "renderer/engine/setting_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>
#include <type_traits>

#include "integrators/integrator.h"
#include "io/display/working_space.h"
#include "io/exr/writer.h"
#include "io/json/input.h"
#include "renderer/core/errors.h"
#include "renderer/core/names.h"
#include "renderer/core/option_values.h"
#include "renderer/core/shortened.h"
#include "renderer/description/scene_edits.h"
#include "renderer/drivers/adaptive/error_estimator.h"
#include "renderer/drivers/bisection_picture.h"
#include "renderer/drivers/bisection_schedule.h"
#include "renderer/drivers/bucket_schedule.h"
#include "renderer/drivers/driver_table.h"
#include "renderer/engine/half_layers.h"
#include "renderer/film/channels.h"
#include "renderer/film/cryptomatte_sums.h"
#include "renderer/film/filter.h"
#include "renderer/scene/embree_isa.h"
#include "samplers/pixel_samples.h"

namespace emberline {
namespace {

using enum SettingGroup;

// In metres. Beyond any scene, yet squared distances stay finite in double, and only float rounding
// of the rebased scene limits the picture.
constexpr double kFarthest = 1e15;
constexpr double kMostOfLens =
    1e9;  // f-stops, as a ratio either way, since scenes come at any scale
constexpr float kLeastClamp = 1e-6f, kMostClamp = 1e9f;
constexpr int kMostLightSamples = PixelSamples::kBesideSlots + 1;
constexpr double kLeastTimeLimit = 0.001, kMostTimeLimit = 1e9;  // a millisecond to thirty years
constexpr double kLatest = 1e6;    // seconds, either sign: ten days with a precision of 1e-10 s
constexpr double kMostOpen = 1e6;  // frames
constexpr double kLeastFps = 1e-3, kMostFps = 1e6;
constexpr int kMostPixels = 65536;  // per side
constexpr uint32_t kMostParts = 65536;
constexpr int kMostCryptomatteLevels = 64;
constexpr int kLastOfTurn = 999'999'999;
constexpr uint32_t kMostOfTurn = 1'000'000;

std::string text_of(const std::string& value) { return value; }
std::string text_of(bool value) { return value ? "yes" : ""; }
template <typename T>
requires std::is_arithmetic_v<T> std::string text_of(T value) {
  return fmt::format("{}", value);  // the shortest text that gives the same bits
}
std::string text_of(const Vec3d& v) { return fmt::format("{},{},{}", v.x, v.y, v.z); }
std::string text_of(const FramePart& p) { return fmt::format("{}/{}", p.index, p.count); }
std::string text_of(const SampleSpan& s) { return fmt::format("{}-{}", s.first, s.end); }
std::string text_of(const Shutter& s) { return fmt::format("{},{}", s.open, s.close); }
std::string text_of(const SunPosition& s) { return fmt::format("{},{}", s.elevation, s.azimuth); }
std::string text_of(const Turntable& t) {
  return t.frame ? fmt::format("{}/{}", *t.frame, t.count) : fmt::format("{}", t.count);
}
std::string text_of(const Rect& r) { return fmt::format("{},{},{},{}", r.x0, r.y0, r.x1, r.y1); }
template <typename T>
std::string text_of(const std::optional<T>& value) {
  return value ? text_of(*value) : std::string();
}

[[noreturn]] void refuse(const std::string& name, std::string_view text, const std::string& what) {
  throw UsageError(fmt::format("`{}`: '{}' is not {}", name, shortened(text), what));
}

template <auto Member>
std::string member_text(const FrameSettings& settings) {
  return text_of(settings.*Member);
}

// A number, or an optional number, in [least, most].
template <auto Member, typename T>
Setting number(const std::string& name, SettingGroup group, T least, T most,
               const std::string& help) {
  const auto read = [=](FrameSettings& settings, std::string_view text) {
    const std::optional<T> value = parse_number<T>(text);
    if (!value || *value < least || *value > most) {
      refuse(name, text,
             fmt::format("a {} from {} to {}", std::is_integral_v<T> ? "whole number" : "number",
                         least, most));
    }
    settings.*Member = *value;
  };
  return {name, group, fmt::format("{}..{}", least, most), help, read, member_text<Member>};
}

template <typename Table>
std::vector<SettingChoice> choices_of(const Table& table) {
  std::vector<SettingChoice> choices;
  for (const auto& entry : table) {
    choices.push_back({std::string(entry.name), std::string(entry.summary)});
  }
  return choices;
}

// A setting whose value is a name in `table`.
template <auto Member, typename Table>
Setting named(const std::string& name, SettingGroup group, const std::string& kind,
              const std::string& help, const Table& table) {
  const auto read = [=](FrameSettings& settings, std::string_view text) {
    settings.*Member = find_named(table, fmt::format("`{}`", name), kind, text).name;
  };
  return {name, group, "NAME", help, read, member_text<Member>, choices_of(table)};
}

// A setting whose value is a value of `table`; optional members may be unset.
template <auto Member, typename T>
Setting choice(const std::string& name, SettingGroup group, const std::string& kind,
               const std::string& help, std::span<const NamedValue<T>> table) {
  const auto read = [=](FrameSettings& settings, std::string_view text) {
    settings.*Member = find_named(table, fmt::format("`{}`", name), kind, text).value;
  };
  const auto text = [=](const FrameSettings& settings) {
    const std::optional<T> value = settings.*Member;
    return std::string(value ? name_of(table, *value) : "");
  };
  return {name, group, "NAME", help, read, text, choices_of(table)};
}

template <auto Member>
Setting word(const std::string& name, SettingGroup group, const std::string& type,
             const std::string& help) {
  const bool file = type == "FILE" || type == "DIR";
  const auto read = [](FrameSettings& settings, std::string_view text) { settings.*Member = text; };
  return {name, group, type, help, read, member_text<Member>, {}, file};
}

template <auto Member>
Setting flag(const std::string& name, SettingGroup group, const std::string& help) {
  const auto read = [=](FrameSettings& settings, std::string_view text) {
    if (text != "yes" && text != "no") refuse(name, text, "yes or no");
    settings.*Member = text == "yes";
  };
  return {name, group, "", help, read, member_text<Member>};
}

// `N` numbers separated by `separator`; `make` turns them into the member's value or returns
// nullopt, which is reported as not `expected`.
template <auto Member, size_t N, typename T, typename Make>
Setting numbers(const std::string& name, SettingGroup group, const std::string& type,
                char separator, const std::string& expected, const std::string& help,
                const Make& make) {
  const auto read = [=](FrameSettings& settings, std::string_view text) {
    std::array<T, N> values;
    if (!parse_numbers(text, separator, values)) refuse(name, text, expected);
    const auto value = make(values);
    if (!value) refuse(name, text, expected);
    settings.*Member = *value;
  };
  return {name, group, type, help, read, member_text<Member>};
}

template <auto Member>
Setting point(const std::string& name, const std::string& help) {
  const std::string expected =
      fmt::format("X,Y,Z with numbers from -{} to {}", kFarthest, kFarthest);
  return numbers<Member, 3, double>(
      name, kView, "X,Y,Z", ',', expected, help,
      [](const std::array<double, 3>& v) -> std::optional<Vec3d> {
        if (std::ranges::any_of(v, [](double c) { return std::abs(c) > kFarthest; })) return {};
        return Vec3d(v[0], v[1], v[2]);
      });
}

Setting size() {
  const auto read = [](FrameSettings& settings, std::string_view text) {
    std::array<int, 2> v;
    if (!parse_numbers(text, 'x', v) ||
        std::ranges::any_of(v, [](int side) { return side < 1 || side > kMostPixels; })) {
      refuse("size", text, fmt::format("WxH with 1 to {} pixels each", kMostPixels));
    }
    settings.width = v[0];
    settings.height = v[1];
  };
  const auto text = [](const FrameSettings& s) { return fmt::format("{}x{}", s.width, s.height); };
  return {"size", kSample, "WxH", "frame in pixels", read, text};
}

Setting crop() {
  return numbers<&FrameSettings::crop, 4, int>(
      "crop", kView, "X0,Y0,X1,Y1", ',', "X0,Y0,X1,Y1 in whole pixels",
      "render these pixels only, X1 and Y1 excluded", [](const std::array<int, 4>& v) {
        return std::optional(Rect{v[0], v[1], v[2], v[3]});
      });
}

Setting part() {
  return numbers<&FrameSettings::part, 2, uint32_t>(
      "part", kPart, "K/N", '/', fmt::format("K/N with 1 <= K <= N <= {}", kMostParts),
      "every N-th bucket, from the K-th on. Nothing is written but the checkpoint "
      "OUTPUT.part-K-of-N.checkpoint, for `emberline merge`",
      [](const std::array<uint32_t, 2>& v) -> std::optional<FramePart> {
        if (v[0] < 1 || v[0] > v[1] || v[1] > kMostParts) return {};
        return FramePart{v[0], v[1]};
      });
}

Setting sample_range() {
  return numbers<&FrameSettings::sample_range, 2, uint32_t>(
      "sample-range", kPart, "A-B", '-', fmt::format("A-B with 0 <= A < B <= {}", kMaxSamples),
      "samples A to B - 1 of each pixel alone, likewise for `emberline merge`",
      [](const std::array<uint32_t, 2>& v) -> std::optional<SampleSpan> {
        if (v[0] >= v[1] || v[1] > kMaxSamples) return {};
        return SampleSpan{v[0], v[1]};
      });
}

Setting turntable() {
  const auto read = [](FrameSettings& settings, std::string_view text) {
    const size_t slash = text.find('/');
    const bool single = slash != std::string_view::npos;
    Turntable turn;
    if (single) turn.frame = parse_number<int>(text.substr(0, slash));
    const auto count = parse_number<uint32_t>(single ? text.substr(slash + 1) : text);
    if (!count || *count < 1 || *count > kMostOfTurn || single != turn.frame.has_value() ||
        std::abs(turn.frame.value_or(0)) > kLastOfTurn) {
      refuse("turntable", text,
             fmt::format("N or K/N with a turn of N frames from 1 to {}", kMostOfTurn));
    }
    turn.count = *count;
    settings.turntable = turn;
  };
  return {"turntable",
          kTurn,
          "N|K/N",
          "N frames (`frames` 1-N) with the camera once round the scene, about the vertical axis "
          "through its centre; K/N: frame K of them. The scene stands still, but for `animation`",
          read,
          member_text<&FrameSettings::turntable>};
}

Setting shutter() {
  return numbers<&FrameSettings::shutter, 2, double>(
      "shutter", kLoading, "OPEN,CLOSE", ',',
      fmt::format("OPEN,CLOSE with -{0} <= OPEN <= CLOSE <= {0}", kMostOpen),
      "when the shutter opens and closes, in frames from the frame's time on; what moves meanwhile "
      "is blurred. 0,0.5 is a shutter of 180 degrees, -0.25,0.25 the same about the frame's time",
      [](const std::array<double, 2>& v) -> std::optional<Shutter> {
        if (!(v[0] <= v[1]) || !(v[0] >= -kMostOpen) || !(v[1] <= kMostOpen)) return {};
        return Shutter{v[0], v[1]};
      });
}

Setting sun() {
  return numbers<&FrameSettings::sun, 2, double>(
      "sun", kLight, "ELEVATION,AZIMUTH", ',',
      "ELEVATION,AZIMUTH with degrees from -90 to 90 and from -360 to 360",
      "a clear sky with the sun so many degrees above the horizon, and from -Z towards +X (north "
      "and east). Below the horizon it is twilight, then night",
      [](const std::array<double, 2>& v) -> std::optional<SunPosition> {
        if (!(std::abs(v[0]) <= 90) || !(std::abs(v[1]) <= 360)) return {};
        return SunPosition{v[0], v[1]};
      });
}

// A list of names in `table`; `check` throws for any other name.
template <auto Member, typename Table>
Setting names(const std::string& name, const std::string& help, const Table& table,
              void (*check)(std::string_view)) {
  const auto read = [=](FrameSettings& settings, std::string_view text) {
    check(text);
    settings.*Member = text;
  };
  return {name, kChannels, "LIST", help, read, member_text<Member>, choices_of(table)};
}

// Omits the setting's text while it equals the default.
Setting unless_default(Setting setting) {
  setting.text = [text = setting.text](const FrameSettings& s) {
    std::string said = text(s);
    return said == text(FrameSettings()) ? std::string() : said;
  };
  return setting;
}

using S = FrameSettings;

constexpr NamedValue<EnvironmentSampling> kEnvironmentSamplings[] = {
    {"guided",
     "to the kinds of light that a short survey saw arrive; of the environment, to what is seen",
     EnvironmentSampling::kGuided},
    {"light", "by its light alone", EnvironmentSampling::kByLight}};

constexpr NamedValue<bool> kBackfaces[] = {{"cull", "they are not there, as glTF says", false},
                                           {"show", "as if they were double-sided", true}};

// The rows, in help order.
std::vector<Setting> edit_settings() {
  return {
      word<&S::edits>("edits", kEdits, "FILE",
                      "change view, lights, environment and materials as this .json file says; its "
                      "view gives way to `camera`, `look-from` and `fov-y`"),
      word<&S::variant>("variant", kEdits, "NAME|INDEX",
                        "materials of this variant, by name or index [the file's default]"),
  };
}

std::vector<Setting> channel_settings() {
  return {
      names<&S::aovs>("aov", "further EXR channels, a list", aov_table(),
                      [](std::string_view list) { AovSet::parse(list); }),
      names<&S::cryptomattes>(
          "cryptomatte", "layers of the EXR that compositors cut mattes by name from, a list",
          cryptomatte_table(), [](std::string_view list) { parse_cryptomattes(list); }),
      // Meaningless without `cryptomatte`.
      unless_default(number<&S::cryptomatte_levels>(
          "cryptomatte-levels", kChannels, 1, kMostCryptomatteLevels,
          "how many of them a pixel can show; what is beyond is counted in dropped.NAME [6]")),
      word<&S::catchers>(
          "catcher", kChannels, "NAME|INDEX,...",
          "nodes that stand for surfaces of a plate: the layer `shadow` is what the plate is to be "
          "multiplied by, and with `transparent` they are seen as alpha where they are in shadow, "
          "and not else. With all below them; \\, is a comma in a name"),
      word<&S::holdouts>("holdout", kChannels, "NAME|INDEX,...",
                         "nodes that stand for things in a plate: they hide what is behind them "
                         "and leave alpha 0. With all below them"),
      names<&S::half>("half",
                      "layers of the EXR in half floats, eleven bits from 6e-8 to 65504, a list",
                      half_layer_table(), [](std::string_view list) { parse_half_layers(list); }),
      choice<&S::exr_compression>("exr-compression", kChannels, "compression",
                                  "how the EXR is compressed", exr_compression_table()),
      choice<&S::exr_parts>("exr-parts", kChannels, "parts", "how the EXR is divided",
                            exr_parts_table()),
      part(),
      sample_range(),
      turntable(),
      flag<&S::light_groups>(
          "light-groups", kChannels,
          "a layer light.NAME of the EXR for each light, emissive material and the environment: "
          "what it gives alone. They add up to R G B"),
      flag<&S::denoise>(
          "denoise", kChannels,
          "a clean picture of the samples as well: denoised.{R,G,B} of the EXR beside R G B, with "
          "denoised.error, what is expected to be wrong with it still; .png and .jpg show it. "
          "Takes two streams, and the channels of `aov` denoising"),
  };
}

std::vector<Setting> count_settings() {
  return {
      named<&S::driver>("driver", kCounts, "driver", "frame driver", driver_table()),
      named<&S::sampler>("sampler", kCounts, "sampler", "sampler", sampler_table()),
      number<&S::streams>("streams", kCounts, 1, 2,
                          "independent sample streams per pixel: 1, or 2 for honest half images "
                          "[1, or what the estimator needs]"),
      number<&S::spp>("spp", kCounts, 1u, kMaxSamples,
                      "samples per pixel; with adaptive sampling on average [64, or no limit where "
                      "a threshold or `max-spp` is given]"),
      number<&S::noise_threshold>(
          "noise-threshold", kCounts, 1e-6f, 1.0f,
          "a pixel is finished when its expected RMS error in the displayed picture (0 to 1, sRGB) "
          "is at most this: 0.02 shows noise, 0.005 hardly any, 0.002 is half a step of 8 bits"),
      number<&S::min_spp>("min-spp", kCounts, 1u, kMaxSamples,
                          "samples before a pixel may be finished [the estimator's]"),
      number<&S::max_spp>("max-spp", kCounts, 1u, kMaxSamples,
                          "most samples of any pixel [4096 with a threshold and no `spp`]"),
      named<&S::estimator>("estimator", kCounts, "estimator",
                           fmt::format("error estimator [{}]", kDefaultEstimator),
                           estimator_table()),
      choice<&S::allocation>("allocation", kCounts, "allocation",
                             fmt::format("error to be least for the time spent [{}]",
                                         name_of(error_metric_table(), kDefaultAllocation)),
                             error_metric_table()),
      flag<&S::unbiased>(
          "unbiased", kCounts,
          "weigh rounds by plan, not by luck: no bias from adaptive stopping, more noise"),
      number<&S::time_limit_s>(
          "time-limit", kCounts, kLeastTimeLimit, kMostTimeLimit,
          "stop rendering after so many seconds and write what there is [none]"),
  };
}

std::vector<Setting> sample_settings() {
  return {
      named<&S::integrator>("integrator", kSample, "integrator", "integrator", integrator_table()),
      number<&S::max_depth>("max-depth", kSample, 0, 100000,
                            "scattering events; 1 is direct light only"),
      unless_default(number<&S::light_samples>(
          "light-samples", kSample, 1, kMostLightSamples,
          "samples of the lights at what is seen, also in mirrors and through smooth glass [1]")),
      number<&S::clamp_indirect>(
          "clamp-indirect", kSample, kLeastClamp, kMostClamp,
          "scale light down that comes by way of more than the surface seen, where it adds more "
          "than this to a sample: less sparkle, and less light. `aov` clamped shows what is lost "
          "[nothing is clamped]"),
      named<&S::filter>("filter", kSample, "filter", "pixel filter", filter_table()),
      number<&S::filter_radius>("filter-radius", kSample, 0.01f, PixelFilter::kMaxRadius,
                                "in pixels [the filter's]"),
      number<&S::seed>("seed", kSeed, 0u, 0xffffffffu, "another seed, another noise"),
      number<&S::bucket_size>("bucket-size", kSchedule, 1, kMostBucketSize, "in pixels"),
      choice<&S::bucket_order>("bucket-order", kSchedule, "order", "order of the buckets",
                               bucket_order_table()),
      choice<&S::bisection_axis>("bisection-axis", kSchedule, "axis",
                                 "what `driver` bisection halves", bisection_axis_table()),
      choice<&S::reconstruction>("reconstruction", kSchedule, "reconstruction",
                                 "what pixels without samples show, of progressive drivers",
                                 reconstruction_table()),
  };
}

std::vector<Setting> view_settings() {
  return {
      size(),
      crop(),
      word<&S::camera>("camera", kView, "NAME|INDEX",
                       "camera of the file, by its name, its node's or its index [the first]"),
      point<&S::look_from>("look-from", "view from here instead"),
      point<&S::look_at>("look-at", "towards this point"),
      number<&S::fov_y>("fov-y", kView, 0.05, 179.9,
                        "vertical field of view in degrees [the camera's, or 40]"),
      number<&S::f_stop>("f-stop", kView, 1.0 / kMostOfLens, kMostOfLens,
                         "f-number of a lens, for film 24 mm high [a pinhole: all is sharp]"),
      number<&S::focus_distance>("focus-distance", kView, 1.0 / kFarthest, kFarthest,
                                 "metres along the view to what is sharp [that of `look-at`]"),
      flag<&S::panorama>(
          "panorama", kView,
          "all that is seen from the camera's place, as a latitude-longitude map that "
          "`env` takes; best twice as wide as high"),
  };
}

std::vector<Setting> light_settings() {
  return {
      word<&S::environment>("env", kLight, "FILE",
                            "latitude-longitude environment map: .hdr, .exr or another picture"),
      sun(),
      number<&S::environment_strength>("env-strength", kLight, 0.0f, 1e9f,
                                       "multiplies the environment"),
      number<&S::environment_rotation>("env-rotation", kLight, -36000.0f, 36000.0f,
                                       "degrees; 90 brings what was at +X to -Z"),
      unless_default(choice<&S::environment_sampling>(
          "env-sampling", kSample, "sampling", "where light samples go [guided]",
          std::span<const NamedValue<EnvironmentSampling>>(kEnvironmentSamplings))),
      flag<&S::transparent>("transparent", kSample, "the camera does not see the environment"),
      unless_default(choice<&S::working_space>("working-space", kLight, "space",
                                               "primaries that are rendered and written [rec709]",
                                               working_space_table())),
      choice<&S::show_backfaces>("backfaces", kLight, "treatment",
                                 "single-sided faces seen from behind",
                                 std::span<const NamedValue<bool>>(kBackfaces)),
  };
}

std::vector<Setting> loading_settings() {
  return {
      word<&S::animation>("animation", kLoading, "NAME|INDEX|all",
                          "animation that poses the scene [with a time the first, else none]"),
      number<&S::time>("time", kLoading, -kLatest, kLatest,
                       "seconds into the animation [0]; beyond its ends it stands still"),
      number<&S::frame>("frame", kLoading, -kLatest * kMostFps, kLatest * kMostFps,
                        "the same in frames, which may be broken"),
      // Meaningless without an animation.
      unless_default(number<&S::fps>("fps", kLoading, kLeastFps, kMostFps,
                                     "frames a second, of `frame` [24]")),
      shutter(),
      flag<&S::lenient>("lenient", kLoading,
                        "take images that are cut short, replace those that do not decode and "
                        "values of materials "
                        "that cannot be; with warnings"),
      choice<&S::isa>("isa", kSample, "instruction set",
                      "which of Embree's kernels trace the rays, to have the same bits on all "
                      "machines of a farm [the widest of the machine]",
                      embree_isa_table()),
      word<&S::resource_root>(
          "resource-root", kLoading, "DIR",
          "the scene may refer to files in this folder and below [its own folder]"),
  };
}

std::vector<Setting> make_table() {
  std::vector<Setting> table;
  for (const auto& part : {edit_settings, channel_settings, count_settings, sample_settings,
                           view_settings, light_settings, loading_settings}) {
    std::ranges::move(part(), std::back_inserter(table));
  }
  return table;
}

namespace fs = std::filesystem;

// The shortest valid JSON for the value.
nlohmann::ordered_json json_of(const Setting& setting, const std::string& text) {
  if (setting.type.empty()) return text == "yes";
  const std::optional<double> number = parse_real(text);
  if (!number || setting.type.find("..") == std::string::npos) return text;
  return nlohmann::ordered_json::parse(text);
}

}  // namespace

std::span<const Setting> setting_table() {
  static const std::vector<Setting> table = make_table();
  return table;
}

const Setting* find_setting(std::string_view name) {
  const auto found = std::ranges::find(setting_table(), name, &Setting::name);
  return found == setting_table().end() ? nullptr : &*found;
}

SettingTexts setting_texts(const FrameSettings& settings,
                           std::initializer_list<SettingGroup> groups, bool files) {
  SettingTexts texts;
  for (const Setting& setting : setting_table()) {
    const bool wanted =
        groups.size() == 0 || std::ranges::find(groups, setting.group) != groups.end();
    if (!wanted || (setting.file && !files)) continue;
    std::string text = setting.text(settings);
    if (!text.empty()) texts.emplace_back(setting.name, std::move(text));
  }
  return texts;
}

std::string text_of_json(const nlohmann::json& value, const JsonReader& reader) {
  if (value.is_string()) {
    std::string text = reader.text();
    const auto control = [](char c) { return static_cast<unsigned char>(c) < 0x20; };
    if (text.empty() || std::ranges::any_of(text, control)) {
      reader.expected("a text without control characters");
    }
    return text;
  }
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_number()) return fmt::format("{}", value.get<double>());
  reader.expected("a text, a number, true or false");
}

void read_settings(const std::string& path, FrameSettings& settings) {
  const nlohmann::json document = read_json(path);
  const JsonReader root(document, path);
  for (const std::string& name : root.members()) {
    const JsonReader member = root[name];
    try {
      const Setting& setting = find_named(setting_table(), "`settings`", "setting", name);
      std::string text = text_of_json(document[name], member);
      if (setting.file) text = (fs::path(path).parent_path() / text).string();
      setting.read(settings, text);
    } catch (const UsageError& error) {
      throw InputError(member.place(), error.what());
    }
  }
}

std::string settings_json(const FrameSettings& settings, const std::string& path) {
  const FrameSettings defaults;
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const Setting& setting : setting_table()) {
    std::string text = setting.text(settings);
    if (text == setting.text(defaults)) continue;
    if (setting.file) {
      text = fs::proximate(text, fs::absolute(path).parent_path()).generic_string();
    }
    json[setting.name] = json_of(setting, text);
  }
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace emberline
