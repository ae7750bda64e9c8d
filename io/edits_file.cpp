#include "io/edits_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string_view>

#include "io/atomic_file.h"
#include "io/image_input.h"
#include "renderer/core/errors.h"
#include "renderer/core/names.h"

namespace emberline {
namespace {

// In the order in which they are written, for people to read.
using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

// The ends of the ranges, as the command line has them for its own options: squares of distances
// stay finite in float, and so does radiance times what a film sums up.
constexpr double kFarthest = 1e15;
constexpr double kBrightest = 1e9;
constexpr double kMostTurns = 36000.0;  // degrees
constexpr double kMostOfLens = 1e9;     // f-numbers, to either side: scenes come in any size
constexpr double kMostNormalScale = 1000.0;

struct KindName {
  std::string_view name;
  EditedLight kind;
};
constexpr KindName kKinds[] = {{"punctual", EditedLight::kPunctual},
                               {"material", EditedLight::kMaterial},
                               {"environment", EditedLight::kEnvironment}};

std::string shortened_dump(const Json& value) {
  const std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  return text.size() <= 40 ? text : text.substr(0, 37) + "...";
}

// A value of the file and where it stands: what is read of it is checked as it is read.
class Reader {
 public:
  Reader(const Json& json, std::string place) : json_(json), place_(std::move(place)) {}

  const std::string& place() const { return place_; }

  // An object with none but these members.
  const Reader& object(std::initializer_list<std::string_view> members) const {
    if (!json_.is_object()) expected("an object");
    for (const auto& [key, value] : json_.items()) {
      if (std::ranges::find(members, key) != members.end()) continue;
      throw InputError(place_ + "/" + key,
                       unknown_name_message("member", key, {members.begin(), members.size()}));
    }
    return *this;
  }
  bool has(const char* member) const { return json_.contains(member); }
  Reader operator[](const char* member) const {
    return {json_.at(member), place_ + "/" + std::string(member)};
  }
  std::vector<Reader> array() const {
    if (!json_.is_array()) expected("an array");
    std::vector<Reader> elements;
    for (size_t i = 0; i < json_.size(); ++i) {
      elements.emplace_back(json_[i], place_ + "/" + std::to_string(i));
    }
    return elements;
  }

  double number(double least, double most) const {
    const double value = json_.is_number() ? json_.get<double>() : std::nan("");
    if (!(value >= least && value <= most)) {
      expected(fmt::format("a number from {} to {}", least, most));
    }
    return value;
  }
  float factor(double most) const { return float(number(0.0, most)); }
  int index() const {
    if (!json_.is_number_integer() || json_ < 0 || json_ > std::numeric_limits<int>::max()) {
      expected("an index: a whole number from 0");
    }
    return json_.get<int>();
  }
  bool boolean() const {
    if (!json_.is_boolean()) expected("true or false");
    return json_.get<bool>();
  }
  std::string text() const {
    if (!json_.is_string()) expected("a text");
    return json_.get<std::string>();
  }
  Vec3d vector(double least, double most) const {
    if (!json_.is_array() || json_.size() != 3) expected("an array of 3 numbers");
    const std::vector<Reader> c = array();
    return {c[0].number(least, most), c[1].number(least, most), c[2].number(least, most)};
  }
  Rgb color(double most) const { return to_float(vector(0.0, most)); }

  [[noreturn]] void expected(const std::string& what) const {
    throw InputError(place_, "expected " + what + ", found " + shortened_dump(json_));
  }

