// Loads one glTF primitive as a MeshDescription.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/gltf/document/document.h"
#include "renderer/core/errors.h"
#include "renderer/description/scene_description.h"

namespace emberline {

// The pose in which a mesh is used.
struct MeshPose {
  std::span<const double> weights;  // morph target weights; all 0 if empty
  // For each joint, the matrix from bind space to instance space (for row vectors). Empty if there
  // is no skin.
  std::span<const Mat44d> joints;
};

// The properties of a material that determine a mesh's tangents.
struct TangentLayout {
  bool required = false;
  int uv_set = 0;
  std::array<float, 6> uv_transform = {};

  bool operator==(const TangentLayout&) const = default;
};
std::vector<TangentLayout> tangent_layouts(std::span<const MaterialDescription* const> materials);

struct LoadedMesh {
  MeshDescription mesh;  // has no triangles if all were dropped
  LoadRepairs repairs;
  std::vector<std::string> ignored, approximated;  // for the coverage report
  std::optional<InputError> draco_fault;           // set if Draco data was not used; says why
  std::optional<InputError> variants_fault;        // set if the variants are broken
  // If the primitive consists of points or lines: its mode, and how many points or lines it would
  // draw.
  int mode = 4;
  uint64_t surfaceless_count = 0;
  uint64_t bytes = 0;  // reserved for the mesh
};

// `poses` has a single pose; or the poses at evenly spaced times while the shutter is open; or,
// with `next_frame`, the current pose and the pose of MeshDescription::next_frame.
//
// `materials` are all materials that may shade the primitive, and the primitive's own material
// comes first. They decide which UV sets are kept (set 0 always is) and whether the mesh gets
// tangents. With `tangents`, the mesh always gets tangents. `flat` means that the instance
// transform flattens the mesh. The mesh's normals are then not read, since the normals of the plane
// are used.
//
// Throws InputError. Thread-safe.
LoadedMesh load_primitive(const GltfDocument& document, size_t mesh, size_t primitive,
                          std::span<const MeshPose> poses, bool next_frame,
                          std::span<const MaterialDescription* const> materials, bool tangents,
                          bool flat = false);

}  // namespace emberline
