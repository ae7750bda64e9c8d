// An artist's changes to a loaded scene that do not touch its file: view, lights, environment,
// materials. Plain data; io/json/edits_file.h reads and writes it, apply() applies it to a
// SceneDescription, EditableScene (editable_scene.h) to a built scene.
//
// Edits are the differences from the file: no edits mean the unchanged file, and undo applies the
// previous edits. Units are those of SceneDescription unless stated otherwise.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "renderer/core/vector.h"
#include "renderer/description/scene_description.h"

namespace emberline {

// One of the file's lights, materials, cameras or variants. A unique name identifies it, even if
// its index has changed; the index distinguishes entries of equal name and identifies unnamed ones.
struct EditTarget {
  std::string name;
  int index = -1;     // into the description's list; -1: by name only
  std::string place;  // for messages: "shot.json#/lights/0"; empty for edits without a file

  bool operator==(const EditTarget& other) const {
    return name == other.name && index == other.index;
  }
};

// A view. Absent values stay as on the command line or in the file.
struct CameraEdit {
  std::optional<EditTarget> camera;  // in SceneDescription::cameras
  // World space, metres, both or neither: the view from here, in perspective unless
  // orthographic_height is set.
  std::optional<Vec3d> look_from, look_at;
  Vec3d up = Vec3d(0.0, 1.0, 0.0);      // with look_from; any length but 0
  bool mirrored = false;                // with look_from: swaps left and right
  std::optional<double> fov_y_degrees;  // vertical, of a perspective view
  // Makes the view orthographic, whatever the camera was, with this height in metres. Not with
  // fov_y_degrees or f_stop.
  std::optional<double> orthographic_height;
  // A lens instead of a pinhole (lens_radius in camera.h), and its focus distance in metres along
  // the axis; if absent, it is focused on look_at.
  std::optional<double> f_stop, focus_distance;
  std::string place;  // for messages

  bool operator==(const CameraEdit& other) const {
    return camera == other.camera && look_from == other.look_from && look_at == other.look_at &&
           up == other.up && mirrored == other.mirrored && fov_y_degrees == other.fov_y_degrees &&
           orthographic_height == other.orthographic_height && f_stop == other.f_stop &&
           focus_distance == other.focus_distance;
  }
};

// The time at which the scene is seen, and the shutter. Absent values stay as on the command line.
struct AnimationEdit {
  std::string name = {};            // or an index, or "all"; empty: the first, if there is a time
  std::optional<double> time = {};  // seconds
  std::optional<double> fps = {};   // frames per second, for values in frames
  // Frames from that time on; both or neither.
  std::optional<double> shutter_open = {}, shutter_close = {};
  std::string place = {};  // for messages

  bool operator==(const AnimationEdit& other) const {
    return name == other.name && time == other.time && fps == other.fps &&
           shutter_open == other.shutter_open && shutter_close == other.shutter_close;
  }
};

// kMaterial: everything that one material emits.
enum class EditedLight : uint8_t { kPunctual, kMaterial, kEnvironment };

// Factors on a light's own radiance. A material that does not emit stays black.
struct LightEdit {
  EditedLight kind = EditedLight::kPunctual;
  EditTarget target;  // kEnvironment: only `place` is used
  float intensity = 1.0f;
  Rgb color = Rgb(1.0f);  // linear Rec. 709
  bool on = true;

  bool operator==(const LightEdit&) const = default;
};

// Values of EnvironmentDescription that replace the scene's.
struct EnvironmentEdit {
  std::string file;                    // empty: the existing environment
  std::shared_ptr<const Image> image;  // of the file; kHalf or kFloat, 3 channels
  uint64_t repaired_texels = 0;        // during reading
  std::optional<float> strength;
  std::optional<float> rotation_degrees;
  std::string place;  // for messages

