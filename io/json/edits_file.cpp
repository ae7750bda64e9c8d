#include "io/json/edits_file.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "io/files/atomic_file.h"
#include "io/image/input.h"
#include "io/json/input.h"
#include "io/json/reader.h"
#include "renderer/core/errors.h"
#include "renderer/core/names.h"
#include "renderer/description/material_parameters.h"

namespace emberline {
namespace {

// Keeps members in the order in which they were added, so that people can read the file more
// easily.
using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

using namespace edit_limits;
// An f-number is between 1 / kMaxFStop and kMaxFStop. The range is large because the f-number sets
// the lens radius in metres, and scenes can have any scale.
constexpr double kMaxFStop = 1e9;

// Limit on times (in seconds or frames) and on frame rates, as on the command line.
constexpr double kMaxTime = 1e6;

struct Range {
  double minimum = 0.0, maximum = 0.0;
};
constexpr Range kLight = {0.0, kMaxRadiance}, kPosition = {-kMaxDistance, kMaxDistance},
                kLength = {1.0 / kMaxDistance, kMaxDistance};

struct KindName {
  std::string_view name;
  EditedLight kind;
};
constexpr KindName kKinds[] = {{"punctual", EditedLight::kPunctual},
                               {"material", EditedLight::kMaterial},
                               {"environment", EditedLight::kEnvironment}};

// Each members() function lists the members of one kind of edit in file order: the name, the
// variable that holds the value and, for numbers, the valid range. Reading, writing and error
// messages all use these lists.
void members(EditTarget& edit, const auto& member) {
  member("name", edit.name);
  member("index", edit.index);
}

void members(CameraEdit& edit, const auto& member) {
  member("file_camera", edit.camera);
  member("look_from", edit.look_from, kPosition);
  member("look_at", edit.look_at, kPosition);
  member("up", edit.up, Range{-1.0, 1.0});
  member("mirrored", edit.mirrored);
  member("fov_y", edit.fov_y_degrees, Range{0.05, 179.9});
  member("orthographic_height", edit.orthographic_height, kLength);
  member("f_stop", edit.f_stop, Range{1.0 / kMaxFStop, kMaxFStop});
  member("focus_distance", edit.focus_distance, kLength);
}

void members(AnimationEdit& edit, const auto& member) {
  constexpr Range kFrames = {-kMaxTime, kMaxTime};
  member("name", edit.name);
  member("time", edit.time, kFrames);
  member("fps", edit.fps, Range{1e-3, kMaxTime});
  member("shutter_open", edit.shutter_open, kFrames);
  member("shutter_close", edit.shutter_close, kFrames);
}

void members(EnvironmentEdit& edit, const auto& member) {
  member("file", edit.file);
  member("strength", edit.strength, kLight);
  member("rotation", edit.rotation_degrees, Range{-kMaxDegrees, kMaxDegrees});
}

void members(LightEdit& edit, const auto& member) {
  member("kind", edit.kind);
  members(edit.target, member);
  member("intensity", edit.intensity, kLight);
  member("color", edit.color, kLight);
  member("on", edit.on);
}

void members(MaterialEdit& edit, const auto& member) {
  members(edit.target, member);
  for (const MaterialParameter& p : material_parameters()) {
    const Range range = {p.minimum, p.maximum};
    if (p.color) {
      member(p.name, edit.*p.edited_color, range);
    } else {
      member(p.name, edit.*p.edited_number, range);
    }
  }
}

int index(const JsonReader& entry) {
  return int(entry.whole_number(0, std::numeric_limits<int>::max()));
}

void read(const JsonReader& entry, std::string& text, Range) { text = entry.text(); }
void read(const JsonReader& entry, bool& value, Range) { value = entry.boolean(); }
void read(const JsonReader& entry, int& value, Range) { value = index(entry); }
void read(const JsonReader& entry, double& v, Range r) { v = entry.number(r.minimum, r.maximum); }
void read(const JsonReader& entry, float& v, Range r) {
  v = float(entry.number(r.minimum, r.maximum));
}
void read(const JsonReader& entry, Vec3d& v, Range r) { v = entry.vector(r.minimum, r.maximum); }
void read(const JsonReader& entry, Rgb& v, Range r) {
  v = to_float(entry.vector(r.minimum, r.maximum));
}
void read(const JsonReader& entry, EditTarget& target, Range);

void read(const JsonReader& entry, EditedLight& value, Range) {
  const std::string kind = entry.text();
  const auto* named = std::ranges::find(kKinds, kind, &KindName::name);
  if (named == std::end(kKinds)) {
    std::vector<std::string_view> valid;
    for (const KindName& k : kKinds) valid.push_back(k.name);
    throw InputError(entry.place(), unknown_name_message("kind of light", kind, valid));
  }
  value = named->kind;
}

template <typename Value>
void read(const JsonReader& entry, std::optional<Value>& value, Range range) {
  read(entry, value.emplace(), range);
}

template <typename Edit>
Edit read_members(const JsonReader& entry) {
  Edit edit;
  std::vector<std::string_view> names;
  members(edit, [&](std::string_view name, const auto&, Range = {}) { names.push_back(name); });
  entry.object(names);
  members(edit, [&](std::string_view name, auto& value, Range range = {}) {
    if (const std::string member(name); entry.has(member.c_str()))
      read(entry[member], value, range);
  });
  return edit;
}

void check_target(const JsonReader& entry, EditTarget& target) {
  target.place = entry.place();
  if (target.name.empty() && target.index < 0) {
    throw InputError(entry.place(), "expected a \"name\" or an \"index\", or both");
  }
}

void read(const JsonReader& entry, EditTarget& target, Range) {
  target = read_members<EditTarget>(entry);
  check_target(entry, target);
}

CameraEdit read_camera(const JsonReader& entry) {
  CameraEdit edit = read_members<CameraEdit>(entry);
  edit.place = entry.place();
  if (entry.has("look_from") != entry.has("look_at")) {
    throw InputError(entry.place(),
                     "\"look_from\" and \"look_at\" must both be given; one is missing");
  }
  if (entry.has("up") && !edit.look_from) {
    throw InputError(entry.place(), "\"up\" requires \"look_from\" and \"look_at\"");
  }
  if (!(edit.up.length2() > 0)) entry["up"].throw_expected("a non-zero direction");
  if (entry.has("mirrored") && !edit.look_from) {
    throw InputError(entry["mirrored"].place(), "it requires \"look_from\" and \"look_at\"");
  }
  for (const char* const other : {"fov_y", "f_stop"}) {
    if (!entry.has("orthographic_height") || !entry.has(other)) continue;
    throw InputError(entry[other].place(),
                     "this member is not valid for an orthographic view (\"orthographic_height\")");
  }
  return edit;
}

AnimationEdit read_animation(const JsonReader& entry) {
  AnimationEdit edit = read_members<AnimationEdit>(entry);
  edit.place = entry.place();
  if (entry.has("shutter_open") != entry.has("shutter_close")) {
    throw InputError(entry.place(),
                     "\"shutter_open\" and \"shutter_close\" must both be given; one is missing");
  }
  if (edit.shutter_open && !(*edit.shutter_open <= *edit.shutter_close)) {
    throw InputError(entry["shutter_close"].place(), "the shutter closes before it opens");
  }
  return edit;
}

// If `progress` is null, does not read the image.
EnvironmentEdit read_environment_edit(const JsonReader& entry, const std::string& path,
                                      const LoadProgress* progress) {
  EnvironmentEdit edit = read_members<EnvironmentEdit>(entry);
  edit.place = entry.place();
  if (entry.has("file")) {
    const fs::path file = edit.file;
    edit.file = (file.is_absolute() ? file : fs::path(path).parent_path() / file).string();
    if (!progress) return edit;
    try {
      edit.image = read_environment(edit.file, &edit.repaired_texels, *progress);
    } catch (const InputError& error) {
      throw InputError(entry["file"].place(), error.what());
    }
  }
  return edit;
}

LightEdit read_light(const JsonReader& entry) {
  LightEdit edit = read_members<LightEdit>(entry);
  if (!entry.has("kind")) entry["kind"].text();  // throws: the member is missing
  if (edit.kind != EditedLight::kEnvironment) {
    check_target(entry, edit.target);
  } else {
    edit.target.place = entry.place();
    if (entry.has("name") || entry.has("index")) {
      throw InputError(entry.place(), "the environment takes no \"name\" or \"index\"");
    }
  }
  return edit;
}

MaterialEdit read_material(const JsonReader& entry) {
  MaterialEdit edit = read_members<MaterialEdit>(entry);
  check_target(entry, edit.target);
  return edit;
}

void check_version(const JsonReader& root) {
  if (!root.has("emberline_edits")) {
    throw InputError(root.place(),
                     "the member \"emberline_edits\": {} is missing, so this is not an edits file",
                     kEditsVersion);
  }
  const JsonReader version = root["emberline_edits"];
  if (index(version) != kEditsVersion) {
    throw InputError(version.place(), "the edits have version {}; this program reads version {}",
                     index(version), kEditsVersion);
  }
}

// Returns the shortest decimal that reads back as the same float: 0.1, not 0.10000000149011612.
Json number(float value) {
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  double shortest = 0.0;
  std::from_chars(text.data(), end, shortest);
  return float(shortest) == value ? shortest : double(value);
}

Json value_json(const std::string& text) { return text.empty() ? Json() : Json(text); }
Json value_json(bool value) { return value; }
Json value_json(int index) { return index < 0 ? Json() : Json(index); }
Json value_json(double value) { return value; }
Json value_json(float value) { return number(value); }
Json value_json(const Vec3d& v) { return {v.x, v.y, v.z}; }
Json value_json(const Rgb& c) { return {number(c.x), number(c.y), number(c.z)}; }
Json value_json(EditedLight kind) { return std::ranges::find(kKinds, kind, &KindName::kind)->name; }
Json value_json(const EditTarget& target);
template <typename Value>
Json value_json(const std::optional<Value>& value) {
  return value ? value_json(*value) : Json();
}

// Takes `edit` by value, since members() needs a mutable object.
template <typename Edit>
Json object_json(Edit edit) {
  Json object = Json::object();
  members(edit, [&](std::string_view name, const auto& value, Range = {}) {
    Json member = value_json(value);
    if (!member.is_null()) object[std::string(name)] = std::move(member);
  });
  return object;
}

Json value_json(const EditTarget& target) { return object_json(target); }

Json camera_json(const CameraEdit& edit) {
  Json object = object_json(edit);
  if (!edit.look_from) object.erase("up");
  if (!edit.mirrored) object.erase("mirrored");
  return object;
}

Json environment_json(const EnvironmentEdit& edit, const std::string& path) {
  Json object = object_json(edit);
  if (const fs::path file = edit.file; file.is_relative() && !file.empty()) {
    object["file"] = fs::proximate(file, fs::absolute(path).parent_path()).generic_string();
  }
  return object;
}

SceneEdits convert_edits(const nlohmann::json& document, const std::string& path,
                         const LoadProgress* progress) {
  const JsonReader root(document, path);
  check_version(root);  // comes first, since another version may have other members
  root.object(
      {"emberline_edits", "camera", "animation", "variant", "environment", "lights", "materials"});
  SceneEdits edits;
  if (root.has("camera")) edits.camera = read_camera(root["camera"]);
  if (root.has("animation")) edits.animation = read_animation(root["animation"]);
  if (root.has("variant")) read(root["variant"], edits.variant, {});
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

std::string text_of(const SceneEdits& edits, Json environment) {
  Json object = {{"emberline_edits", kEditsVersion}};
  const auto put = [&object](const char* name, Json value) {
    if (!value.empty()) object[name] = std::move(value);
  };
  put("camera", camera_json(edits.camera));
  put("animation", object_json(edits.animation));
  if (edits.variant) put("variant", object_json(*edits.variant));
  put("environment", std::move(environment));
  Json lights = Json::array(), materials = Json::array();
  for (const LightEdit& edit : edits.lights) lights.push_back(object_json(edit));
  for (const MaterialEdit& edit : edits.materials) materials.push_back(object_json(edit));
  put("lights", std::move(lights));
  put("materials", std::move(materials));
  return object.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

SceneEdits read_edits(const std::string& path, const LoadProgress& progress) {
  return convert_edits(read_json(path, progress), path, &progress);
}

SceneEdits parse_edits(std::string_view text, const std::string& name,
                       const LoadProgress& progress) {
  return convert_edits(parse_json(text, name, DuplicateMembers::kReject, progress), name,
                       &progress);
}

SceneEdits edits_from_json(const nlohmann::json& document, const std::string& name) {
  return convert_edits(document, name, nullptr);
}

std::string format_edits(const SceneEdits& edits) {
  return text_of(edits, object_json(edits.environment));
}

void write_edits(const std::string& path, const SceneEdits& edits) {
  write_file_atomically(path, text_of(edits, environment_json(edits.environment, path)));
}

}  // namespace emberline
