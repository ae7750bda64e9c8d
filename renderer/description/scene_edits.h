// What an artist changes of a loaded scene without touching its file: view, lights, surroundings,
// materials. Plain data; io/json/edits_file.h reads and writes it, apply() puts it into a
// SceneDescription, EditableScene (editable_scene.h) into a scene that is already built.
//
// Edits say what differs from the file, so that no edits at all is the file as it is, and undo is
// the edits of before. Units are SceneDescription's where nothing else is said.
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

// One of the file's lights, materials, cameras or variants. The name finds it where one alone has
// that name, wherever the file now lists it; the index tells those of equal name apart, and finds
// one without a name.
struct EditTarget {
  std::string name;
  int index = -1;     // into the description's list; -1: the name alone
  std::string place;  // for messages: "shot.json#/lights/0"; empty for edits that no file holds

  bool operator==(const EditTarget& other) const {
    return name == other.name && index == other.index;
  }
};

// A view. What is absent stays as the command line or the file has it.
struct CameraEdit {
  std::optional<EditTarget> camera;  // of SceneDescription::cameras
  // World space, metres, together or not at all: a view from here instead, in perspective unless
  // orthographic_height says otherwise.
  std::optional<Vec3d> look_from, look_at;
  Vec3d up = Vec3d(0.0, 1.0, 0.0);      // with them; any length but 0
  bool mirrored = false;                // with them: left and right are exchanged
  std::optional<double> fov_y_degrees;  // vertical, of a perspective view
  // The view is orthographic, whatever the camera was, and shows so many metres from its lower edge
  // to its upper one. Not with fov_y_degrees or f_stop.
  std::optional<double> orthographic_height;
  // A lens instead of a pinhole (lens_radius in camera.h), and what it is focused on in metres
  // along the axis; where that is absent, on look_at.
  std::optional<double> f_stop, focus_distance;
  std::string place;  // for messages

  bool operator==(const CameraEdit& other) const {
    return camera == other.camera && look_from == other.look_from && look_at == other.look_at &&
           up == other.up && mirrored == other.mirrored && fov_y_degrees == other.fov_y_degrees &&
           orthographic_height == other.orthographic_height && f_stop == other.f_stop &&
           focus_distance == other.focus_distance;
  }
};

// When the scene is seen, and for how long. What is absent stays as the command line has it.
struct AnimationEdit {
  std::string name = {};            // or an index, or "all"; empty: the first, if there is a time
  std::optional<double> time = {};  // seconds
  std::optional<double> fps = {};   // frames of a second, for what is counted in them
  // Frames from that time on; both or neither.
  std::optional<double> shutter_open = {}, shutter_close = {};
  std::string place = {};  // for messages

  bool operator==(const AnimationEdit& other) const {
    return name == other.name && time == other.time && fps == other.fps &&
           shutter_open == other.shutter_open && shutter_close == other.shutter_close;
  }
};

// kMaterial: everything that shines by that material.
enum class EditedLight : uint8_t { kPunctual, kMaterial, kEnvironment };

// What a light's own radiance is multiplied by. A material that does not emit stays dark.
struct LightEdit {
  EditedLight kind = EditedLight::kPunctual;
  EditTarget target;  // kEnvironment: its place alone
  float intensity = 1.0f;
  Rgb color = Rgb(1.0f);  // linear Rec. 709
  bool on = true;

  bool operator==(const LightEdit&) const = default;
};

// Values of EnvironmentDescription that replace the scene's.
struct EnvironmentEdit {
  std::string file;                    // empty: the environment that is there
  std::shared_ptr<const Image> image;  // of the file; kHalf or kFloat, 3 channels
  uint64_t repaired_texels = 0;        // when it was read
  std::optional<float> strength;
  std::optional<float> rotation_degrees;
  std::string place;  // for messages

  bool operator==(const EnvironmentEdit& other) const {
    return file == other.file && image == other.image && strength == other.strength &&
           rotation_degrees == other.rotation_degrees;
  }
};

// Factors of MaterialDescription that replace the file's. Textures stay and are multiplied by them.
// material_parameters.h has their names and ranges.
struct MaterialEdit {
  EditTarget target;
  std::optional<Rgb> base_color;
  std::optional<float> roughness, metallic, transmission, normal_scale;
  std::optional<Rgb> emission;  // radiance; before any LightEdit of the material
  std::optional<float> ior;     // not of one that reflects everything
  std::optional<float> specular;
  std::optional<Rgb> specular_color;
  std::optional<Rgb> attenuation_color;       // these three: where there is an interior
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

// The ends of the ranges that a file of edits is held to, as the command line has them for its own
// options: squares of distances stay finite in float, and so does radiance times what a film sums
// up.
namespace edit_limits {
inline constexpr double kFarthest = 1e15;      // metres
inline constexpr double kBrightest = 1e9;      // radiance, and what multiplies it
inline constexpr double kMostTurns = 36000.0;  // degrees
}  // namespace edit_limits

struct SceneEdits {
  CameraEdit camera;
  // Whoever loads or poses the scene asks for it (GltfOptions); apply() does not.
  AnimationEdit animation;
  // Of SceneDescription::variants; absent: the meshes wear their own materials.
  std::optional<EditTarget> variant;
  std::vector<LightEdit> lights;
  EnvironmentEdit environment;
  std::vector<MaterialEdit> materials;

  bool operator==(const SceneEdits&) const = default;
};

// The index of what `target` means in a list of the description; none where that is not there, or
// where several have its name and its index says of none of them that it is the one.
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

// Makes the edits in a description, whole or an outline. A scene without any light is first given
// the plain white environment that build_scene would give it; what the edits turn off then stays
// dark. glTF's default material, where a placed mesh has it, becomes one more of
// `description.materials`, last and named kDefaultMaterialName.
//
// A variant is put on first, so that materials are edited by what they are called in the file.
// Whether a scene has any light is asked of the file's own materials: the light of a variant comes
// on top of the white environment that a file without light is given.
//
// Throws InputError (the edit's place, the valid names) for a target that is not there, or that
// two edits name, for a variant of a description that was loaded without what they wear, for an
// environment edit where there is no environment, for anisotropy of what was loaded without
// tangents, and for an index of refraction where there is none; the description is then as it was.
// Values are taken as they are: edits_file.h holds a file's to their ranges.
void apply(const SceneEdits& edits, SceneDescription& description);
inline constexpr const char* kDefaultMaterialName = "default material";

// Whether they make a material anisotropic, so that the scene is to be loaded with
// GltfOptions::tangents.
bool need_tangents(const SceneEdits& edits);

// The index of the light, or of the material, that an edit means; 0 for the environment. Throws
// InputError for one that is not there.
size_t edited_light(const LightEdit& edit, const SceneDescription& description);

// The view that `edits` make of `camera`, which is what is looked through without them. Throws
// InputError for a camera that is not there, a field of view or a lens for an orthographic one, a
// lens that is focused nowhere, and a view from where it looks at.
CameraDescription edited_camera(const SceneEdits& edits, const SceneDescription& description,
                                CameraDescription camera);

// All of a description but vertices and triangles, which an edit does not change: enough for
// apply() and EditableScene.
SceneDescription outline(const SceneDescription& description);

}  // namespace emberline
