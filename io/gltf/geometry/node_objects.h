// Reads what nodes have besides meshes: cameras, punctual lights and instance transforms.
#pragma once

#include "io/gltf/animation/animation.h"
#include "io/gltf/document/document.h"
#include "renderer/core/constants.h"
#include "renderer/description/scene_description.h"

namespace emberline {

std::string node_name(const GltfDocument& document, size_t node);

// These append the node's camera or light to `scene`. If the node's transform is too degenerate to
// define a direction, they skip the object and count it in LoadRepairs::singular_instances. An
// invalid value of a camera is stored as the camera's fault. Most invalid values of a light are
// replaced by defaults; the others throw InputError.
CameraDescription* read_camera(const GltfDocument& document, size_t node, const GltfPose& pose,
                               const Mat44d& to_world, SceneDescription& scene);
PunctualLightDescription* read_punctual_light(const GltfDocument& document, size_t node,
                                              const GltfPose& pose, const Mat44d& to_world,
                                              SceneDescription& scene);

// These validate and convert a camera's values, including animated ones. They throw InputError.
double field_of_view(double yfov, const std::string& place);
double magnification(double ymag, const std::string& place);

// These validate a spot's cone angles and a light's range. A default replaces a value that is out
// of range, with a warning. If the file requires KHR_lights_punctual, they throw InputError
// instead. `pointer` refers to the light.
Vec2f cone_angles(double inner, double outer, const GltfDocument& document,
                  const std::string& pointer);
float light_range(double range, const GltfDocument& document, const std::string& pointer);
// The maximum outerConeAngle is pi / 2. Writers may have rounded it up.
inline constexpr double kMaxOuterCone = kPiD / 2.0 * (1.0 + 1e-6);

// Reads EXT_mesh_gpu_instancing: one transform per instance, relative to the node. Adds the bytes
// of the result to `memory`.
std::vector<Mat44d> read_instance_transforms(const GltfDocument& document,
                                             const nlohmann::json& extension, size_t node,
                                             MemoryReservation& memory);

}  // namespace emberline
