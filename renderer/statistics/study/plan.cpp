#include "renderer/statistics/study/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <string_view>

#include "renderer/core/errors.h"
#include "renderer/core/hash.h"
#include "renderer/core/names.h"
#include "renderer/core/option_values.h"
#include "renderer/core/shortened.h"
#include "renderer/engine/render_plan.h"
#include "renderer/engine/setting_table.h"

namespace emberline {
namespace {

constexpr std::string_view kDefaultBudgets = "1,2,4,8,16,32,64";
// The limits of a budget in seconds. They are the same as for --time-limit.
constexpr double kMinSeconds = 0.001, kMaxSeconds = 1e9;

std::vector<std::string> split(std::string_view text, char separator) {
  std::vector<std::string> parts;
  while (true) {
    const size_t end = text.find(separator);
    parts.emplace_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

void reject_repeated(const std::vector<std::string>& names, const std::string& option) {
  for (const std::string& name : names) {
    if (std::ranges::count(names, name) > 1) {
      throw UsageError(option + ": '" + shortened(name) + "' is listed twice");
    }
  }
}

template <typename Table>
std::vector<std::string> parse_names(const std::string& list, const char* option, const char* kind,
                                     const Table& table) {
  const std::vector<std::string> names = split(list, ',');
  for (const std::string& name : names) find_named(table, option, kind, name);
  reject_repeated(names, option);
  return names;
}

struct EstimatorChoice {
  std::string text;             // as the user wrote it
  FrameSettings settings = {};  // estimator, allocation and `unbiased`
  bool planned = false;
};

EstimatorChoice parse_estimator(const std::string& text) {
  std::vector<std::string> parts = split(text, '/');
  EstimatorChoice choice{text};
  const auto parse_part = [&](const char* setting) {
    find_named(find_setting(setting)->choices, "`estimators`", setting, parts[0]);
    find_setting(setting)->read(choice.settings, parts[0]);
    parts.erase(parts.begin());
  };
  parse_part("estimator");
  if (!parts.empty() && (parts.back() == "unbiased" || parts.back() == "planned")) {
    choice.planned = parts.back() == "planned";
    choice.settings.unbiased = !choice.planned;
    parts.pop_back();
  }
  if (!parts.empty()) parse_part("allocation");
  if (!parts.empty()) {
    throw UsageError("`estimators`: '" + shortened(text) +
                     "' does not have the form ESTIMATOR[/ALLOCATION][/unbiased or /planned]");
  }
  return choice;
}

std::vector<double> parse_budgets(const std::string& list, bool by_time) {
  const char* option = by_time ? "`seconds`" : "`spp`";
  std::vector<double> budgets;
  for (const std::string& text : split(list, ',')) {
    const std::optional<double> value =
        by_time ? parse_real(text) : std::optional<double>(parse_number<uint32_t>(text));
    const double min = by_time ? kMinSeconds : 1, max = by_time ? kMaxSeconds : kMaxSamples;
    if (!value || *value < min || *value > max) {
      throw UsageError(fmt::format("{}: '{}' is not a {} from {} to {}", option, shortened(text),
                                   by_time ? "number" : "whole number", min, max));
    }
    if (!budgets.empty() && *value <= budgets.back()) {
      throw UsageError(fmt::format("{}: budgets must ascend, but {} comes after {}", option, text,
                                   budgets.back()));
    }
    budgets.push_back(*value);
  }
  return budgets;
}

bool is_fixed_count(const std::string& sampler) {
  return find_named(sampler_table(), "`samplers`", "sampler", sampler).counts != SampleCounts::kAny;
}

// Returns the message of the UsageError that rendering the method at one of the budgets would
// throw. Returns "" if all budgets are possible.
std::string find_unsupported_reason(const PlannedMethod& method, const StudyPlan& plan) {
  try {
    for (const double budget : plan.budgets) {
      if (method.has_time_budget) {
        RenderPlan{deadline_options(method, budget, 0)};
        continue;
      }
      const auto samples = plan.by_time ? uint32_t(64) : uint32_t(budget);
      RenderOptions options = frame_options(method, samples, 0);
      options.spp = samples;  // not rounded, so that unsupported numbers are reported
      RenderPlan{options};
    }
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

PlannedMethod plan_method(const StudyOptions& options, const std::string& driver,
                          const EstimatorChoice* estimator, const std::string& sampler,
                          bool several_samplers, bool denoise) {
  PlannedMethod planned;
  StudyMethod& m = planned.method;
  m.driver = m.name = driver;
  m.sampler = sampler;
  RenderOptions& o = planned.options;
  o = options.frame;
  o.driver = driver;
  o.sampler = sampler;
  planned.id = driver;
  if (estimator) {
    m.name += "/" + estimator->text;
    m.estimator = o.estimator = estimator->settings.estimator;
    o.allocation = estimator->settings.allocation;
    m.allocation = allocation_of(o);
    m.unbiased = o.unbiased = estimator->settings.unbiased;
    m.planned = estimator->planned;
    if (m.planned) o.plan = "made by the study";
    planned.id += "-" + m.estimator + (m.allocation.empty() ? "" : "-" + m.allocation) +
                  (m.unbiased ? "-unbiased" : "") + (m.planned ? "-planned" : "");
  }
  m.denoised = o.denoise = denoise;
  if (several_samplers) m.name += "/" + sampler;
  if (denoise) {
    m.name += "+denoise";
    planned.id += "-denoise";
  }
  planned.id += "-" + sampler;
  planned.separate = options.separate || options.denoise || is_fixed_count(sampler) || is_tiled(o);
  planned.has_time_budget =
      planned.separate && options.seconds && !m.planned && !is_fixed_count(sampler);
  return planned;
}

// Chooses a sampler that is not studied, if possible, so that the reference does not have the same
// faults as the pictures.
std::string reference_sampler(const std::vector<std::string>& studied) {
  for (const char* name : {"independent", "sobol"}) {
    if (std::ranges::find(studied, name) == studied.end()) return name;
  }
  return "independent";
}

void check_count(std::string_view name, std::optional<uint32_t> count, uint32_t min, uint32_t max) {
  if (!count || (*count >= min && *count <= max)) return;
  throw UsageError("`{}`: {} is not from {} to {}", name, *count, min, max);
}

// Throws UsageError if a client has set settings outside the groups of kStudySettings.
void check_settings(const FrameSettings& settings) {
  const FrameSettings none;
  for (const Setting& row : setting_table()) {
    if (std::ranges::find(kStudySettings, row.group) != kStudySettings.end()) continue;
    if (row.text(settings) == row.text(none)) continue;
    throw UsageError(
        "`{}`: study does not accept this setting; its own options choose what it compares",
        row.name);
  }
}

}  // namespace

std::vector<std::string> parse_samplers(const std::string& list) {
  return parse_names(list, "`samplers`", "sampler", sampler_table());
}

std::vector<size_t> study_order(size_t methods, uint32_t seed) {
  std::vector<size_t> order(methods);
  for (size_t i = 0; i < methods; ++i) order[i] = i;
  for (size_t i = methods; i > 1; --i) {  // Fisher-Yates
    std::swap(order[i - 1], order[hash_combine64(seed, i) % i]);
  }
  return order;
}

RenderOptions frame_options(const PlannedMethod& method, uint32_t samples, uint32_t seed) {
  RenderOptions options = method.options;
  const auto& sampler = find_named(sampler_table(), "`samplers`", "sampler", method.method.sampler);
  options.spp = sampler.counts == SampleCounts::kPowerOfTwo ? std::bit_floor(samples) : samples;
  options.seed = seed;
  return options;
}

RenderOptions deadline_options(const PlannedMethod& method, double seconds, uint32_t seed) {
  RenderOptions options = method.options;
  options.time_budget_s = seconds;
  options.seed = seed;
  return options;
}

StudyPlan plan_study(const StudyOptions& options) {
  if (options.frame.working_space != WorkingSpace::kRec709) {
    throw UsageError("`working-space`: study measures in rec709 only; use it with render");
  }
  check_settings(options.frame);
  if (!options.reference.empty() && (options.reference_spp || !options.cache.empty())) {
    throw UsageError(
        "`reference-spp`, `cache`: they apply to a rendered reference, but `reference` names a "
        "picture");
  }
  check_count("seeds", options.seeds, 1, kMaxStudySeeds);
  check_count("reference-spp", options.reference_spp, 2, kMaxSamples);
  StudyPlan plan;
  const std::vector<std::string> drivers =
      parse_names(options.drivers, "`drivers`", "driver", find_setting("driver")->choices);
  const std::vector<std::string> samplers = parse_samplers(options.samplers.value_or("sobol"));
  std::vector<EstimatorChoice> estimators;
  const std::vector<std::string> estimator_texts = split(options.estimators, ',');
  for (const std::string& text : estimator_texts) estimators.push_back(parse_estimator(text));
  reject_repeated(estimator_texts, "`estimators`");
  if (options.spp && options.seconds) {
    throw UsageError(
        "`seconds`: budgets are either sample counts or seconds; give only one of `spp` and "
        "`seconds`");
  }
  plan.by_time = options.seconds.has_value();
  plan.budgets = parse_budgets(
      plan.by_time ? *options.seconds : options.spp.value_or(std::string(kDefaultBudgets)),
      plan.by_time);

  for (const std::string& sampler : samplers) {
    for (const std::string& driver : drivers) {
      const bool several = samplers.size() > 1;
      const auto add = [&](const EstimatorChoice* estimator) {
        plan.methods.push_back(plan_method(options, driver, estimator, sampler, several, false));
        if (!options.denoise) return;
        plan.methods.push_back(plan_method(options, driver, estimator, sampler, several, true));
      };
      FrameSettings alone;
      alone.driver = driver;
      if (samples_uniformly(alone)) {
        add(nullptr);
        continue;
      }
      for (const EstimatorChoice& estimator : estimators) add(&estimator);
    }
  }
  std::vector<std::string_view> names;
  bool possible = false;
  for (PlannedMethod& method : plan.methods) {
    method.unsupported_reason = find_unsupported_reason(method, plan);
    possible = possible || method.unsupported_reason.empty();
    names.push_back(method.method.name);
  }
  if (!possible)
    throw UsageError("no method can be rendered: " + plan.methods[0].unsupported_reason);
  plan.baseline = options.baseline.empty() ? std::string(names[0]) : options.baseline;
  if (std::ranges::find(names, plan.baseline) == names.end()) {
    throw UsageError("`baseline`: " + unknown_name_message("method", plan.baseline, names));
  }
  plan.reference_sampler = reference_sampler(samplers);
  return plan;
}

}  // namespace emberline
