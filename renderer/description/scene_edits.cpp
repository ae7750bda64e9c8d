#include "renderer/description/scene_edits.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <set>

#include "renderer/core/constants.h"
#include "renderer/core/errors.h"
#include "renderer/core/name_or_index.h"
#include "renderer/core/shortened.h"
#include "renderer/description/default_light.h"
#include "renderer/description/framing.h"
#include "renderer/description/material_parameters.h"

namespace emberline {
namespace {

template <class Named>
std::string list_all(const char* what, const std::vector<Named>& list) {
  if (list.empty()) return fmt::format("the scene has no {}s", what);
  return fmt::format("the scene's {}s are {}", what, numbered_names(list));
}

[[noreturn]] void throw_edit_error(const std::string& place, const std::string& message) {
  throw InputError(place.empty() ? "edits" : place, message);
}

// Returns the index of `target` in `list`. If the target is missing, throws an InputError, whose
// message uses `what` as the word for the list's entries.
template <class Named>
size_t find_target(const EditTarget& target, const char* what, const std::vector<Named>& list) {
  if (const std::optional<size_t> found = find_entry(target, list)) return *found;
  const std::string listed = list_all(what, list);
  if (target.name.empty()) {
    throw_edit_error(target.place, fmt::format("no {} {}; {}", what, target.index, listed));
  }
  const auto count = std::ranges::count(list, target.name, &Named::name);
  if (count == 0)
    throw_edit_error(target.place,
                     fmt::format("no {} '{}'; {}", what, shortened(target.name), listed));
  throw_edit_error(target.place,
                   fmt::format("{} {}s are called '{}'; choose one with \"index\"; {}", count, what,
                               shortened(target.name), listed));
}

// Like find_target(), but also finds cameras by their nodes. If no camera has the target's name and
// exactly one camera has a node of this name, returns this camera.
size_t find_camera(const EditTarget& target, const std::vector<CameraDescription>& cameras) {
  const auto is_node = [&](const CameraDescription& camera) { return camera.node == target.name; };
  if (!target.name.empty() && !find_entry(target, cameras) &&
      std::ranges::count(cameras, target.name, &CameraDescription::name) == 0 &&
      std::ranges::count_if(cameras, is_node) == 1) {
    return size_t(std::ranges::find_if(cameras, is_node) - cameras.begin());
  }
  return find_target(target, "camera", cameras);
}

// Multiplies two colours. Products are clamped to the largest float, so that they stay finite.
Rgb scaled(const Rgb& value, const Rgb& factor) {
  const auto product = [](float a, float b) {
    return std::min(a * b, std::numeric_limits<float>::max());
  };
  return {product(value.x, factor.x), product(value.y, factor.y), product(value.z, factor.z)};
}

void name_default_material(SceneDescription& scene) {
  const auto number = int(scene.materials.size());
  std::vector<bool> placed(scene.meshes.size(), false);
  for (const InstanceDescription& instance : scene.instances) placed[size_t(instance.mesh)] = true;
  bool used = false;
  for (size_t i = 0; i < scene.meshes.size(); ++i) {
    if (!placed[i] || scene.meshes[i].material >= 0) continue;
    scene.meshes[i].material = number;
    used = true;
  }
  if (used) scene.materials.emplace_back().name = kDefaultMaterialName;
}

bool makes_anisotropic(const MaterialEdit& edit) { return edit.anisotropy.value_or(0.0f) > 0.0f; }

class EditApplication {
 public:
  EditApplication(const SceneEdits& edits, SceneDescription& scene) : edits_(edits), scene_(scene) {
    check_targets();
  }

  void apply() {
    apply_variant();
    edit_environment();
    for (size_t i = 0; i < edits_.materials.size(); ++i) edit_material(i);
    for (size_t i = 0; i < edits_.lights.size(); ++i) edit_light(i);
  }

 private:
  void check_targets();
  void check_material_edit(const MaterialEdit& edit, const MaterialDescription& material) const;
  void apply_variant();
  void edit_environment();
  void edit_material(size_t edit);
  void edit_light(size_t edit);

