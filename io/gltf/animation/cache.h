// Parts of an open file that are the same in every pose. Once read, they are kept.
#pragma once

#include <map>
#include <tuple>
#include <vector>

#include "io/gltf/geometry/mesh.h"
#include "io/gltf/materials/images.h"
#include "renderer/core/vector.h"

namespace emberline {

// A primitive that no animation deforms.
struct StaticMesh {
  uint64_t key = 0;   // MeshDescription::key; 0: the mesh has no triangles
  LoadedMesh loaded;  // without vertices and triangles, which the caller of GltfFile::pose() owns
  WorldBounds bounds;
  double radius = 0.0;                 // of a ball around the origin that contains the mesh
  std::vector<TangentLayout> layouts;  // the tangent layouts for which the mesh was read
};

struct GltfCache {
  // Mesh, primitive, skin, node (or -1), and whether the node flattens the mesh.
  using MeshId = std::tuple<size_t, size_t, int, int, bool>;
  std::map<MeshId, StaticMesh> meshes;
  uint64_t last_key = 0;
  std::map<int, GltfImage> images;  // by glTF image
  TextureStore textures;            // backing store of the texels
  uint64_t image_bytes = 0;         // reserved for images; the owner returns it to the budget
  std::map<size_t, std::vector<Mat44d>> instancing;  // by node
  MemoryReservation memory;                          // for `meshes` and `instancing`
  // State of the latest pose. `deforms`: whether any mesh deforms, so that later poses need the
  // buffers. `static_bytes`: bytes reserved for all undeformed meshes. `new_static_bytes`: the
  // bytes of those meshes that this pose read.
  bool deforms = false;
  uint64_t static_bytes = 0, new_static_bytes = 0;
};

}  // namespace emberline
