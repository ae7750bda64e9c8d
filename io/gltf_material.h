// Materials and the textures they name.
#pragma once

#include "io/gltf_document.h"
#include "renderer/scene/scene_description.h"

namespace tinygltf {
class Model;
}

namespace emberline {

// One MaterialDescription per glTF material; TextureRef::image holds glTF image indices here.
// What is ignored or approximated goes to `coverage`. Throws InputError.
std::vector<MaterialDescription> read_materials(const GltfDocument& document,
                                                const tinygltf::Model& model,
                                                CoverageReport& coverage);

}  // namespace emberline
