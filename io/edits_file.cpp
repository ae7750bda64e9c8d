#include "io/edits_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string_view>

#include "io/atomic_file.h"
#include "io/image_input.h"
#include "io/json_input.h"
#include "io/json_reader.h"
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

float factor(const JsonReader& entry, double most) { return float(entry.number(0.0, most)); }
Rgb color(const JsonReader& entry, double most) { return to_float(entry.vector(0.0, most)); }
int index(const JsonReader& entry) { return int(entry.whole(0, std::numeric_limits<int>::max())); }

EditTarget read_target(const JsonReader& entry) {
  EditTarget target;
  target.place = entry.place();
  if (entry.has("name")) target.name = entry["name"].text();
  if (entry.has("index")) target.index = index(entry["index"]);
  if (target.name.empty() && target.index < 0) {
    throw InputError(entry.place(), "expected a \"name\" or an \"index\", or both");
  }
  return target;
}

CameraEdit read_camera(const JsonReader& entry) {
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

EnvironmentEdit read_environment_edit(const JsonReader& entry, const std::string& path,
                                      const LoadProgress& progress) {
  entry.object({"file", "strength", "rotation"});
  EnvironmentEdit edit;
  edit.place = entry.place();
  if (entry.has("strength")) edit.strength = factor(entry["strength"], kBrightest);
  if (entry.has("rotation")) {
    edit.rotation_degrees = float(entry["rotation"].number(-kMostTurns, kMostTurns));
  }
  if (entry.has("file")) {
    const fs::path file = entry["file"].text();
    edit.file = (file.is_absolute() ? file : fs::path(path).parent_path() / file).string();
    try {
      edit.image = read_environment(edit.file, &edit.repaired_texels, progress);
    } catch (const InputError& error) {
      throw InputError(entry["file"].place(), error.what());
    }
  }
  return edit;
}

LightEdit read_light(const JsonReader& entry) {
  entry.object({"kind", "name", "index", "intensity", "color", "on"});
  LightEdit edit;
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
  if (entry.has("intensity")) edit.intensity = factor(entry["intensity"], kBrightest);
  if (entry.has("color")) edit.color = color(entry["color"], kBrightest);
  if (entry.has("on")) edit.on = entry["on"].boolean();
  return edit;
}

MaterialEdit read_material(const JsonReader& entry) {
  entry.object({"name", "index", "base_color", "roughness", "metallic", "emission", "transmission",
                "normal_scale"});
  MaterialEdit edit;
  edit.target = read_target(entry);
  if (entry.has("base_color")) edit.base_color = color(entry["base_color"], 1.0);
  if (entry.has("roughness")) edit.roughness = factor(entry["roughness"], 1.0);
  if (entry.has("metallic")) edit.metallic = factor(entry["metallic"], 1.0);
  if (entry.has("emission")) edit.emission = color(entry["emission"], kBrightest);
  if (entry.has("transmission")) edit.transmission = factor(entry["transmission"], 1.0);
  if (entry.has("normal_scale")) {
    edit.normal_scale = float(entry["normal_scale"].number(-kMostNormalScale, kMostNormalScale));
  }
  return edit;
}

void check_version(const JsonReader& root) {
  if (!root.has("emberline_edits")) {
    throw InputError(root.place(), fmt::format("\"emberline_edits\": {} is missing: not a file of "
                                               "edits",
                                               kEditsVersion));
  }
  const JsonReader version = root["emberline_edits"];
  if (index(version) != kEditsVersion) {
    throw InputError(version.place(), fmt::format("version {} of edits; this program reads {}",
                                                  index(version), kEditsVersion));
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
  Json object = Json::object();
  if (!target.name.empty()) object["name"] = target.name;
  if (target.index >= 0) object["index"] = target.index;
  return object;
}

Json camera_json(const CameraEdit& edit) {
  Json object = Json::object();
  if (edit.camera) object["file_camera"] = target_json(*edit.camera);
  if (edit.look_from && edit.look_at) {
    object["look_from"] = vector(*edit.look_from);
    object["look_at"] = vector(*edit.look_at);
    object["up"] = vector(edit.up);
    if (edit.mirrored) object["mirrored"] = true;
  }
  if (edit.orthographic_height) object["orthographic_height"] = *edit.orthographic_height;
  if (edit.fov_y_degrees) object["fov_y"] = *edit.fov_y_degrees;
  if (edit.f_stop) object["f_stop"] = *edit.f_stop;
  if (edit.focus_distance) object["focus_distance"] = *edit.focus_distance;
  return object;
}

Json environment_json(const EnvironmentEdit& edit, const std::string& path) {
  Json object = Json::object();
  if (!edit.file.empty()) {
    const fs::path file = edit.file;
    object["file"] = file.is_absolute()
                         ? file.string()
                         : fs::proximate(file, fs::absolute(path).parent_path()).generic_string();
  }
  if (edit.strength) object["strength"] = number(*edit.strength);
  if (edit.rotation_degrees) object["rotation"] = number(*edit.rotation_degrees);
  return object;
}

Json light_json(const LightEdit& edit) {
  Json object = {{"kind", std::ranges::find(kKinds, edit.kind, &KindName::kind)->name}};
  object.update(target_json(edit.target));
  object["intensity"] = number(edit.intensity);
  object["color"] = color(edit.color);
  object["on"] = edit.on;
  return object;
}

Json material_json(const MaterialEdit& edit) {
  Json object = target_json(edit.target);
  const auto put = [&object](const char* name, const std::optional<float>& value) {
    if (value) object[name] = number(*value);
  };
  if (edit.base_color) object["base_color"] = color(*edit.base_color);
  put("roughness", edit.roughness);
  put("metallic", edit.metallic);
  if (edit.emission) object["emission"] = color(*edit.emission);
  put("transmission", edit.transmission);
  put("normal_scale", edit.normal_scale);
  return object;
}

SceneEdits edits_of(const nlohmann::json& document, const std::string& path,
                    const LoadProgress& progress) {
  const JsonReader root(document, path);
  check_version(root);  // before the members: another version may have others
  root.object({"emberline_edits", "camera", "variant", "environment", "lights", "materials"});
  SceneEdits edits;
  if (root.has("camera")) edits.camera = read_camera(root["camera"]);
  if (root.has("variant")) edits.variant = read_target(root["variant"].object({"name", "index"}));
  if (root.has("environment")) {
    edits.environment = read_environment_edit(root["environment"], path, progress);
  }
  if (root.has("lights")) {
    const JsonReader lights = root["lights"];
    for (size_t i = 0; i < lights.size(); ++i) edits.lights.push_back(read_light(lights[i]));
  }
  if (root.has("materials")) {
    const JsonReader materials = root["materials"];
    for (size_t i = 0; i < materials.size(); ++i) {
      edits.materials.push_back(read_material(materials[i]));
    }
  }
  return edits;
}

}  // namespace

SceneEdits read_edits(const std::string& path, const LoadProgress& progress) {
  return edits_of(read_json(path, progress), path, progress);
}

SceneEdits parse_edits(std::string_view text, const std::string& name,
                       const LoadProgress& progress) {
  return edits_of(parse_json(text, name, DuplicateMembers::kRefused, progress), name, progress);
}

void write_edits(const std::string& path, const SceneEdits& edits) {
  Json object = {{"emberline_edits", kEditsVersion}};
  const auto put = [&object](const char* name, Json value) {
    if (!value.empty()) object[name] = std::move(value);
  };
  put("camera", camera_json(edits.camera));
  if (edits.variant) put("variant", target_json(*edits.variant));
  put("environment", environment_json(edits.environment, path));
  Json lights = Json::array(), materials = Json::array();
  for (const LightEdit& edit : edits.lights) lights.push_back(light_json(edit));
  for (const MaterialEdit& edit : edits.materials) materials.push_back(material_json(edit));
  put("lights", std::move(lights));
  put("materials", std::move(materials));
  write_file_atomically(path, object.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace emberline
