// An artist's changes to the view, lights, environment and materials of a loaded scene, which leave
// its file unchanged. They are plain data. io/json/edits_file.h reads and writes them; apply()
// applies them to a SceneDescription, and EditableScene (editable_scene.h) to a built scene.
//
// Edits are the differences from the file: without edits, the scene is that of the file, and undo
// applies the previous edits. Units are those of SceneDescription unless stated otherwise.
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

// Identifies one of the file's lights, materials, cameras or variants. A unique name suffices, even
// if the index has changed; the index distinguishes entries of equal name and identifies unnamed
// ones.
struct EditTarget {
  std::string name;
  int index = -1;     // into the description's list; -1: by name only
  std::string place;  // for messages: "shot.json#/lights/0"; empty for edits without a file

  bool operator==(const EditTarget& other) const {
    return name == other.name && index == other.index;
  }
};

// Changes of the view. Absent values stay as on the command line or in the file.
struct CameraEdit {
  std::optional<EditTarget> camera;  // in SceneDescription::cameras
  // Viewpoint and target in world space, in metres; set both or neither. The view is in perspective
  // unless orthographic_height is set.
  std::optional<Vec3d> look_from, look_at;
  Vec3d up = Vec3d(0.0, 1.0, 0.0);      // with look_from; any length but 0
  bool mirrored = false;                // with look_from: swaps left and right
  std::optional<double> fov_y_degrees;  // vertical; for a perspective view
  // Makes the view orthographic with this height in metres. Not allowed with fov_y_degrees or
  // f_stop.
  std::optional<double> orthographic_height;
  // Use a lens instead of a pinhole (see lens_radius()), with this focus distance in metres along
  // the axis. If the distance is absent, the lens is focused on look_at.
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
  std::string name = {};            // name, index or "all"; empty: the first if `time` is set
  std::optional<double> time = {};  // seconds
  std::optional<double> fps = {};   // frames per second, for values in frames
  // In frames after `time`; set both or neither.
  std::optional<double> shutter_open = {}, shutter_close = {};
  std::string place = {};  // for messages

  bool operator==(const AnimationEdit& other) const {
    return name == other.name && time == other.time && fps == other.fps &&
           shutter_open == other.shutter_open && shutter_close == other.shutter_close;
  }
};

// kMaterial is all light that one material emits.
enum class EditedLight : uint8_t { kPunctual, kMaterial, kEnvironment };

// Factors on the radiance of a light. A material that does not emit stays black.
struct LightEdit {
  EditedLight kind = EditedLight::kPunctual;
  EditTarget target;  // kEnvironment: only `place` is used
  float intensity = 1.0f;
  Rgb color = Rgb(1.0f);  // linear Rec. 709
  bool on = true;

  bool operator==(const LightEdit&) const = default;
};

// Values that replace those of the scene's EnvironmentDescription.
struct EnvironmentEdit {
  std::string file;                    // empty: keep the existing environment
  std::shared_ptr<const Image> image;  // contents of `file`; kHalf or kFloat, 3 channels
  uint64_t repaired_texels = 0;        // repaired while reading it
  std::optional<float> strength;
  std::optional<float> rotation_degrees;
  std::string place;  // for messages

  bool operator==(const EnvironmentEdit& other) const {
    return file == other.file && image == other.image && strength == other.strength &&
           rotation_degrees == other.rotation_degrees;
  }
};

// Factors that replace those of the file's MaterialDescription. The textures stay and are
// multiplied by the new factors. material_parameters.h has the names and ranges.
struct MaterialEdit {
  EditTarget target;
  std::optional<Rgb> base_color;
  std::optional<float> roughness, metallic, transmission, normal_scale;
  std::optional<Rgb> emission;  // radiance, before a LightEdit of this material
  std::optional<float> ior;     // an error for materials that reflect everything
  std::optional<float> specular;
  std::optional<Rgb> specular_color;
  std::optional<Rgb> attenuation_color;       // affects only an interior, like the next two
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

// Limits of values in an edits file and on the command line. They keep squared distances, and sums
// of radiance in a film, finite in float.
namespace edit_limits {
inline constexpr double kMaxDistance = 1e15;    // metres
inline constexpr double kMaxRadiance = 1e9;     // radiance, and factors on it
inline constexpr double kMaxDegrees = 36000.0;  // degrees
}  // namespace edit_limits

struct SceneEdits {
  CameraEdit camera;
  // Used by the code that loads or poses the scene (GltfOptions); apply() ignores it.
  AnimationEdit animation;
  // In SceneDescription::variants; absent: the meshes use their own materials.
  std::optional<EditTarget> variant;
  std::vector<LightEdit> lights;
  EnvironmentEdit environment;
  std::vector<MaterialEdit> materials;

  bool operator==(const SceneEdits&) const = default;
};

// Returns the index of `target` in a list of the description; none if it is missing, or if several
// entries have its name and its index is not one of theirs.
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

// Applies the edits to a description, complete or from copy_without_geometry(). A scene without
// light first gets the plain white environment that build_scene() would add; lights that the edits
// switch off then stay dark. If a placed mesh uses glTF's default material, it is appended to
// `description.materials` with the name kDefaultMaterialName.
//
// The variant is applied first, so that material edits refer to the file's names. Whether a scene
// has light depends on the file's own materials: a variant's light is added to the white
// environment of a file without light.
//
// Throws InputError, which names the edit's place and the valid names, for a missing target, for
// two edits of one target, for a variant if the scene was loaded without its materials, for an
// environment edit without an environment, for anisotropy without tangents, and for the index of
// refraction of a material that reflects everything. The description is then unchanged. apply()
// does not check values; edits_file.h checks those of a file.
void apply(const SceneEdits& edits, SceneDescription& description);
inline constexpr const char* kDefaultMaterialName = "default material";

// Whether the edits make a material anisotropic, so that the scene must be loaded with
// GltfOptions::tangents.
bool need_tangents(const SceneEdits& edits);

// The index of the light or material that an edit refers to; 0 for the environment. Throws
// InputError if it is missing.
size_t edited_light_index(const LightEdit& edit, const SceneDescription& description);

// Applies the edits of the view to `camera`. Throws InputError if the camera that they select is
// missing, if they set a field of view or a lens for an orthographic view, if a lens has no focus
// distance, or if look_from and look_at coincide.
CameraDescription edited_camera(const SceneEdits& edits, const SceneDescription& description,
                                CameraDescription camera);

// Copies a description without its vertices and triangles, which apply() and EditableScene do not
// need.
SceneDescription copy_without_geometry(const SceneDescription& description);

}  // namespace emberline
