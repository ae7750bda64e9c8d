#include "renderer/output/frame_info.h"

#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>

#include "io/files/input_file.h"
#include "io/image/encoded_image.h"
#include "io/image/file_completeness.h"
#include "io/image/input.h"
#include "renderer/core/option_values.h"
#include "renderer/core/setting_names.h"
#include "renderer/core/shell_quote.h"
#include "renderer/core/utf8.h"
#include "renderer/output/frame_extension.h"
#include "renderer/output/recorded_settings.h"

namespace emberline {
namespace {

using InfoJson = nlohmann::ordered_json;

constexpr std::string_view kVersionPrefix = "emberline:version:";

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

// Says why the frame cannot be extended. Returns "" if it can.
std::string obstacle_of(const std::string& checkpoint, const RecordedSettings& recorded,
                        bool complete) {
  if (!recorded.text("plan").empty()) return "its sample counts come from a plan";
  if (!file_identity(checkpoint)) {
    return fmt::format(
        "its checkpoint, {}, is missing; render or merge with `resumable` to keep it", checkpoint);
  }
  if (!complete) return "it is not complete; finish it with `resume` first";
  return extension_obstacle(checkpoint, recorded);
}

InfoJson state_json(const std::string& path, const FloatImage& image,
                    const RecordedSettings& recorded) {
  InfoJson state = {{"complete", nullptr},   {"samples", nullptr},  {"samples_per_pixel", nullptr},
                    {"checkpoint", nullptr}, {"extensible", false}, {"obstacle", nullptr}};
  const std::string complete = recorded.text("complete");
  if (complete.empty()) {
    state["obstacle"] = "it has no record of an Emberline frame";
    return state;
  }
  state["complete"] = complete == "true" && is_complete_file(path);
  if (const std::optional<int64_t> samples = parse_integer(recorded.text("samples"))) {
    state["samples"] = *samples;
    state["samples_per_pixel"] = double(*samples) / double(image.data_window.area());
  }
  const std::string checkpoint = checkpoint_beside(path);
  if (file_identity(checkpoint)) state["checkpoint"] = checkpoint;
  const std::string obstacle = obstacle_of(checkpoint, recorded, state["complete"].get<bool>());
  state["extensible"] = obstacle.empty();
  if (!obstacle.empty()) state["obstacle"] = spell_setting_names(obstacle);
  return state;
}

InfoJson frame_json(const std::string& path, const FloatImageRows& file) {
  const FloatImage& image = file.image();
  const RecordedSettings recorded(file.text_attributes());
  const Rect& window = image.data_window;
  InfoJson json = {{"file", path},
                   {"width", image.frame_width},
                   {"height", image.frame_height},
                   {"window", {window.x0, window.y0, window.x1, window.y1}},
                   {"working_space", name_of(working_space_table(), image.space)},
                   {"layers", layers_json(file)},
                   {"unread_parts", unread_parts(image)},
                   {"state", state_json(path, image, recorded)},
                   {"command", recorded.text("command")},
                   {"scene", recorded.text("scene")},
                   {"instruction_sets", recorded.text("instruction-sets")},
                   {"explanation", recorded.text("explanation")},
                   {"settings", InfoJson::object()},
                   {"versions", InfoJson::object()}};
  for (const auto& [attribute, text] : file.text_attributes()) {
    if (!attribute.starts_with(kVersionPrefix)) continue;
    json["versions"][attribute.substr(kVersionPrefix.size())] = text;
  }
  for (const auto& [name, text] : recorded.given()) json["settings"][name] = text;
  return json;
}

std::string printable_text(const InfoJson& text) { return printable(text.get<std::string>()); }

std::string format_state(const std::string& path, const InfoJson& json) {
  const InfoJson& state = json["state"];
  if (state["complete"].is_null()) return "not an Emberline frame\n";
  std::string text = state["complete"].get<bool>() ? "complete" : "not complete";
  if (!state["samples"].is_null()) {
    text += fmt::format(", {} samples ({:.6g} per pixel)", state["samples"].get<int64_t>(),
                        state["samples_per_pixel"].get<double>());
  }
  text += state["extensible"].get<bool>()
              ? fmt::format("\ncan be extended: emberline extend {} {} N\n", shell_quoted(path),
                            spell_setting_names("`spp`"))
              : fmt::format("\ncannot be extended: {}\n", printable_text(state["obstacle"]));
  return text;
}

// Lists the command, the scene and the settings that differ from the defaults.
std::string format_origin(const InfoJson& json) {
  std::string text;
  for (const char* name : {"command", "scene", "explanation"}) {
    if (json[name] == "") continue;
    text += fmt::format("{}\n  {}\n", name, printable_text(json[name]));
  }
  if (json["settings"].empty()) return text;
  text += "settings that differ from the defaults\n";
  for (const auto& [name, value] : json["settings"].items()) {
    text += fmt::format("  {:<20} {}\n", name, printable_text(value));
  }
  return text;
}

std::string format_frame(const std::string& path, const InfoJson& json) {
  const auto window = json["window"].get<std::array<int, 4>>();
  const int width = json["width"].get<int>(), height = json["height"].get<int>();
  std::string text = fmt::format("{}\n{} x {} pixels", printable(path), width, height);
  if (window != std::array{0, 0, width, height}) {
    text += fmt::format(", of which the file has {},{} to {},{}", window[0], window[1], window[2],
                        window[3]);
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
  return text + format_origin(json);
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
