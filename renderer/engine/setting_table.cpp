#include "renderer/engine/setting_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "io/json/input.h"
#include "renderer/core/errors.h"
#include "renderer/core/names.h"
#include "renderer/core/option_values.h"

namespace emberline {
namespace {

namespace fs = std::filesystem;

// Returns true or false for a flag, a number if the type is a range, otherwise a text.
nlohmann::ordered_json json_of(const Setting& setting, const std::string& text) {
  if (setting.type.empty()) return text == "yes";
  const std::optional<double> number = parse_real(text);
  if (!number || setting.type.find("..") == std::string::npos) return text;
  return nlohmann::ordered_json::parse(text);
}

}  // namespace

std::string_view title_of(HelpSection section) {
  constexpr std::string_view kTitles[] = {
      "Output",     "Samples", "View",    "Light", "Scene", "Limits", "Parts of a frame",
      "Inspection", "Window",  "Session", "Jobs",  "Study", "General"};
  return kTitles[size_t(section)];
}

std::string default_of(const Setting& setting, const FrameSettings& settings) {
  const std::string text = setting.type.empty() ? "" : setting.text(settings);
  return text.empty() ? setting.help.fallback : text;
}

const Setting* find_setting(std::string_view name) {
  const auto found = std::ranges::find(setting_table(), name, &Setting::name);
  return found == setting_table().end() ? nullptr : &*found;
}

SettingTexts setting_texts(const FrameSettings& settings,
                           std::initializer_list<SettingGroup> groups, bool files) {
  SettingTexts texts;
  for (const Setting& setting : setting_table()) {
    const bool in_groups =
        groups.size() == 0 || std::ranges::find(groups, setting.group) != groups.end();
    if (!in_groups || (setting.file && !files)) continue;
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
      reader.throw_expected("a string without control characters");
    }
    return text;
  }
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_number()) return fmt::format("{}", value.get<double>());
  reader.throw_expected("a string, a number, true or false");
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
