// KHR_materials_variants: alternative materials for the file's meshes.
#pragma once

#include <string>
#include <vector>

#include "io/gltf/document/document.h"
#include "renderer/description/scene_description.h"

namespace emberline {

// The file's variants, in file order; VariantMaterial::variant is an index into them.
std::vector<VariantDescription> read_variants(const GltfDocument& document);

// Length of the list that read_variant_materials() will return.
uint64_t variant_material_count(const nlohmann::json& primitive);

// The primitive's materials by ascending `variant`. Variants that are absent use its own material;
// so do those whose mapping or material is broken, if the extension is optional. `pointer` is the
// primitive's. Throws InputError for a duplicate variant.
std::vector<VariantMaterial> read_variant_materials(const GltfDocument& document,
                                                    const nlohmann::json& primitive,
                                                    const std::string& pointer);

}  // namespace emberline
