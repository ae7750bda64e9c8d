// Materials and the textures they name.
#pragma once

#include "io/gltf.h"
#include "io/gltf_document.h"
#include "io/tiny_gltf_forward.h"
#include "renderer/scene/scene_description.h"

namespace emberline {

// One MaterialDescription per glTF material; TextureRef::image holds glTF image indices here.
// What is ignored or approximated goes to `coverage`. Throws InputError, also for a texture without
// an image (one in a format that only an extension names) unless options.lenient.
std::vector<MaterialDescription> read_materials(const GltfDocument& document,
                                                const tinygltf::Model& model,
                                                const GltfOptions& options,
                                                CoverageReport& coverage);

}  // namespace emberline
