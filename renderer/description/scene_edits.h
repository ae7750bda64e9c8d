// An artist's changes to the view, lights, environment and materials of a loaded scene. The scene's
// file stays unchanged. Edits are plain data. io/json/edits_file.h reads and writes them. apply()
// applies them to a SceneDescription; EditableScene (editable_scene.h) applies them to a built
// scene.
//
// Edits are differences from the file: without edits, the scene is that of the file. To undo an
// edit, the caller applies the previous edits to the file's scene. Units are those of
// SceneDescription unless stated otherwise.
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
// if the index has changed. The index distinguishes entries that have the same name, and identifies
// unnamed ones.
struct EditTarget {
  std::string name;
  int index = -1;     // in the description's list; -1: found by name only
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
  std::optional<double> fov_y_degrees;  // vertical field of view, in perspective only
  // Makes the view orthographic with this height in metres. Not allowed with fov_y_degrees or
  // f_stop.
  std::optional<double> orthographic_height;
  // An f_stop replaces the pinhole by a lens (see lens_radius()). focus_distance is in metres along
  // the axis; if it is absent, the lens is focused on look_at.
  std::optional<double> f_stop, focus_distance;
  std::string place;  // for messages

  bool operator==(const CameraEdit& other) const {
    return camera == other.camera && look_from == other.look_from && look_at == other.look_at &&
           up == other.up && mirrored == other.mirrored && fov_y_degrees == other.fov_y_degrees &&
           orthographic_height == other.orthographic_height && f_stop == other.f_stop &&
           focus_distance == other.focus_distance;
  }
};

// The time at which the scene is seen, and the shutter times. Absent values stay as on the command
// line.
struct AnimationEdit {
  std::string name = {};            // name, index or "all"; empty: the first one, if `time` is set
  std::optional<double> time = {};  // seconds
  std::optional<double> fps = {};   // frames per second, for times in frames
  // Times relative to `time`, measured in frames; set both or neither.
  std::optional<double> shutter_open = {}, shutter_close = {};
  std::string place = {};  // for messages

  bool operator==(const AnimationEdit& other) const {
    return name == other.name && time == other.time && fps == other.fps &&
           shutter_open == other.shutter_open && shutter_close == other.shutter_close;
  }
};

// kMaterial stands for all the light that one material emits.
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

// Values that replace the values in the scene's EnvironmentDescription.
struct EnvironmentEdit {
  std::string file;                    // empty: keep the existing environment
  std::shared_ptr<const Image> image;  // contents of `file`; kHalf or kFloat, 3 channels
  uint64_t repaired_texels = 0;        // number of texels that were repaired while reading `file`
  std::optional<float> strength;
  std::optional<float> rotation_degrees;
  std::string place;  // for messages

  bool operator==(const EnvironmentEdit& other) const {
    return file == other.file && image == other.image && strength == other.strength &&
           rotation_degrees == other.rotation_degrees;
  }
};

// Parameters that replace those of the file's MaterialDescription. Textures stay, and the new
// values multiply them as the old values did. material_parameters.h has the names and ranges.
struct MaterialEdit {
  EditTarget target;
  std::optional<Rgb> base_color;
  std::optional<float> roughness, metallic, transmission, normal_scale;
  std::optional<Rgb> emission;  // radiance, before a LightEdit of this material is applied
  std::optional<float> ior;     // an error if the file's ior is 0 (reflects everything)
  std::optional<float> specular;
  std::optional<Rgb> specular_color;
  std::optional<Rgb> attenuation_color;       // these three affect only an interior
  std::optional<float> attenuation_distance;  // metres
  std::optional<float> dispersion;
  std::optional<float> diffuse_transmission;
  std::optional<Rgb> diffuse_transmission_color;
  std::optional<float> anisotropy, anisotropy_rotation_degrees;
  std::optional<float> iridescence, iridescence_ior;
  std::optional<float> iridescence_thickness;  // the maximum, in nanometres
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
  // One of SceneDescription::variants. If absent, the meshes use their own materials.
  std::optional<EditTarget> variant;
  std::vector<LightEdit> lights;
  EnvironmentEdit environment;
  std::vector<MaterialEdit> materials;

  bool operator==(const SceneEdits&) const = default;
};

// Returns the index of `target` in a list of the description. Returns nothing if the target is
// missing, or if several entries have the target's name but none of them has its index.
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

// Applies the edits to a description, which may be complete or come from copy_without_geometry(). A
// scene without light first gets the plain white environment that build_scene() would add. So a
// scene whose lights are all switched off by edits stays dark. If a placed mesh uses glTF's default
// material, this material is appended to `description.materials` under the name
// kDefaultMaterialName.
//
// The variant is applied after that, and before the other edits. Material edits refer to materials
// by their names in the file. The file's own materials, not the variant's, decide whether the scene
// has light. So if only the variant's materials emit light, the scene has both their light and the
// white environment.
//
// Throws an InputError that names the edit's place and the valid names. The reasons are: a missing
// target, two edits of one target, a variant if the scene was loaded without its materials, an
// environment edit without an environment, anisotropy without tangents, or an index of refraction
// for a material that reflects everything. After an error, none of the edits has been applied; only
// the white environment and the default material may have been added. apply() does not check
// values; edits_file.h checks the values in a file.
void apply(const SceneEdits& edits, SceneDescription& description);
inline constexpr const char* kDefaultMaterialName = "default material";

// Returns whether the edits make a material anisotropic. If so, the scene must be loaded with
// GltfOptions::tangents.
bool need_tangents(const SceneEdits& edits);

// Returns the index of the light or material that an edit refers to, or 0 for the environment.
// Throws InputError if the light or material is missing.
size_t edited_light_index(const LightEdit& edit, const SceneDescription& description);

// Applies the edits of the view to `camera` and returns the result. Throws InputError if the camera
// that the edits select is missing or invalid, if the edits set a field of view or a lens for an
// orthographic view, if a lens has no focus distance, or if look_from and look_at coincide.
CameraDescription edited_camera(const SceneEdits& edits, const SceneDescription& description,
                                CameraDescription camera);

// Copies the parts of a description that apply() and EditableScene need, but not vertices and
// triangles.
SceneDescription copy_without_geometry(const SceneDescription& description);

}  // namespace emberline
