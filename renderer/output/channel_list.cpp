#include "renderer/output/channel_list.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "renderer/core/setting_names.h"
#include "renderer/film/channels.h"

namespace emberline {
namespace {

using ChannelJson = nlohmann::ordered_json;

ChannelJson channels_as_json() {
  ChannelJson list = ChannelJson::array();
  for (const ChannelRow& row : channel_table()) {
    const bool named_by_scene = !row.setting.empty() && row.setting != "aov";
    ChannelJson names = ChannelJson::array();
    if (!named_by_scene) {
      for (const PictureChannel& channel : channels_of(row)) names.push_back(channel.name);
    }
    list.push_back({{"name", row.name},
                    {"channels", names},
                    {"setting", row.setting},
                    {"value", name_of(row.kind)},
                    {"unit", row.unit},
                    {"whole_numbers", row.use == ChannelUse::kWhole},
                    {"half", may_be_half(row.use)},
                    {"lossy", row.use == ChannelUse::kColour},
                    {"denoised", row.denoised},
                    {"summary", spell_setting_names(row.summary)}});
  }
  return list;
}

std::string channels_as_text(const ChannelJson& rows) {
  std::string text;
  for (const ChannelJson& row : rows) {
    const std::string setting = row["setting"], unit = row["unit"];
    text += fmt::format("{:<12} {}{}{}\n    {}\n", row["name"].get<std::string>(),
                        row["value"].get<std::string>(), unit.empty() ? "" : ", " + unit,
                        setting.empty()    ? ""
                        : setting == "aov" ? fmt::format(", {} {}", spell_setting_names("`aov`"),
                                                         row["name"].get<std::string>())
                                           : ", " + spell_setting_names("`" + setting + "`"),
                        row["summary"].get<std::string>());
  }
  return text;
}

}  // namespace

std::string channel_list(bool as_json) {
  const ChannelJson rows = channels_as_json();
  return as_json ? rows.dump(2) + "\n" : channels_as_text(rows);
}

}  // namespace emberline
