// KHR_materials_variants: other materials for the same meshes, chosen for the whole file at once.
#pragma once

#include <string>
#include <vector>

#include "io/gltf/document/document.h"
#include "renderer/description/scene_description.h"

namespace emberline {

// The file's variants, in its order, which is what `variant` of VariantMaterial counts.
std::vector<VariantDescription> read_variants(const GltfDocument& document);

// How long the next one's list will be.
uint64_t variant_material_count(const nlohmann::json& primitive);

// What a primitive wears in which variant, by growing `variant`; in those that are absent it wears
// its own material, as it does where the mapping or its material is broken and the extension
// optional. `pointer` is the primitive's. Throws InputError for a variant given twice.
std::vector<VariantMaterial> read_variant_materials(const GltfDocument& document,
                                                    const nlohmann::json& primitive,
                                                    const std::string& pointer);

}  // namespace emberline
