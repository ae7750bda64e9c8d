#include "renderer/core/setting_names.h"

#include <algorithm>
#include <atomic>

namespace emberline {
namespace {

std::string bare(std::string_view name) { return std::string(name); }

std::atomic<SettingFormatter> g_setting_formatter = bare;

bool may_be_setting(std::string_view name) {
  return !name.empty() && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
  });
}

}  // namespace

void spell_settings(SettingFormatter formatter) { g_setting_formatter = formatter; }

std::string spell_setting_names(std::string_view text) {
  std::string result;
  for (;;) {
    const size_t begin = text.find('`');
    const size_t end = begin == text.npos ? begin : text.find('`', begin + 1);
    if (end == text.npos) return result.append(text);
    const std::string_view name = text.substr(begin + 1, end - begin - 1);
    const std::string spelling = may_be_setting(name) ? g_setting_formatter.load()(name) : "";
    result += text.substr(0, begin);
    // If the name is not a setting, leave its second backtick in `text`, because it may open the
    // next name.
    result += spelling.empty() ? text.substr(begin, end - begin) : std::string_view(spelling);
    text.remove_prefix(spelling.empty() ? end : end + 1);
  }
}

}  // namespace emberline