  bool operator==(const EnvironmentEdit& other) const {
    return file == other.file && image == other.image && strength == other.strength &&
           rotation_degrees == other.rotation_degrees;
  }
};

// Factors of MaterialDescription that replace the file's; textures stay and are multiplied by them.
// material_parameters.h has their names and ranges.
struct MaterialEdit {
  EditTarget target;
  std::optional<Rgb> base_color;
  std::optional<float> roughness, metallic, transmission, normal_scale;
  std::optional<Rgb> emission;  // radiance, before any LightEdit of the material
  std::optional<float> ior;     // not for materials that reflect everything
  std::optional<float> specular;
  std::optional<Rgb> specular_color;
  std::optional<Rgb> attenuation_color;       // this and the next two: only with an interior
  std::optional<float> attenuation_distance;  // metres
  std::optional<float> dispersion;
  std::optional<float> diffuse_transmission;
  std::optional<Rgb> diffuse_transmission_color;
  std::optional<float> anisotropy, anisotropy_rotation_degrees;
  std::optional<float> iridescence, iridescence_ior;
  std::optional<float> iridescence_thickness;  // nanometres: the maximum
  std::optional<Rgb> sheen_color;
  std::optional<float> sheen_roughness;
  std::optional<float> clearcoat, clearcoat_roughness;

  bool operator==(const MaterialEdit&) const = default;
};

// Limits for values in an edits file, the same as for the command line: squared distances stay
// finite in float, and so does radiance times a film's sums.
namespace edit_limits {
inline constexpr double kMaxDistance = 1e15;    // metres
inline constexpr double kMaxRadiance = 1e9;     // radiance, and factors on it
inline constexpr double kMaxDegrees = 36000.0;  // degrees
}  // namespace edit_limits

struct SceneEdits {
  CameraEdit camera;
  // The code that loads or poses the scene uses it (GltfOptions); apply() ignores it.
  AnimationEdit animation;
  // In SceneDescription::variants; absent: the meshes use their own materials.
  std::optional<EditTarget> variant;
  std::vector<LightEdit> lights;
  EnvironmentEdit environment;
  std::vector<MaterialEdit> materials;

  bool operator==(const SceneEdits&) const = default;
};

// The index of `target` in a list of the description. None if it is missing, or if several entries
// have its name and its index is not one of them.
template <class Named>
std::optional<size_t> find_entry(const EditTarget& target, const std::vector<Named>& list) {
  const bool listed = target.index >= 0 && size_t(target.index) < list.size();
  const auto has_name = [&](const Named& entry) { return entry.name == target.name; };
  if (listed && (target.name.empty() || has_name(list[size_t(target.index)]))) {
    return size_t(target.index);
  }
  if (target.name.empty() || std::ranges::count_if(list, has_name) != 1) return std::nullopt;
  return size_t(std::ranges::find_if(list, has_name) - list.begin());
}

// Applies the edits to a description, complete or an outline. A scene without light first gets the
// plain white environment that build_scene() would add; lights that the edits switch off then stay
// dark. If a placed mesh uses glTF's default material, it is appended to `description.materials`
// with the name kDefaultMaterialName.
//
// The variant is applied first, so that material edits refer to the file's names. Whether a scene
// has light depends on the file's own materials: a variant's light is added to the white
// environment of a file without light.
//
// Throws InputError (the edit's place, the valid names) for a missing target, for two edits of one
// target, for a variant of a description that was loaded without its materials, for an environment
// edit without an environment, for anisotropy without tangents, and for an index of refraction of a
// material that has none; the description is then unchanged. Values are not checked: edits_file.h
// checks the ranges of a file's values.
void apply(const SceneEdits& edits, SceneDescription& description);
inline constexpr const char* kDefaultMaterialName = "default material";

// Whether the edits make a material anisotropic, so that the scene must be loaded with
// GltfOptions::tangents.
bool need_tangents(const SceneEdits& edits);

// The index of the light or material that an edit refers to; 0 for the environment. Throws
// InputError if it is missing.
size_t edited_light_index(const LightEdit& edit, const SceneDescription& description);

// The view that `edits` make of `camera`, the view without them. Throws InputError for a missing
// camera, a field of view or a lens for an orthographic one, a lens without a focus distance, and a
// view from the point that it looks at.
CameraDescription edited_camera(const SceneEdits& edits, const SceneDescription& description,
                                CameraDescription camera);

// A copy without vertices and triangles: enough for apply() and EditableScene.
SceneDescription copy_without_geometry(const SceneDescription& description);

}  // namespace emberline
