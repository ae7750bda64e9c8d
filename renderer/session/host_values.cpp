#include "renderer/session/host_values.h"

#include <nlohmann/json.hpp>

#include "io/json/edits_file.h"
#include "io/json/reader.h"
#include "renderer/core/errors.h"
#include "renderer/session/view_camera.h"

namespace emberline {
namespace {

using nlohmann::json;

json json_of(const Vec3d& v) { return {v.x, v.y, v.z}; }

// Replaces the camera's "matrix" by look_from, look_at, up and mirrored.
json expand_matrix(json camera, const std::string& name) {
  const json document = {{"camera", camera}};
  const JsonReader matrix = JsonReader(document, name)["camera"]["matrix"];
  for (const char* const other : {"look_from", "look_at", "up", "mirrored"}) {
    if (camera.contains(other))
      matrix.throw_expected(
          "either \"matrix\" or \"look_from\", \"look_at\", \"up\" and \"mirrored\"");
  }
  if (matrix.size() != 16) matrix.throw_expected("16 numbers");
  // The matrix is column-major with column vectors, as in glTF. Imath uses row vectors, so a
  // column here becomes a row there.
  const auto row = [&](size_t i) {
    const auto number = [&](size_t k) {
      return matrix[4 * i + k].number(-edit_limits::kMaxDistance, edit_limits::kMaxDistance);
    };
    return Vec3d(number(0), number(1), number(2));
  };
  const Vec3d right = row(0), up = row(1).normalized(), back = row(2).normalized(), eye = row(3);
  if (!(right.length() > 0 && up.length() > 0 && back.length() > 0 &&
        up.cross(back).length() > 0)) {
    matrix.throw_expected("a matrix whose axes are neither zero nor parallel");
  }
  camera.erase("matrix");
  camera["look_from"] = json_of(eye);
  camera["look_at"] = json_of(eye - back);
  camera["up"] = json_of(up);
  if (right.dot(up.cross(back)) < 0) camera["mirrored"] = true;
  return camera;
}

template <class Edit, class Same>
void replace_entries(std::vector<Edit>& list, const std::vector<Edit>& changes, const Same& same) {
  for (const Edit& change : changes) {
    std::erase_if(list, [&](const Edit& edit) { return same(edit, change); });
    list.push_back(change);
  }
}

template <class Named>
bool same_entry(const EditTarget& a, const EditTarget& b, const std::vector<Named>& list) {
  const auto first = find_entry(a, list), second = find_entry(b, list);
  return first || second ? first == second : a == b;
}

void merge_lists(const SceneEdits& changes, const SceneDescription& lists, SceneEdits& edits) {
  replace_entries(edits.materials, changes.materials,
                  [&](const MaterialEdit& a, const MaterialEdit& b) {
                    return same_entry(a.target, b.target, lists.materials);
                  });
  replace_entries(edits.lights, changes.lights, [&](const LightEdit& a, const LightEdit& b) {
    if (a.kind != b.kind || a.kind == EditedLight::kEnvironment) return a.kind == b.kind;
    return a.kind == EditedLight::kPunctual ? same_entry(a.target, b.target, lists.lights)
                                            : same_entry(a.target, b.target, lists.materials);
  });
}

template <class Named>
json names_of(const std::vector<Named>& list) {
  json names = json::array();
  for (const Named& entry : list) names.push_back(entry.name);
  return names;
}

json view_json(const ListedScene& scene, const SceneEdits& edits) {
  const CameraDescription camera = edited_camera(edits, scene.outline, scene.camera);
  const CameraEdit edit = edit_of(view_of(camera, scene.center, scene.radius));
  json view = {{"look_from", json_of(*edit.look_from)},
               {"look_at", json_of(*edit.look_at)},
               {"up", json_of(edit.up)}};
  if (edit.mirrored) view["mirrored"] = true;
  if (edit.fov_y_degrees) view["fov_y"] = *edit.fov_y_degrees;
  if (edit.orthographic_height) view["orthographic_height"] = *edit.orthographic_height;
  return view;
}

}  // namespace

SceneEdits merge_json_edits(const json& changes, const std::string& name, const SceneEdits& before,
                            const SceneDescription& lists) {
  JsonReader(changes, name)
      .object({"emberline_edits", "camera", "animation", "variant", "environment", "lights",
               "materials"});
  json document = changes;
  SceneEdits edits = before;
  const auto given = [&](const char* part) {
    if (!document.contains(part)) return false;
    if (document[part].is_null()) document.erase(part);
    return true;
  };
  const bool camera = given("camera"), animation = given("animation"), variant = given("variant"),
             environment = given("environment"), lights = given("lights"),
             materials = given("materials");
  if (document.contains("camera") && document["camera"].contains("matrix")) {
    document["camera"] = expand_matrix(document["camera"], name);
  }
  document.emplace("emberline_edits", unsigned(kEditsVersion));
  const SceneEdits parsed = edits_from_json(document, name);
  if (camera) edits.camera = parsed.camera;
  if (animation) edits.animation = parsed.animation;
  if (variant) edits.variant = parsed.variant;
  if (environment) edits.environment = parsed.environment;
  if (lights && !document.contains("lights")) edits.lights.clear();
  if (materials && !document.contains("materials")) edits.materials.clear();
  merge_lists(parsed, lists, edits);
  return edits;
}

SceneEdits merge_edits(const SceneEdits& edits, SceneEdits before, const SceneDescription& lists) {
  if (edits.camera != CameraEdit()) before.camera = edits.camera;
  if (edits.animation != AnimationEdit()) before.animation = edits.animation;
  if (edits.variant) before.variant = edits.variant;
  if (edits.environment != EnvironmentEdit()) before.environment = edits.environment;
  merge_lists(edits, lists, before);
  return before;
}

json protocol_json(const ListedScene& scene, const SceneEdits& edits) {
  const SceneDescription& lists = scene.outline;
  return {{"cameras", names_of(lists.cameras)},       {"lights", names_of(lists.lights)},
          {"materials", names_of(lists.materials)},   {"variants", names_of(lists.variants)},
          {"animations", names_of(scene.animations)}, {"instances", lists.instances.size()},
          {"center", json_of(scene.center)},          {"radius", scene.radius},
          {"view", view_json(scene, edits)}};
}

json protocol_json(const SessionPicture& picture) {
  return {{"event", "picture"},
          {"edit", picture.edit},
          {"x", picture.x},
          {"y", picture.y},
          {"width", picture.width},
          {"height", picture.height},
          {"filled", picture.filled},
          {"complete", picture.complete},
          {"finished", picture.finished},
          {"samples", picture.samples},
          {"completion", picture.progress.completion},
          {"elapsed_s", picture.elapsed_s},
          {"denoised", !picture.denoised.empty()},
          {"legend", picture.overlay_legend}};
}

}  // namespace emberline
