// The object model as tinygltf reads it.
#pragma once

#include <memory>

#include "io/gltf/document/document.h"
#include "io/gltf/document/tiny_gltf_forward.h"

namespace emberline {

// Asset, scenes, nodes, materials, textures, samplers, cameras, skins and punctual lights of a
// checked document, with glTF's defaults filled in. tinygltf does not get to see the bytes: it
// reads what check_schema has passed, without extras, buffers, accessors, meshes and images,
// because version 2.7 follows indices and offsets of those without looking. Throws InputError.
std::shared_ptr<const tinygltf::Model> parse_gltf_model(const GltfDocument& document);

// About what that takes, and its making; for a budget.
uint64_t gltf_model_bytes(const GltfDocument& document);

}  // namespace emberline
