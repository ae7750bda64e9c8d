#include "renderer/output/recorded_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "renderer/core/errors.h"
#include "renderer/core/shortened.h"
#include "renderer/engine/setting_table.h"
#include "renderer/film/channels.h"
#include "renderer/output/report.h"

namespace emberline {
namespace {

constexpr std::array<std::string_view, 2> kWithoutEffect = {"time-limit", "bucket-order"};

// Whether two lists of channels are equal, apart from their order and from `denoising`. Merged and
// extended frames list their channels in table order and include the channels that denoising added.
bool are_same_channels(std::string_view a, std::string_view b) {
  try {
    AovSet first = AovSet::parse(a), second = AovSet::parse(b);
    first.insert(Aov::kDenoising);
    second.insert(Aov::kDenoising);
    return first == second;
  } catch (const UsageError&) {
    return false;
  }
}

std::string shown(const std::string& text) { return text.empty() ? "not given" : shortened(text); }

}  // namespace

RecordedSettings::RecordedSettings(
    std::span<const std::pair<std::string, std::string>> attributes) {
  constexpr std::string_view kPrefix = "emberline:";
  for (const auto& [attribute, text] : attributes) {
    if (!attribute.starts_with(kPrefix)) continue;
    std::string name = attribute.substr(kPrefix.size());
    std::ranges::replace(name, '_', '-');
    texts_.insert_or_assign(std::move(name), text.substr(0, text.find_last_not_of(' ') + 1));
  }
  for (const Setting& setting : setting_table()) {
    const std::string value = text(setting.name);
    if (setting.file || value.empty()) continue;
    try {
      setting.read(settings_, value);
    } catch (const UsageError&) {  // written by another version of Emberline
    }
  }
}

std::string RecordedSettings::text(const std::string& name) const {
  const auto found = texts_.find(name);
  return found == texts_.end() ? "" : found->second;
}

std::vector<std::pair<std::string, std::string>> RecordedSettings::given() const {
  // A frame also records the default estimator and allocation that it uses, so a recorded default
  // does not mean that the user gave it.
  FrameSettings unnamed = settings_;
  unnamed.estimator.clear();
  unnamed.allocation.reset();
  unnamed = with_recorded_defaults(unnamed);
  const FrameSettings defaults;
  std::vector<std::pair<std::string, std::string>> list;
  for (const Setting& setting : setting_table()) {
    const std::string value = text(setting.name);
    const bool is_filled_in = setting.name == "estimator" || setting.name == "allocation";
    if (value.empty() || setting.name == "isa" || value == setting.text(defaults) ||
        (is_filled_in && value == setting.text(unnamed))) {
      continue;
    }
    list.emplace_back(setting.name, value);
  }
  return list;
}

std::vector<std::string> RecordedSettings::changes(const FrameSettings& now,
                                                   bool (*is_compared)(const Setting&)) const {
  const FrameSettings recorded = with_recorded_defaults(now);
  std::vector<std::string> list;
  for (const Setting& setting : setting_table()) {
    const bool has_effect =
        std::ranges::find(kWithoutEffect, setting.name) == kWithoutEffect.end() &&
        (setting.name != "isa" || now.isa);
    if (setting.file || !has_effect || (is_compared && !is_compared(setting))) continue;
    const std::string then = text(setting.name), value = setting.text(recorded);
    if (then == value || (setting.name == "aov" && are_same_channels(then, value))) continue;
    list.push_back(fmt::format("`{}` {} (now {})", setting.name, shown(then), shown(value)));
  }
  return list;
}

}  // namespace emberline
