// The arrays of a triangle mesh, with one entry per vertex or per triangle. Loading and tracing use
// the same arrays.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "renderer/core/vector.h"

namespace emberline {

// The vertices of a deforming mesh at one time. Each step has as many vertices as the mesh.
struct MeshStep {
  std::vector<Vec3f> positions;
  std::vector<Vec3f> normals;
  std::vector<Vec4f> tangents;
};

// `positions` and each attribute that is present have one entry per vertex.
struct MeshArrays {
  std::vector<Vec3f> positions;
  std::vector<std::array<uint32_t, 3>> triangles;  // indices < positions.size(); CCW is the front
  std::vector<Vec3f> normals;   // unit length, or zero if unusable; empty: flat shading
  std::vector<Vec4f> tangents;  // xyz unit, w = +-1 (MikkTSpace convention); empty: not needed
  std::vector<std::vector<Vec2f>> uv_sets;  // each set is empty or complete
  std::vector<Vec4f> colors;                // COLOR_0, linear rgba; empty: white
  std::vector<MeshStep> motion = {};        // see Motion in scene_description.h
  std::vector<Vec3f> next_frame = {};  // positions; see NextFrameInstance in scene_description.h
  // Identifies the mesh in all poses of its file; 0 if the mesh deforms, or if the file cannot be
  // posed.
  uint64_t key = 0;
};

// Calls use(array) for each per-vertex array of a mesh, including empty ones.
template <class Mesh, class Use>
void for_each_vertex_array(Mesh& mesh, const Use& use) {
  use(mesh.positions);
  use(mesh.normals);
  use(mesh.tangents);
  for (auto& uv : mesh.uv_sets) use(uv);
  use(mesh.colors);
  use(mesh.next_frame);
  for (auto& step : mesh.motion) {
    use(step.positions);
    use(step.normals);
    use(step.tangents);
  }
}

// Returns the number of bytes that the arrays have allocated.
inline uint64_t allocated_bytes(const MeshArrays& mesh) {
  const auto bytes = [](const auto& array) { return array.capacity() * sizeof(array[0]); };
  uint64_t sum = bytes(mesh.triangles) + bytes(mesh.uv_sets) + bytes(mesh.motion);
  for_each_vertex_array(mesh, [&](const auto& array) { sum += bytes(array); });
  return sum;
}

}  // namespace emberline
