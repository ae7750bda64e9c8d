// Edits of a scene, in a small JSON file beside the scene file ("sidecar") that people can read and
// change:
//
// clang-format off
//   {
//     "emberline_edits": 1,
//     "camera": {"file_camera": {"name": "main", "index": 0}, "fov_y": 35,
//                "look_from": [0, 1, 4], "look_at": [0, 0.5, 0], "up": [0, 1, 0],
//                "mirrored": false, "f_stop": 2.8, "focus_distance": 4},
//     "animation": {"name": "walk", "time": 1.5, "fps": 24,
//                   "shutter_open": 0, "shutter_close": 0.5},
//     "variant": {"name": "beach", "index": 1},
//     "environment": {"file": "studio.hdr", "strength": 1, "rotation": 30},
//     "lights": [{"kind": "punctual", "name": "Key", "index": 0,
//                 "intensity": 2, "color": [1, 0.9, 0.8], "on": true},
//                {"kind": "material", "name": "neon", "on": false},
//                {"kind": "environment", "intensity": 0.5}],
//     "materials": [{"name": "glass", "index": 3, "base_color": [1, 1, 1], "roughness": 0.1,
//                    "metallic": 0, "emission": [0, 0, 0], "transmission": 1, "normal_scale": 1,
//                    "ior": 1.5, "specular": 1, "specular_color": [1, 1, 1],
//                    "attenuation_color": [1, 1, 1], "attenuation_distance": 0.1,
//                    "dispersion": 0, "diffuse_transmission": 0,
//                    "diffuse_transmission_color": [1, 1, 1],
//                    "anisotropy": 0, "anisotropy_rotation": 0,
//                    "iridescence": 0, "iridescence_ior": 1.3, "iridescence_thickness": 400,
//                    "sheen_color": [0, 0, 0], "sheen_roughness": 0,
//                    "clearcoat": 0, "clearcoat_roughness": 0}]
//   }
// clang-format on
//
// Only the version is required. An orthographic view has "orthographic_height" instead of "fov_y"
// and "f_stop". Colours are linear Rec. 709. Angles are in degrees, lengths in metres (but thin
// films in nanometres) and times in seconds (but shutter times in frames).
// renderer/description/scene_edits.h explains the members; material_parameters.cpp has the ranges
// of material parameters.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "renderer/core/load_progress.h"
#include "renderer/description/scene_edits.h"

namespace emberline {

inline constexpr int kEditsVersion = 1;

// Reads an edits file, and the environment file that it names. A relative path of the environment
// is resolved against the folder of the edits file. Throws InputError (with the file, the JSON
// pointer and what was expected) if the file is missing, is not valid JSON or has another version,
// or if a member is unknown, duplicated or out of range.
SceneEdits read_edits(const std::string& path, const LoadProgress& progress = LoadProgress::none());

// Parses `text`, named `name` in messages. A relative environment path is resolved against the
// current folder.
SceneEdits parse_edits(std::string_view text, const std::string& name,
                       const LoadProgress& progress = LoadProgress::none());

// Like parse_edits(), but takes a parsed document and does not read the environment file, because a
// session reads that file itself. A relative path is resolved against the current folder.
SceneEdits edits_from_json(const nlohmann::json& document, const std::string& name);

// Writes the edits so that reading the file back gives bit-identical edits. A relative environment
// path is written relative to the folder of `path`. Throws RenderError.
void write_edits(const std::string& path, const SceneEdits& edits);
// Returns the text of an edits file, with the environment's path unchanged.
std::string format_edits(const SceneEdits& edits);

}  // namespace emberline
