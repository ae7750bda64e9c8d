#include "renderer/output/frame_info.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "io/files/input_file.h"
#include "io/image/encoded_image.h"
#include "io/image/file_completeness.h"
#include "io/image/input.h"
#include "renderer/core/option_values.h"
#include "renderer/core/setting_names.h"
#include "renderer/core/utf8.h"
#include "renderer/engine/setting_table.h"
#include "renderer/output/frame_extension.h"

namespace emberline {
namespace {

using InfoJson = nlohmann::ordered_json;

constexpr std::string_view kOurPrefix = "emberline:", kVersionPrefix = "version:";
// Attributes that are not settings.
constexpr std::array<std::string_view, 3> kStateNames = {"complete", "samples", "clamped"};

const char* type_name(ChannelType type) {
  return type == ChannelType::kUint ? "uint" : type == ChannelType::kHalf ? "half" : "float";
}

InfoJson layers_json(const FloatImageRows& file) {
  const FloatImage& image = file.image();
  InfoJson list = InfoJson::array();
  for (const ImageLayer& layer : image_layers(image.channel_names, image.parts)) {
    std::vector<int> indices = layer.channels;
    if (layer.alpha >= 0) indices.push_back(layer.alpha);
    InfoJson channels = InfoJson::array();
    for (const int c : indices) {
      channels.push_back({{"name", image.channel_names[size_t(c)]},
                          {"type", type_name(file.channel_type(size_t(c)))}});
    }
    list.push_back({{"name", layer.name}, {"channels", channels}});
  }
  return list;
}

InfoJson unread_parts(const FloatImage& image) {
  InfoJson list = InfoJson::array();
  for (const ImagePart& part : image.parts) {
    if (part.first < 0) list.push_back(part.name);
  }
  return list;
}

// Values are padded with blanks (outputs.h).
std::string text_of(const FloatImageRows& file, std::string_view name) {
  for (const auto& [attribute, text] : file.text_attributes()) {
    if (attribute.starts_with(kOurPrefix) && attribute.substr(kOurPrefix.size()) == name) {
      return text.substr(0, text.find_last_not_of(' ') + 1);
    }
  }
  return "";
}

InfoJson state_json(const std::string& path, const FloatImageRows& file) {
  const FloatImage& image = file.image();
  InfoJson state = {{"complete", nullptr},   {"samples", nullptr},  {"samples_per_pixel", nullptr},
                    {"checkpoint", nullptr}, {"extensible", false}, {"obstacle", nullptr}};
  const std::string complete = text_of(file, "complete");
  if (complete.empty()) {
    state["obstacle"] = "it has no record of an Emberline frame";
    return state;
  }
  state["complete"] = complete == "true" && is_complete_file(path);
  if (const std::optional<int64_t> samples = parse_integer(text_of(file, "samples"))) {
    state["samples"] = *samples;
    state["samples_per_pixel"] = double(*samples) / double(image.data_window.area());
  }
  const std::string checkpoint = checkpoint_beside(path);
  if (!file_identity(checkpoint)) {
    state["obstacle"] =
        spell_setting_names(fmt::format("there is no {}, which `resumable` keeps", checkpoint));
    return state;
  }
  state["checkpoint"] = checkpoint;
  const std::string obstacle = extension_obstacle(checkpoint);
  state["extensible"] = obstacle.empty();
  if (!obstacle.empty()) state["obstacle"] = obstacle;
  return state;
}

InfoJson frame_json(const std::string& path, const FloatImageRows& file) {
  const FloatImage& image = file.image();
  const Rect& window = image.data_window;
  InfoJson json = {{"file", path},
                   {"width", image.frame_width},
                   {"height", image.frame_height},
                   {"window", {window.x0, window.y0, window.x1, window.y1}},
                   {"working_space", name_of(working_space_table(), image.space)},
                   {"layers", layers_json(file)},
                   {"unread_parts", unread_parts(image)},
                   {"state", state_json(path, file)},
                   {"settings", InfoJson::object()},
                   {"versions", InfoJson::object()}};
  for (const auto& [attribute, text] : file.text_attributes()) {
    if (!attribute.starts_with(kOurPrefix)) continue;
    const std::string name = attribute.substr(kOurPrefix.size());
    if (std::ranges::find(kStateNames, name) != kStateNames.end()) continue;
    const bool is_version = name.starts_with(kVersionPrefix);
    json[is_version ? "versions" : "settings"]
        [is_version ? name.substr(kVersionPrefix.size()) : name] = text;
  }
  return json;
}

std::string printable_text(const InfoJson& text) { return printable(text.get<std::string>()); }

std::string format_state(const std::string& path, const InfoJson& json) {
  const InfoJson& state = json["state"];
  if (state["complete"].is_null()) return "not a frame of Emberline\n";
  std::string text = state["complete"].get<bool>() ? "complete" : "not complete";
  if (!state["samples"].is_null()) {
    text += fmt::format(", {} samples ({:.6g} per pixel)", state["samples"].get<int64_t>(),
                        state["samples_per_pixel"].get<double>());
  }
  text += state["extensible"].get<bool>()
              ? fmt::format("\ncan be extended: emberline extend {} {} N\n", printable(path),
                            spell_setting_names("`spp`"))
              : fmt::format("\ncannot be extended: {}\n", printable_text(state["obstacle"]));
  return text;
}

// The settings that differ from the defaults.
std::string format_settings(const InfoJson& settings) {
  const FrameSettings defaults;
  std::string text;
  for (const auto& [attribute, value] : settings.items()) {
    std::string name = attribute;
    std::ranges::replace(name, '_', '-');
    const Setting* const setting = find_setting(name);
    if (setting && setting->text(defaults) == value.get<std::string>()) continue;
    text += fmt::format("  {:<20} {}\n", printable(name), printable_text(value));
  }
  return text.empty() ? "" : "settings that differ from the defaults\n" + text;
}

std::string format_frame(const std::string& path, const InfoJson& json) {
  const auto window = json["window"].get<std::array<int, 4>>();
  const int width = json["width"].get<int>(), height = json["height"].get<int>();
  std::string text = fmt::format("{}\n{} x {} pixels", printable(path), width, height);
  if (window != std::array{0, 0, width, height}) {
    text +=
        fmt::format(", of which it has {},{} to {},{}", window[0], window[1], window[2], window[3]);
  }
  text += fmt::format(", {}\n{}layers\n", printable_text(json["working_space"]),
                      format_state(path, json));
  for (const InfoJson& layer : json["layers"]) {
    std::string names, type;
    for (const InfoJson& channel : layer["channels"]) {
      const std::string next = channel["type"];
      names += fmt::format("{}{}", names.empty() ? "" : " ", printable_text(channel["name"]));
      if (type.find(next) == std::string::npos) {
        type += fmt::format("{}{}", type.empty() ? "" : ", ", next);
      }
    }
    text += fmt::format("  {:<20} {} ({})\n", printable_text(layer["name"]), names, type);
  }
  for (const InfoJson& part : json["unread_parts"]) {
    text += fmt::format(
        "  part {}: not read, since it differs from the first in size or repeats "
        "its channels\n",
        printable_text(part));
  }
  return text + format_settings(json["settings"]);
}

}  // namespace

bool is_exr_file(const std::string& path) {
  const std::optional<InputFile> file = InputFile::try_open(path);
  if (!file) return false;
  std::array<uint8_t, 12> magic = {};
  const int64_t got = file->try_read(0, magic.size(), magic.data());
  return got > 0 && sniff_image_format(std::span(magic).first(size_t(got))) == ImageFormat::kExr;
}

std::string frame_info(const std::string& path, const LoadProgress& progress, bool as_json) {
  const FloatImageRows file(path, progress);
  const InfoJson json = frame_json(path, file);
  return as_json ? json.dump(2, ' ', false, InfoJson::error_handler_t::replace) + "\n"
                 : format_frame(path, json);
}

}  // namespace emberline
