// What hangs on a node besides a mesh: cameras, punctual lights, instance transforms.
#pragma once

#include "io/gltf/animation/animation.h"
#include "io/gltf/document/document.h"
#include "renderer/core/constants.h"
#include "renderer/description/scene_description.h"

namespace emberline {

std::string node_name(const GltfDocument& document, size_t node);

// Append the node's camera or light to `scene`, or count and skip it when its transform leaves it
// no direction. A camera of values without meaning has its fault with it; of a light they throw
// InputError.
CameraDescription* read_camera(const GltfDocument& document, size_t node, const GltfPose& pose,
                               const Mat44d& to_world, SceneDescription& scene);
PunctualLightDescription* read_punctual_light(const GltfDocument& document, size_t node,
                                              const GltfPose& pose, const Mat44d& to_world,
                                              SceneDescription& scene);

// What a camera's and a spot's numbers are, also while they change. Throw InputError.
double field_of_view(double yfov, const std::string& place);
double magnification(double ymag, const std::string& place);

// What a spot's cones and a lamp's range are. A value out of its range has the default, and a
// warning that names the member of the lamp at `pointer`; where the file requires the extension, it
// throws InputError.
Vec2f cone_angles(double inner, double outer, const GltfDocument& document,
                  const std::string& pointer);
float light_range(double range, const GltfDocument& document, const std::string& pointer);
// The widest outerConeAngle is pi / 2, which writers may have rounded up.
inline constexpr double kWidestCone = kPiD / 2.0 * (1.0 + 1e-6);

// EXT_mesh_gpu_instancing: one transform per instance, relative to the node. What they take is
// added to `memory`.
std::vector<Mat44d> read_instance_transforms(const GltfDocument& document,
                                             const nlohmann::json& extension, size_t node,
                                             MemoryReservation& memory);

}  // namespace emberline