  const SceneEdits& edits_;
  SceneDescription& scene_;
  std::vector<size_t> lights_, materials_;  // indices of the edits' targets
  int variant_ = -1;
};

void EditApplication::check_targets() {
  const auto found = [](const EditTarget& target, const char* what, const auto& list, auto& taken) {
    const size_t index = find_target(target, what, list);
    if (!taken.insert(index).second) {
      throw_edit_error(target.place,
                       fmt::format("{} {} '{}' has more than one entry; keep only one of them",
                                   what, index, shortened(list[index].name)));
    }
    return index;
  };
  if (edits_.variant) {
    variant_ = int(find_target(*edits_.variant, "variant", scene_.variants));
    if (!scene_.variants_read) {
      throw_edit_error(
          edits_.variant->place,
          "the scene was loaded without the materials of its variants; open it again with "
          "these edits");
    }
  }
  const EnvironmentEdit& environment = edits_.environment;
  const bool has_environment = scene_.environment.has_value() || environment.image;
  constexpr const char* kNoEnvironment = "the scene has no environment; choose one with \"file\"";
  if (!has_environment && (environment.strength || environment.rotation_degrees)) {
    throw_edit_error(environment.place, kNoEnvironment);
  }
  std::set<size_t> edited_materials, edited_lights, edited_emission;
  bool environment_edited = false;
  for (const MaterialEdit& edit : edits_.materials) {
    materials_.push_back(found(edit.target, "material", scene_.materials, edited_materials));
    check_material_edit(edit, scene_.materials[materials_.back()]);
  }
  for (const LightEdit& edit : edits_.lights) {
    if (edit.kind == EditedLight::kPunctual) {
      lights_.push_back(found(edit.target, "light", scene_.lights, edited_lights));
    } else if (edit.kind == EditedLight::kMaterial) {
      lights_.push_back(found(edit.target, "material", scene_.materials, edited_emission));
    } else {
      if (!has_environment) throw_edit_error(edit.target.place, kNoEnvironment);
      if (environment_edited) {
        throw_edit_error(edit.target.place,
                         "the environment has more than one entry; keep only one of them");
      }
      environment_edited = true;
      lights_.push_back(0);
    }
  }
}

void EditApplication::check_material_edit(const MaterialEdit& edit,
                                          const MaterialDescription& material) const {
  // In KHR_materials_ior, an index of 0 has a special meaning ("Backwards Compatibility Mode"), so
  // it must not be replaced.
  if (edit.ior && material.ior == 0.0f) {
    throw_edit_error(edit.target.place,
                     fmt::format("material '{}' has no \"ior\" to edit: the file sets it to 0 or "
                                 "uses specular-glossiness",
                                 shortened(material.name)));
  }
  if (makes_anisotropic(edit) && !scene_.tangents_read && !has_tangent_space(material)) {
    throw_edit_error(
        edit.target.place,
        fmt::format("the scene was loaded without the tangents that \"anisotropy\" of material "
                    "'{}' needs; open it again with these edits",
                    shortened(material.name)));
  }
}

void EditApplication::apply_variant() {
  for (MeshDescription& mesh : scene_.meshes) {
    const auto other =
        std::ranges::find(mesh.variant_materials, variant_, &VariantMaterial::variant);
    if (other != mesh.variant_materials.end()) mesh.material = other->material;
  }
}

void EditApplication::edit_environment() {
  const EnvironmentEdit& edit = edits_.environment;
  if (edit.image) {
    if (!scene_.environment) scene_.environment = EnvironmentDescription{};
    scene_.environment->file = edit.file;
    scene_.environment->image = edit.image;
    scene_.environment->sun.reset();
    scene_.repairs.non_finite_texels += edit.repaired_texels;
  }
  if (edit.strength) scene_.environment->strength = *edit.strength;
  if (edit.rotation_degrees) scene_.environment->rotation_degrees = *edit.rotation_degrees;
}

void EditApplication::edit_material(size_t i) {
  const MaterialEdit& edit = edits_.materials[i];
  MaterialDescription& material = scene_.materials[materials_[i]];
  for (const MaterialParameter& p : material_parameters()) {
    if (p.color) {
      if (const auto& color = edit.*p.edited_color) material.*p.color = *color;
    } else if (const auto& number = edit.*p.edited_number) {
      material.*p.number = p.unit * *number;
    }
  }
}

void EditApplication::edit_light(size_t i) {
  const LightEdit& edit = edits_.lights[i];
  const Rgb factor = edit.on ? scaled(edit.color, Rgb(edit.intensity)) : Rgb(0.0f);
  Rgb& light = edit.kind == EditedLight::kPunctual   ? scene_.lights[lights_[i]].intensity
               : edit.kind == EditedLight::kMaterial ? scene_.materials[lights_[i]].emission
                                                     : scene_.environment->tint;
  light = scaled(light, factor);
}

// Drops the file's aspect ratio, since the width of the view follows from its height and the frame.
void make_orthographic(double height, CameraDescription& camera) {
  camera.orthographic = true;
  camera.aspect.reset();
  camera.y_mag = 0.5 * height;
  camera.zoom.reset();
  camera.lens_radius = 0.0;
}

Mat44d view_matrix(const CameraEdit& edit) {
  Mat44d m = look_at_matrix(*edit.look_from, *edit.look_at, edit.up);
  if (edit.mirrored) {
    for (int c = 0; c < 3; ++c) m[0][c] = -m[0][c];  // row 0 points to the right of the image
  }
  return m;
}

void require_perspective(const CameraEdit& edit, const CameraDescription& camera,
                         const char* member) {
  if (!camera.orthographic) return;
  throw_edit_error(edit.place, fmt::format("camera '{}' is orthographic and has no \"{}\"",
                                           shortened(camera.name), member));
}

void edit_lens(const CameraEdit& edit, CameraDescription& camera) {
  if (edit.focus_distance) {
    camera.focus_distance = *edit.focus_distance;
  } else if (edit.look_from && edit.look_at) {
    camera.focus_distance = (*edit.look_at - *edit.look_from).length();
  }
  if (!edit.f_stop) return;
  require_perspective(edit, camera, "f_stop");
  if (!(camera.focus_distance > 0)) {
    throw_edit_error(
        edit.place,
        "\"f_stop\" requires \"focus_distance\" or \"look_at\": the lens needs a distance to "
        "focus on");
  }
  camera.lens_radius = lens_radius(*edit.f_stop, camera.fov_y);
}

}  // namespace

void apply(const SceneEdits& edits, SceneDescription& description) {
  add_default_light(description);
  name_default_material(description);
  EditApplication(edits, description).apply();
}

bool need_tangents(const SceneEdits& edits) {
  return std::ranges::any_of(edits.materials, makes_anisotropic);
}

size_t edited_light_index(const LightEdit& edit, const SceneDescription& description) {
  if (edit.kind == EditedLight::kPunctual) {
    return find_target(edit.target, "light", description.lights);
  }
  if (edit.kind == EditedLight::kMaterial) {
    return find_target(edit.target, "material", description.materials);
  }
  return 0;
}

CameraDescription edited_camera(const SceneEdits& edits, const SceneDescription& description,
                                CameraDescription camera) {
  const CameraEdit& edit = edits.camera;
  if (edit.camera) {
    camera = description.cameras[find_camera(*edit.camera, description.cameras)];
    if (camera.fault) throw InputError(*camera.fault);
  }
  if (edit.look_from && edit.look_at) {
    if (!((*edit.look_from - *edit.look_at).length2() > 0)) {
      throw_edit_error(edit.place,
                       "\"look_from\" and \"look_at\" are the same point; move one of them");
    }
    camera.name = "edited view";
    if (camera.orthographic) camera.zoom.reset();
    camera.orthographic = false;
    camera.aspect.reset();  // the frame's ratio applies
    camera.to_world = view_matrix(edit);
    camera.motion.clear();
    camera.next_frame.reset();
    camera.fault.reset();
  }
  if (edit.orthographic_height) make_orthographic(*edit.orthographic_height, camera);
  if (edit.fov_y_degrees) {
    require_perspective(edit, camera, "fov_y");
    camera.fov_y = *edit.fov_y_degrees * kPiD / 180.0;
    camera.zoom.reset();
  }
  edit_lens(edit, camera);
  return camera;
}

SceneDescription copy_without_geometry(const SceneDescription& description) {
  SceneDescription result;
  static_cast<SceneLists&>(result) = description;
  result.generator = description.generator;
  result.images = description.images;
  result.instances = description.instances;
  result.nodes = description.nodes;
  result.coverage = description.coverage;
  result.repairs = description.repairs;
  result.meshes.reserve(description.meshes.size());
  for (const MeshDescription& mesh : description.meshes) {
    MeshDescription& copy = result.meshes.emplace_back();
    copy.name = mesh.name;
    copy.material = mesh.material;
    copy.variant_materials = mesh.variant_materials;
  }
  return result;
}

}  // namespace emberline
