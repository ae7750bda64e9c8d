// Reads KHR_materials_variants: alternative materials for the file's meshes.
#pragma once

#include <string>
#include <vector>

#include "io/gltf/document/document.h"
#include "renderer/description/scene_description.h"

namespace emberline {

// Returns the file's variants in file order. VariantMaterial::variant is an index into the result.
std::vector<VariantDescription> read_variants(const GltfDocument& document);

// Returns an upper bound on the length of the list that read_variant_materials() returns.
uint64_t variant_material_count(const nlohmann::json& primitive);

// Returns the primitive's materials in ascending order of `variant`. A variant that is not listed
// uses the primitive's own material. So does a variant whose mapping or material is broken, if the
// extension is optional. `pointer` refers to the primitive. Throws InputError for duplicates.
std::vector<VariantMaterial> read_variant_materials(const GltfDocument& document,
                                                    const nlohmann::json& primitive,
                                                    const std::string& pointer);

}  // namespace emberline
