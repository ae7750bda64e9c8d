// What of an open file is the same in every pose, once it has been read.
#pragma once

#include <map>
#include <tuple>
#include <vector>

#include "io/gltf/geometry/mesh.h"
#include "io/gltf/materials/images.h"
#include "renderer/core/vector.h"

namespace emberline {

// A primitive that no animation deforms.
struct RestMesh {
  uint64_t key = 0;   // MeshDescription's
  LoadedMesh loaded;  // without the arrays, which whoever gets the pose takes over
  WorldBounds bounds;
  double radius = 0.0;                 // of a ball around the origin
  std::vector<TangentLayout> layouts;  // that it was read for
};

struct GltfRest {
  // Mesh, primitive, skin, node or -1, and whether it is flat.
  using MeshId = std::tuple<size_t, size_t, int, int, bool>;
  std::map<MeshId, RestMesh> meshes;
  uint64_t last_key = 0;
  std::map<int, GltfImage> images;  // by glTF image
  TextureStore textures;            // where their texels are
  uint64_t image_bytes = 0;         // of those: reserved, and given back by who owns this
  std::map<size_t, std::vector<Mat44d>> instancing;  // by node
  MemoryReservation memory;                          // of that
  // Of the pose made last: something of it deforms, so that its vertices will be wanted again; what
  // is reserved for its meshes that rest, and for those of them that were read for it.
  bool deforms = false;
  uint64_t resting_bytes = 0, read_bytes = 0;
};

}  // namespace emberline
