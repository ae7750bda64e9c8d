// One glTF primitive as a MeshDescription.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/gltf/document/document.h"
#include "renderer/core/errors.h"
#include "renderer/description/scene_description.h"

namespace emberline {

// The pose of one use of a mesh.
struct MeshPose {
  std::span<const double> weights;  // of the morph targets; empty: all 0
  // Bind space to the instance's space, row vectors, one per joint; empty: no skin.
  std::span<const Mat44d> joints;
};

// What of a material decides the tangents of the meshes that wear it.
struct TangentLayout {
  bool wanted = false;
  int uv_set = 0;
  std::array<float, 6> uv_transform = {};

  bool operator==(const TangentLayout&) const = default;
};
std::vector<TangentLayout> tangent_layouts(std::span<const MaterialDescription* const> materials);

struct LoadedMesh {
  MeshDescription mesh;  // without triangles when nothing survived
  LoadRepairs repairs;
  std::vector<std::string> ignored, approximated;  // for the coverage report
  std::optional<InputError> draco_fault;           // the stream was not read, its fallback was
  std::optional<InputError> variants_fault;        // nor what it wears in other variants
  // Of a primitive of points or lines: its mode, and how many it draws.
  int mode = 4;
  uint64_t without_surface = 0;
  uint64_t bytes = 0;  // reserved for the mesh
};

// `flat`: its transform flattens it, so that its normals are those of the plane, and none is read.
// `poses`: at even times of the shutter, or one; or, with `later`, one and the one of
// MeshDescription::later. `materials` are all that the primitive may be
// shaded with, its own first; they decide which UV sets are kept (0 always) and whether tangents
// are needed, which `tangents` asks for in any case. Throws InputError. Thread-safe.
LoadedMesh load_primitive(const GltfDocument& document, size_t mesh, size_t primitive,
                          std::span<const MeshPose> poses, bool later,
                          std::span<const MaterialDescription* const> materials, bool tangents,
                          bool flat = false);

}  // namespace emberline