 private:
  const Json& json_;
  std::string place_;  // "file#/json/pointer"
};

EditTarget read_target(const Reader& entry) {
  EditTarget target;
  target.place = entry.place();
  if (entry.has("name")) target.name = entry["name"].text();
  if (entry.has("index")) target.index = entry["index"].index();
  if (target.name.empty() && target.index < 0) {
    throw InputError(entry.place(), "expected a \"name\" or an \"index\", or both");
  }
  return target;
}

CameraEdit read_camera(const Reader& entry) {
  entry.object({"file_camera", "look_from", "look_at", "up", "mirrored", "fov_y",
                "orthographic_height", "f_stop", "focus_distance"});
  CameraEdit edit;
  edit.place = entry.place();
  if (entry.has("file_camera")) {
    edit.camera = read_target(entry["file_camera"].object({"name", "index"}));
  }
  if (entry.has("look_from") != entry.has("look_at")) {
    throw InputError(entry.place(), "\"look_from\" and \"look_at\" go together; one is missing");
  }
  if (entry.has("look_from")) {
    edit.look_from = entry["look_from"].vector(-kFarthest, kFarthest);
    edit.look_at = entry["look_at"].vector(-kFarthest, kFarthest);
  }
  if (entry.has("up")) {
    if (!edit.look_from) {
      throw InputError(entry.place(), "\"up\" is for a view with \"look_from\" and \"look_at\"");
    }
    edit.up = entry["up"].vector(-1.0, 1.0);
    if (!(edit.up.length2() > 0)) entry["up"].expected("a direction");
  }
  if (entry.has("mirrored")) {
    if (!edit.look_from) {
      throw InputError(entry["mirrored"].place(),
                       "it is for a view with \"look_from\" and \"look_at\"");
    }
    edit.mirrored = entry["mirrored"].boolean();
  }
  if (entry.has("orthographic_height")) {
    for (const char* const other : {"fov_y", "f_stop"}) {
      if (!entry.has(other)) continue;
      throw InputError(entry[other].place(),
                       "an orthographic view, with \"orthographic_height\", has none");
    }
    edit.orthographic_height = entry["orthographic_height"].number(1.0 / kFarthest, kFarthest);
  }
  if (entry.has("fov_y")) edit.fov_y_degrees = entry["fov_y"].number(0.05, 179.9);
  if (entry.has("f_stop")) edit.f_stop = entry["f_stop"].number(1.0 / kMostOfLens, kMostOfLens);
  if (entry.has("focus_distance")) {
    edit.focus_distance = entry["focus_distance"].number(1.0 / kFarthest, kFarthest);
  }
  return edit;
}

EnvironmentEdit read_environment_edit(const Reader& entry, const std::string& path) {
  entry.object({"file", "strength", "rotation"});
  EnvironmentEdit edit;
  edit.place = entry.place();
  if (entry.has("strength")) edit.strength = entry["strength"].factor(kBrightest);
  if (entry.has("rotation")) {
    edit.rotation_degrees = float(entry["rotation"].number(-kMostTurns, kMostTurns));
  }
  if (entry.has("file")) {
    const fs::path file = entry["file"].text();
    edit.file = (file.is_absolute() ? file : fs::path(path).parent_path() / file).string();
    try {
      edit.image = read_environment(edit.file, &edit.repaired_texels);
    } catch (const InputError& error) {
      throw InputError(entry["file"].place(), error.what());
    }
  }
  return edit;
}

LightEdit read_light(const Reader& entry) {
  entry.object({"kind", "name", "index", "intensity", "color", "on"});
  LightEdit edit;
  if (!entry.has("kind")) throw InputError(entry.place(), "\"kind\" is missing");
  const std::string kind = entry["kind"].text();
  const auto* named = std::ranges::find(kKinds, kind, &KindName::name);
  if (named == std::end(kKinds)) {
    std::vector<std::string_view> valid;
    for (const KindName& k : kKinds) valid.push_back(k.name);
    throw InputError(entry["kind"].place(), unknown_name_message("kind of light", kind, valid));
  }
  edit.kind = named->kind;
  if (edit.kind != EditedLight::kEnvironment) {
    edit.target = read_target(entry);
  } else {
    edit.target.place = entry.place();
    if (entry.has("name") || entry.has("index")) {
      throw InputError(entry.place(), "there is one environment, without \"name\" or \"index\"");
    }
  }
  if (entry.has("intensity")) edit.intensity = entry["intensity"].factor(kBrightest);
  if (entry.has("color")) edit.color = entry["color"].color(kBrightest);
  if (entry.has("on")) edit.on = entry["on"].boolean();
  return edit;
}

MaterialEdit read_material(const Reader& entry) {
  entry.object({"name", "index", "base_color", "roughness", "metallic", "emission", "transmission",
                "normal_scale"});
  MaterialEdit edit;
  edit.target = read_target(entry);
  if (entry.has("base_color")) edit.base_color = entry["base_color"].color(1.0);
  if (entry.has("roughness")) edit.roughness = entry["roughness"].factor(1.0);
  if (entry.has("metallic")) edit.metallic = entry["metallic"].factor(1.0);
  if (entry.has("emission")) edit.emission = entry["emission"].color(kBrightest);
  if (entry.has("transmission")) edit.transmission = entry["transmission"].factor(1.0);
  if (entry.has("normal_scale")) {
    edit.normal_scale = float(entry["normal_scale"].number(-kMostNormalScale, kMostNormalScale));
  }
  return edit;
}

// JSON lets a later member of the same name win in silence: the one that somebody forgot about.
class DuplicateFinder {
 public:
  explicit DuplicateFinder(const std::string& file) : file_(file) {}
  bool operator()(int /*depth*/, Json::parse_event_t event, Json& parsed) {
    if (event == Json::parse_event_t::object_start) members_.emplace_back();
    if (event == Json::parse_event_t::object_end) members_.pop_back();
    if (event == Json::parse_event_t::key) {
      const std::string key = parsed.get<std::string>();
      if (std::ranges::find(members_.back(), key) != members_.back().end()) {
        throw InputError(file_, "member \"" + key + "\" stands twice in one object");
      }
      members_.back().push_back(key);
    }
    return true;
  }

