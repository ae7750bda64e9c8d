// Builders of the rows of the setting table, one for each kind of value. Only setting_rows.cpp
// includes this.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "renderer/core/errors.h"
#include "renderer/core/names.h"
#include "renderer/core/option_values.h"
#include "renderer/core/shortened.h"
#include "renderer/engine/setting_table.h"

namespace emberline::setting_kinds {

inline std::string text_of(const std::string& value) { return value; }
inline std::string text_of(bool value) { return value ? "yes" : ""; }
template <typename T>
requires std::is_arithmetic_v<T> std::string text_of(T value) {
  return fmt::format("{}", value);  // the shortest text that is read back as the same number
}
inline std::string text_of(const Vec3d& v) { return fmt::format("{},{},{}", v.x, v.y, v.z); }
inline std::string text_of(const FramePart& p) { return fmt::format("{}/{}", p.index, p.count); }
inline std::string text_of(const SampleSpan& s) { return fmt::format("{}-{}", s.first, s.end); }
inline std::string text_of(const Shutter& s) { return fmt::format("{},{}", s.open, s.close); }
inline std::string text_of(const SunPosition& s) {
  return fmt::format("{},{}", s.elevation, s.azimuth);
}
inline std::string text_of(const Turntable& t) {
  return t.frame ? fmt::format("{}/{}", *t.frame, t.count) : fmt::format("{}", t.count);
}
inline std::string text_of(const CatcherPlane& p) {
  return p.height ? fmt::format("{}", *p.height) : "bottom";
}
inline std::string text_of(const Rect& r) {
  return fmt::format("{},{},{},{}", r.x0, r.y0, r.x1, r.y1);
}
template <typename T>
std::string text_of(const std::optional<T>& value) {
  return value ? text_of(*value) : std::string();
}

[[noreturn]] inline void reject_value(const std::string& name, std::string_view text,
                                      const std::string& what) {
  throw UsageError(fmt::format("`{}`: '{}' is not {}", name, shortened(text), what));
}

template <auto Member>
std::string member_text(const FrameSettings& settings) {
  return text_of(settings.*Member);
}

// Returns a setting whose value is a number, or an optional number, in [min, max].
template <auto Member, typename T>
Setting number(const std::string& name, SettingGroup group, T min, T max, const OptionText& help,
               std::optional<T> (*parse)(std::string_view) = parse_number<T>) {
  const auto read = [=](FrameSettings& settings, std::string_view text) {
    const std::optional<T> value = parse(text);
    if (!value || *value < min || *value > max) {
      reject_value(name, text,
                   fmt::format("a {} from {} to {}",
                               std::is_integral_v<T> ? "whole number" : "number", min, max));
    }
    settings.*Member = *value;
  };
  return {name, group, fmt::format("{}..{}", min, max), help, read, member_text<Member>};
}

template <typename Table>
std::vector<SettingChoice> choices_of(const Table& table) {
  std::vector<SettingChoice> choices;
  for (const auto& entry : table) {
    choices.push_back({std::string(entry.name), std::string(entry.summary)});
  }
  return choices;
}

// Returns a setting whose member stores a name from `table`.
template <auto Member, typename Table>
Setting named(const std::string& name, SettingGroup group, const std::string& kind,
              const OptionText& help, const Table& table) {
  const auto read = [=](FrameSettings& settings, std::string_view text) {
    settings.*Member = find_named(table, fmt::format("`{}`", name), kind, text).name;
  };
  return {name, group, "NAME", help, read, member_text<Member>, choices_of(table)};
}

// Returns a setting whose member stores a value from `table`. An optional member may be unset.
template <auto Member, typename T>
Setting choice(const std::string& name, SettingGroup group, const std::string& kind,
               const OptionText& help, std::span<const NamedValue<T>> table) {
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
             const OptionText& help) {
  const bool file = type == "FILE" || type == "DIR";
  const auto read = [](FrameSettings& settings, std::string_view text) { settings.*Member = text; };
  return {name, group, type, help, read, member_text<Member>, {}, file};
}

template <auto Member>
Setting flag(const std::string& name, SettingGroup group, const OptionText& help) {
  const auto read = [=](FrameSettings& settings, std::string_view text) {
    if (text != "yes" && text != "no") reject_value(name, text, "yes or no");
    settings.*Member = text == "yes";
  };
  return {name, group, "", help, read, member_text<Member>};
}

// Returns a setting of `N` numbers, separated by `separator`. `make` converts the numbers to the
// member's value. If `make` returns nullopt, the message says that the text is not `expected`.
template <auto Member, size_t N, typename T, typename Make>
Setting numbers(const std::string& name, SettingGroup group, const std::string& type,
                char separator, const std::string& expected, const OptionText& help,
                const Make& make) {
  const auto read = [=](FrameSettings& settings, std::string_view text) {
    std::array<T, N> values;
    if (!parse_numbers(text, separator, values)) reject_value(name, text, expected);
    const auto value = make(values);
    if (!value) reject_value(name, text, expected);
    settings.*Member = *value;
  };
  return {name, group, type, help, read, member_text<Member>};
}

// Returns a setting that is a list of names from `table`. `check` throws for other names.
template <auto Member, typename Table>
Setting names(const std::string& name, const OptionText& help, const Table& table,
              void (*check)(std::string_view)) {
  const auto read = [=](FrameSettings& settings, std::string_view text) {
    check(text);
    settings.*Member = text;
  };
  return {name, SettingGroup::kChannels, "LIST",           help,
          read, member_text<Member>,     choices_of(table)};
}

// Returns the setting, changed so that text() returns an empty text for the default value.
inline Setting omit_default(Setting setting) {
  setting.text = [text = setting.text](const FrameSettings& s) {
    std::string value_text = text(s);
    return value_text == text(FrameSettings()) ? std::string() : value_text;
  };
  return setting;
}

}  // namespace emberline::setting_kinds
