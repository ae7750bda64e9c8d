#include "renderer/engine/setting_rules.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "integrators/integrator.h"
#include "io/exr/writer.h"
#include "renderer/core/errors.h"
#include "renderer/core/option_values.h"
#include "renderer/drivers/adaptive/error_estimator.h"
#include "renderer/engine/render_plan.h"
#include "renderer/film/channels.h"
#include "samplers/sampler.h"

namespace emberline {
namespace {

std::string text_of(const FrameSettings& settings, std::string_view name) {
  const Setting* const setting = find_setting(name);
  return setting ? setting->text(settings) : std::string();
}

bool is_given(const FrameSettings& settings, std::string_view name) {
  static const FrameSettings defaults;
  return text_of(settings, name) != text_of(defaults, name);
}

std::string quoted(const SettingCondition& condition) {
  return fmt::format("`{}`", condition.name);
}

// Returns text such as "bucket with `noise-threshold`".
std::string value_text(const SettingCondition& condition) {
  std::string text(condition.value);
  if (!condition.with.empty()) text += fmt::format(" with `{}`", condition.with);
  if (!condition.without.empty()) text += fmt::format(" without `{}`", condition.without);
  return text;
}

std::string text_of(const SettingCondition& condition) {
  const std::string value = value_text(condition);
  return value.empty() ? quoted(condition) : quoted(condition) + " " + value;
}

// Returns text such as "`env`, `aov` N or P".
std::string text_of(const AnyCondition& list, std::string_view last_comma) {
  std::string text;
  for (size_t i = 0; i < list.size(); ++i) {
    const bool same = i > 0 && list[i].name == list[i - 1].name && !list[i].value.empty();
    if (i > 0) text += i + 1 < list.size() ? ", " : last_comma;
    text += same ? value_text(list[i]) : text_of(list[i]);
  }
  return text;
}

const SettingCondition* first_holding(const AnyCondition& list, const SettingHolds& holds) {
  const auto found = std::ranges::find_if(list, holds);
  return found == list.end() ? nullptr : &*found;
}

void add(AnyCondition& list, const AnyCondition& more) {
  list.insert(list.end(), more.begin(), more.end());
}

bool mentions(const AnyCondition& list, std::string_view name, std::string_view value) {
  return std::ranges::any_of(list, [&](const SettingCondition& condition) {
    return condition.name == name && condition.value == value;
  });
}

// Returns the settings that exclude this one or that are excluded by it.
AnyCondition find_exclusions(std::span<const SettingRule> rules, std::string_view name,
                             std::string_view value) {
  AnyCondition excluded;
  for (const SettingRule& rule : rules) {
    if (!rule.in_help) continue;
    if (mentions(rule.about, name, value)) add(excluded, rule.excludes);
    if (mentions(rule.excludes, name, value)) add(excluded, rule.about);
  }
  // Removes duplicates, and puts the values of one setting next to each other.
  AnyCondition sorted;
  for (const SettingCondition& condition : excluded) {
    const auto same_name = [&](const SettingCondition& other) {
      return other.name == condition.name;
    };
    if (mentions(sorted, condition.name, condition.value)) continue;
    const auto last = std::find_if(sorted.rbegin(), sorted.rend(), same_name);
    sorted.insert(last == sorted.rend() ? sorted.end() : last.base(), condition);
  }
  return sorted;
}

std::string crop_violation(const FrameSettings& s) {
  const Rect& crop = *s.crop;
  if (!crop.empty() && crop.intersect({0, 0, s.width, s.height}) == crop) return "";
  return fmt::format(
      "`crop`: {},{},{},{} is not inside the frame; valid is 0 <= X0 < X1 <= {} and 0 <= Y0 < Y1 "
      "<= {}",
      crop.x0, crop.y0, crop.x1, crop.y1, s.width, s.height);
}

std::string min_samples_violation(const FrameSettings& s) {
  const auto above = [&](const std::string& what, uint32_t limit) {
    return fmt::format("`min-spp` {} is above {} {}; valid is 1 to {}", *s.min_spp, what, limit,
                       limit);
  };
  if (s.max_spp && *s.min_spp > *s.max_spp) return above("`max-spp`", *s.max_spp);
  if (s.spp && *s.min_spp > *s.spp) return above("the average of `spp`", *s.spp);
  return "";
}

// Returns an error if a judged channel is not in the frame, or if some channels have a threshold
// and others have none.
std::string judge_violation(const FrameSettings& s) {
  const AovSet aovs = aovs_of(s);
  for (const JudgedChannel& channel : judged_channels_of(s)) {
    const std::string& name = channel.name;
    const auto aov = std::ranges::find(aov_table(), name, &NamedValue<Aov>::name);
    if (name == "light.*" && !s.light_groups) {
      return "`judge` light.* requires `light-groups`: otherwise there are no such layers";
    }
    if (aov != aov_table().end() && !aovs.contains(aov->value)) {
      return fmt::format("`judge` {} requires `aov` {}: otherwise there is no such layer", name,
                         name);
    }
    if (channel.threshold > 0.0f && !s.noise_threshold) {
      return fmt::format(
          "`judge` {}:{} requires `noise-threshold`: without it, pixels are not finished by their "
          "errors",
          name, channel.threshold);
    }
  }
  return "";
}

// For each value in `table` for which `fits` is true, returns the condition that the setting has
// this value.
template <typename Table, typename Fits>
AnyCondition values_of(std::string_view setting, const Table& table, const Fits& fits) {
  AnyCondition values;
  for (const auto& entry : table) {
    if (fits(entry)) values.push_back({setting, entry.name});
  }
  return values;
}

// Returns the drivers with this distribution of samples. Drivers that are uniform only without a
// threshold come last, because the text of their condition is longer.
AnyCondition drivers_of(SampleDistribution distribution, SettingCondition by_threshold) {
  AnyCondition drivers =
      find_drivers([&](const DriverEntry& driver) { return driver.distribution == distribution; });
  for (const DriverEntry& driver : driver_table()) {
    if (driver.distribution != SampleDistribution::kUniformWithoutThreshold) continue;
    by_threshold.value = driver.name;
    drivers.push_back(by_threshold);
  }
  return drivers;
}

AnyCondition adaptive_drivers() {
  return drivers_of(SampleDistribution::kByError, {.name = "driver", .with = "noise-threshold"});
}

AnyCondition uniform_drivers() {
  return drivers_of(SampleDistribution::kUniform, {.name = "driver", .without = "noise-threshold"});
}

AnyCondition joined(std::initializer_list<AnyCondition> lists) {
  AnyCondition all;
  for (const AnyCondition& list : lists) add(all, list);
  return all;
}

AnyCondition denoising() { return {{"denoise"}, {"aov", "denoising"}}; }

std::vector<SettingRule> view_rules() {
  return {
      {.about = {{"look-from"}},
       .needs = {{"look-at"}, {"panorama"}},
       .reason = "a position alone does not give a direction"},
      {.about = {{"look-at"}},
       .needs = {{"look-from"}},
       .reason = "it aims the camera that `look-from` places"},
      {.about = {{"panorama"}},
       .excludes = {{"fov-y"}, {"f-stop"}, {"focus-distance"}},
       .reason = "a panorama shows all directions and has no lens"},
      {.about = {{"turntable-center"}},
       .needs = {{"turntable"}},
       .reason = "it sets the centre of the turntable"},
      {.about = {{"turntable-center", "look-at"}},
       .needs = {{"look-at"}},
       .reason = "the camera turns around that point"},
      {.about = {{"crop"}}, .violation = crop_violation},
      {.about = {{"time"}}, .excludes = {{"frame"}}, .reason = "both set the time"},
      {.about = {{"sun"}}, .excludes = {{"env"}}, .reason = "both set the environment"},
      {.about = {{"env-strength"}, {"env-rotation"}},
       .needs = {{"env"}, {"sun"}},
       .reason = "it adjusts only an environment that one of these sets"},
  };
}

// Returns whether lossy compression would mistake the row's channels for colours because of their
// names.
bool would_blur(const ChannelRow& row) {
  return row.setting == "aov" && row.use != ChannelUse::kColour &&
         std::ranges::any_of(row.components, [](std::string_view component) {
           return std::string_view("RGBAY").find(component) != std::string_view::npos;
         });
}

// Rules about the EXR's layers.
std::vector<SettingRule> channel_rules() {
  std::vector<SettingRule> rules = {
      {.about = {{"aov", "clamped"}},
       .needs = {{"clamp-indirect"}},
       .reason = "it shows the light that clamping removes"},
      {.about = {{"aov", "shadow"}},
       .needs = {{"catcher"}, {"catcher-plane"}},
       .reason = "it shows the shadows on catchers"},
      {.about = {{"cryptomatte-levels"}},
       .needs = {{"cryptomatte"}},
       .reason = "without `cryptomatte` there are no layers that store ids"},
      {.about = values_of("exr-compression", exr_compression_table(),
                          [](const auto& entry) { return is_lossy(entry.value); }),
       .excludes =
           joined({{{"cryptomatte"}}, denoising(), values_of("aov", channel_table(), would_blur)}),
       .unless = {{"exr-parts", "layers"}},
       .reason = "lossy compression would blur these layers; with `exr-parts` layers, they are "
                 "stored in parts with zip compression",
       .in_help = false},
  };
  for (const ChannelRow& row : channel_table()) {
    if (!may_be_half(row.use) || row.setting.empty()) continue;
    SettingRule rule = {.about = {{"half", row.name}},
                        .reason = "otherwise there is no such layer",
                        .in_help = false};
    rule.needs = {row.setting == "aov" ? SettingCondition{"aov", row.name}
                                       : SettingCondition{row.setting}};
    if (row.feed == ChannelFeed::kCatchers) {
      rule.needs.insert(rule.needs.end(), {{"catcher"}, {"catcher-plane"}});
    }
    rules.push_back(std::move(rule));
  }
  return rules;
}

SettingRule lighting_rule() {
  const AnyCondition path_aovs = values_of("aov", channel_table(), [](const ChannelRow& row) {
    return row.feed == ChannelFeed::kPaths;
  });
  return {.about = joined({{{"light-groups"}, {"clamp-indirect"}, {"light-samples"}},
                           {{"catcher"}, {"catcher-plane"}, {"holdout"}},
                           denoising(),
                           path_aovs}),
          .needs = values_of("integrator", integrator_table(),
                             [](const auto& entry) { return entry.supports_light_groups; }),
          .reason = "{} does not compute lighting"};
}

// Rules about adaptive sampling.
std::vector<SettingRule> error_rules() {
  const auto estimators = [](const auto& fits) {
    return values_of("estimator", estimator_table(), fits);
  };
  const AnyCondition historical = estimators([](const auto& entry) { return entry.batch > 0; });
  const std::string others =
      text_of(estimators([](const auto& entry) { return entry.batch == 0; }), " and ");
  const AnyCondition two_streams =
      estimators([](const auto& entry) { return entry.streams == StreamCount::kTwo; });
  return {
      {.about = {{"noise-threshold"}},
       .needs = find_drivers(
           [](const DriverEntry& d) { return d.distribution != SampleDistribution::kUniform; }),
       .reason = "{} gives every pixel `spp` samples"},
      {.about = {{"min-spp"}, {"max-spp"}, {"estimator"}, {"allocation"}, {"judge"}, {"unbiased"}},
       .needs = adaptive_drivers(),
       .reason = "with these settings, {} gives every pixel `spp` samples"},
      {.about = {{"allocation"}},
       .excludes = historical,
       .reason = "with this estimator, all unfinished pixels get equally many samples; valid are " +
                 others},
      {.about = {{"unbiased"}},
       .excludes = {{"max-spp"}},
       .reason = "every pixel must get samples in every round; limit the frame with `spp`"},
      {.about = {{"unbiased"}},
       .excludes = historical,
       .reason = "every pixel must get samples in every round; valid are " + others},
      {.about = {{"unbiased"}},
       .excludes = {{"cryptomatte"}, {"light-groups"}},
       .reason = "it weights whole rounds, but mattes and light layers are not stored per round"},
      {.about = {{"min-spp"}}, .violation = min_samples_violation},
      {.about = {{"judge"}},
       .excludes = estimators([](const auto& entry) { return !entry.halves; }),
       .reason = "only the estimator nested measures the errors of other channels"},
      {.about = {{"judge"}},
       .excludes = {{"unbiased"}},
       .reason = "it weights whole rounds, but only R G B are stored per round"},
      {.about = {{"judge"}},
       .excludes = {{"allocation", "mse"}, {"allocation", "relmse"}},
       .reason = "the errors of other channels are weighed against the displayed error"},
      {.about = {{"judge"}}, .violation = judge_violation},
      {.about = {{"plan"}},
       .needs = find_drivers(
           [](const DriverEntry& d) { return d.distribution == SampleDistribution::kByError; }),
       .reason = "a plan has the sample counts of an adaptive frame"},
      {.about = {{"plan"}},
       .excludes = joined({{{"unbiased"}}, historical}),
       .reason = "a plan is made only once, from the deviations of the pixels' samples"},
      {.about = {{"time-budget"}},
       .excludes = {{"spp"}, {"sample-range"}, {"plan"}},
       .reason = "the time decides the number of samples"},
      {.about = {{"time-budget"}},
       .excludes = {{"part"}},
       .reason = "each part would have its own number of samples"},
      {.about = {{"time-budget"}},
       .excludes = {{"unbiased"}},
       .reason = "it plans again while the frame renders"},
      {.about = {{"time-budget"}},
       .excludes = {{.name = "driver", .value = "bucket", .with = "noise-threshold"}},
       .reason = "each bucket ends when its pixels are finished; use `driver` adaptive"},
      {.about = joined({denoising(), two_streams}),
       .excludes = {{"streams", "1"}},
       .reason = "it works by comparing two sample streams; set `streams` to 2, or omit `streams`"},
  };
}

// Rules about parts of a frame, and about samplers that need sample counts in advance.
std::vector<SettingRule> sample_rules() {
  const auto samplers = [](const auto& fits) {
    return values_of("sampler", sampler_table(), fits);
  };
  AnyCondition extensible;
  for (const std::string_view name : extensible_samplers()) extensible.push_back({"sampler", name});
  return {
      {.about = samplers([](const auto& entry) { return entry.counts != SampleCounts::kAny; }),
       .needs = uniform_drivers(),
       .reason = "adaptive sampling does not know in advance how many samples each pixel gets; it "
                 "supports " +
                 text_of(samplers([](const auto& s) { return s.counts == SampleCounts::kAny; }),
                         " and ")},
      {.about = {{"time-budget"}},
       .needs = samplers([](const auto& entry) { return entry.counts == SampleCounts::kAny; }),
       .reason = "the samples of {} depend on their total number"},
      {.about = {{"part"}},
       .needs = joined(
           {find_drivers([](const DriverEntry& driver) { return driver.tiles; }), {{"plan"}}}),
       .reason = "{} renders the whole frame at once"},
      {.about = {{"sample-range"}},
       .needs = uniform_drivers(),
       .reason = "adaptive sampling decides how many samples each pixel gets; give each part "
                 "another `seed` instead"},
      {.about = {{"sample-range"}},
       .needs = extensible,
       .reason = "the samples of {} depend on their total number"},
      {.about = {{"sample-range"}},
       .excludes = {{"spp"}},
       .reason = "the range already sets the number of samples per pixel"},
  };
}

std::vector<SettingRule> make_rules() {
  std::vector<SettingRule> all = view_rules();
  all.push_back(lighting_rule());
  for (const std::vector<SettingRule>& group : {channel_rules(), error_rules(), sample_rules()}) {
    all.insert(all.end(), group.begin(), group.end());
  }
  return all;
}

}  // namespace

std::span<const SettingRule> setting_rules() {
  static const std::vector<SettingRule> rules = make_rules();
  return rules;
}

AnyCondition find_drivers(const std::function<bool(const DriverEntry&)>& fits) {
  return values_of("driver", driver_table(), fits);
}

bool setting_holds(const FrameSettings& settings, const SettingCondition& condition) {
  if (!condition.with.empty() && !is_given(settings, condition.with)) return false;
  if (!condition.without.empty() && is_given(settings, condition.without)) return false;
  const std::string text = text_of(settings, condition.name);
  if (condition.value.empty()) return is_given(settings, condition.name);
  const Setting* const setting = find_setting(condition.name);
  if (!setting || setting->type != "LIST") return text == condition.value;
  const std::vector<std::string_view> values = split_list(text);
  return std::ranges::find(values, condition.value) != values.end();
}

std::string find_violation(const SettingRule& rule, const FrameSettings& settings,
                           const SettingHolds& holds) {
  const SettingCondition* const subject = first_holding(rule.about, holds);
  if (!subject || first_holding(rule.unless, holds)) return "";
  if (rule.violation) return rule.violation(settings);
  if (!rule.needs.empty() && !first_holding(rule.needs, holds)) {
    const std::string value = text_of(settings, rule.needs.front().name);
    return fmt::format("{} requires {}: {}", text_of(*subject), text_of(rule.needs, " or "),
                       fmt::format(fmt::runtime(rule.reason), value));
  }
  if (const SettingCondition* const other = first_holding(rule.excludes, holds)) {
    return fmt::format("{} excludes {}: {}", text_of(*subject), text_of(*other), rule.reason);
  }
  return "";
}

void check_rules(std::span<const SettingRule> rules, const FrameSettings& settings,
                 const SettingHolds& holds) {
  for (const SettingRule& rule : rules) {
    const std::string violation = find_violation(rule, settings, holds);
    if (!violation.empty()) throw UsageError(violation);
  }
}

void check_rules(const FrameSettings& settings) {
  check_rules(setting_rules(), settings, [&](const SettingCondition& condition) {
    return setting_holds(settings, condition);
  });
}

void check_rules(const FrameSettings& settings, std::string_view about) {
  const auto holds = [&](const SettingCondition& condition) {
    return setting_holds(settings, condition);
  };
  for (const SettingRule& rule : setting_rules()) {
    if (mentions(rule.about, about, "")) check_rules({&rule, 1}, settings, holds);
  }
}

bool setting_is_allowed(const FrameSettings& settings, std::string_view name) {
  const auto holds = [&](const SettingCondition& condition) {
    return (condition.name == name && condition.value.empty()) ||
           setting_holds(settings, condition);
  };
  return std::ranges::none_of(setting_rules(), [&](const SettingRule& rule) {
    return !rule.violation && mentions(rule.about, name, "") &&
           !find_violation(rule, settings, holds).empty();
  });
}

std::string rules_of(std::span<const SettingRule> rules, std::string_view name,
                     std::string_view value) {
  std::string text;
  for (const SettingRule& rule : rules) {
    if (!rule.in_help || rule.needs.empty() || !mentions(rule.about, name, value)) continue;
    text += (text.empty() ? "; requires " : ", and ") + text_of(rule.needs, " or ");
  }
  const AnyCondition excluded = find_exclusions(rules, name, value);
  if (!excluded.empty()) text += "; excludes " + text_of(excluded, ", ");
  return text;
}

namespace {

RulesHelp describe_rules(const Setting& setting) {
  RulesHelp help = {rules_of(setting_rules(), setting.name), ""};
  for (const SettingChoice& choice : setting.choices) {
    help.values += fmt::format("\n  {}: {}", choice.name, choice.summary) +
                   rules_of(setting_rules(), setting.name, choice.name);
  }
  return help;
}

}  // namespace

const RulesHelp& rules_of(const Setting& setting) {
  // Cached, because every command of the program needs it.
  static const std::map<std::string, RulesHelp> all = [] {
    std::map<std::string, RulesHelp> texts;
    for (const Setting& each : setting_table()) texts.emplace(each.name, describe_rules(each));
    return texts;
  }();
  return all.at(setting.name);
}

std::string as_sentences(std::string_view rules) {
  constexpr std::string_view kRequires = "; requires ", kExcludes = "; excludes ";
  std::string text;
  while (rules.starts_with(kRequires) || rules.starts_with(kExcludes)) {
    const bool required = rules.starts_with(kRequires);
    rules.remove_prefix(kRequires.size());
    const size_t end = std::min(rules.find(kExcludes), rules.size());
    text += required ? " Requires " : " Cannot be combined with ";
    text += rules.substr(0, end);
    text += ".";
    rules.remove_prefix(end);
  }
  return text;
}

}  // namespace emberline