 private:
  const std::string& file_;
  std::vector<std::vector<std::string>> members_;  // so far, of the objects that are open
};

Json parse(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  if (!file || !(text << file.rdbuf())) {
    throw InputError(path, "cannot be read; is it there, a file, and not empty?");
  }
  try {
    return Json::parse(text.str(), DuplicateFinder(path));
  } catch (const Json::parse_error& error) {
    // "[json.exception.parse_error.101] parse error at line 3, column 7: ..."
    const std::string_view what = error.what();
    const size_t end = what.find("] ");
    throw InputError(path,
                     std::string(end == std::string_view::npos ? what : what.substr(end + 2)));
  }
}

void check_version(const Reader& root) {
  if (!root.has("emberline_edits")) {
    throw InputError(root.place(), fmt::format("\"emberline_edits\": {} is missing: not a file of "
                                               "edits",
                                               kEditsVersion));
  }
  const Reader version = root["emberline_edits"];
  if (version.index() != kEditsVersion) {
    throw InputError(version.place(), fmt::format("version {} of edits; this program reads {}",
                                                  version.index(), kEditsVersion));
  }
}

// ---- out ----------------------------------------------------------------------------------------

// The shortest number that reads back as the same float: 0.1, not 0.10000000149011612.
Json number(float value) {
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  double shortest = 0.0;
  std::from_chars(text.data(), end, shortest);
  return float(shortest) == value ? shortest : double(value);
}

Json vector(const Vec3d& v) { return {v.x, v.y, v.z}; }
Json color(const Rgb& c) { return {number(c.x), number(c.y), number(c.z)}; }

Json target_json(const EditTarget& target) {
  Json json = Json::object();
  if (!target.name.empty()) json["name"] = target.name;
  if (target.index >= 0) json["index"] = target.index;
  return json;
}

Json camera_json(const CameraEdit& edit) {
  Json json = Json::object();
  if (edit.camera) json["file_camera"] = target_json(*edit.camera);
  if (edit.look_from && edit.look_at) {
    json["look_from"] = vector(*edit.look_from);
    json["look_at"] = vector(*edit.look_at);
    json["up"] = vector(edit.up);
    if (edit.mirrored) json["mirrored"] = true;
  }
  if (edit.orthographic_height) json["orthographic_height"] = *edit.orthographic_height;
  if (edit.fov_y_degrees) json["fov_y"] = *edit.fov_y_degrees;
  if (edit.f_stop) json["f_stop"] = *edit.f_stop;
  if (edit.focus_distance) json["focus_distance"] = *edit.focus_distance;
  return json;
}

Json environment_json(const EnvironmentEdit& edit, const std::string& path) {
  Json json = Json::object();
  if (!edit.file.empty()) {
    const fs::path file = edit.file;
    json["file"] = file.is_absolute()
                       ? file.string()
                       : fs::proximate(file, fs::absolute(path).parent_path()).generic_string();
  }
  if (edit.strength) json["strength"] = number(*edit.strength);
  if (edit.rotation_degrees) json["rotation"] = number(*edit.rotation_degrees);
  return json;
}

Json light_json(const LightEdit& edit) {
  Json json = {{"kind", std::ranges::find(kKinds, edit.kind, &KindName::kind)->name}};
  json.update(target_json(edit.target));
  json["intensity"] = number(edit.intensity);
  json["color"] = color(edit.color);
  json["on"] = edit.on;
  return json;
}

Json material_json(const MaterialEdit& edit) {
  Json json = target_json(edit.target);
  const auto put = [&json](const char* name, const std::optional<float>& value) {
    if (value) json[name] = number(*value);
  };
  if (edit.base_color) json["base_color"] = color(*edit.base_color);
  put("roughness", edit.roughness);
  put("metallic", edit.metallic);
  if (edit.emission) json["emission"] = color(*edit.emission);
  put("transmission", edit.transmission);
  put("normal_scale", edit.normal_scale);
  return json;
}

}  // namespace

SceneEdits read_edits(const std::string& path) {
  const Json json = parse(path);
  const Reader root(json, path + "#");
  if (!json.is_object()) root.expected("an object");
  check_version(root);  // before the members: another version may have others
  root.object({"emberline_edits", "camera", "variant", "environment", "lights", "materials"});
  SceneEdits edits;
  if (root.has("camera")) edits.camera = read_camera(root["camera"]);
  if (root.has("variant")) edits.variant = read_target(root["variant"].object({"name", "index"}));
  if (root.has("environment")) {
    edits.environment = read_environment_edit(root["environment"], path);
  }
  if (root.has("lights")) {
    for (const Reader& entry : root["lights"].array()) edits.lights.push_back(read_light(entry));
  }
  if (root.has("materials")) {
    for (const Reader& entry : root["materials"].array()) {
      edits.materials.push_back(read_material(entry));
    }
  }
  return edits;
}

void write_edits(const std::string& path, const SceneEdits& edits) {
  Json json = {{"emberline_edits", kEditsVersion}};
  const auto put = [&json](const char* name, Json value) {
    if (!value.empty()) json[name] = std::move(value);
  };
  put("camera", camera_json(edits.camera));
  if (edits.variant) put("variant", target_json(*edits.variant));
  put("environment", environment_json(edits.environment, path));
  Json lights = Json::array(), materials = Json::array();
  for (const LightEdit& edit : edits.lights) lights.push_back(light_json(edit));
  for (const MaterialEdit& edit : edits.materials) materials.push_back(material_json(edit));
  put("lights", std::move(lights));
  put("materials", std::move(materials));
  write_file_atomically(path, json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace emberline
