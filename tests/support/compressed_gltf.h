// Creates glTF files with Draco and meshopt streams, using the encoders of these libraries.
#pragma once

#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <meshoptimizer.h>

#include <cstdint>
#include <string>
#include <vector>

#include "support/gltf_builder.h"

namespace emberline::test {

// Returns a unit square of two triangles with positions, UVs and colours.
GltfBuilder draco_square(int method, bool with_metadata = false);

struct MeshoptView {
  std::vector<uint8_t> encoded;
  size_t count, stride;
  std::string mode;
  std::string filter;
};

template <class T>
MeshoptView encode_vertices(const std::vector<T>& values, size_t stride,
                            const std::string& filter = "") {
  MeshoptView view;
  view.count = values.size() * sizeof(T) / stride;
  view.stride = stride;
  view.mode = "ATTRIBUTES";
  view.filter = filter;
  view.encoded.resize(meshopt_encodeVertexBufferBound(view.count, stride));
  meshopt_encodeVertexVersion(0);
  view.encoded.resize(meshopt_encodeVertexBuffer(view.encoded.data(), view.encoded.size(),
                                                 values.data(), view.count, stride));
  return view;
}

inline MeshoptView encode_indices(const std::vector<uint32_t>& indices, bool sequence) {
  MeshoptView view;
  view.count = indices.size();
  view.stride = 2;
  view.mode = sequence ? "INDICES" : "TRIANGLES";
  meshopt_encodeIndexVersion(1);
  view.encoded.resize(sequence ? meshopt_encodeIndexSequenceBound(indices.size(), 100)
                               : meshopt_encodeIndexBufferBound(indices.size(), 100));
  view.encoded.resize(sequence
                          ? meshopt_encodeIndexSequence(view.encoded.data(), view.encoded.size(),
                                                        indices.data(), indices.size())
                          : meshopt_encodeIndexBuffer(view.encoded.data(), view.encoded.size(),
                                                      indices.data(), indices.size()));
  return view;
}

// Adds the stream to buffer 0. Adds and returns a view of the fallback buffer 1, which has no data.
int add_meshopt_view(GltfBuilder& gltf, const MeshoptView& stream,
                     const std::string& extension = "EXT_meshopt_compression");

int add_meshopt_accessor(GltfBuilder& gltf, int view, int type, size_t count,
                         const std::string& shape, bool normalized = false);

GltfBuilder meshopt_triangle(bool sequence,
                             const std::string& extension = "EXT_meshopt_compression");

}  // namespace emberline::test
