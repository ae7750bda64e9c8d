#include "io/gltf/materials/variants.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "renderer/core/errors.h"

namespace emberline {

constexpr const char* kExtension = "KHR_materials_variants";

std::vector<VariantDescription> read_variants(const GltfDocument& document) {
  std::vector<VariantDescription> variants;
  const nlohmann::json* extension = find_extension(*document.json, kExtension);
  if (!extension) return variants;
  for (const nlohmann::json& variant : extension->at("variants")) {
    const nlohmann::json* name = find_member(variant, "name");
    variants.push_back({name ? name->get<std::string>() : std::string()});
  }
  return variants;
}

uint64_t variant_material_count(const nlohmann::json& primitive) {
  const nlohmann::json* extension = find_extension(primitive, kExtension);
  if (!extension) return 0;
  uint64_t count = 0;
  for (const nlohmann::json& mapping : extension->at("mappings")) {
    if (!mapping.is_null()) count += mapping.at("variants").size();
  }
  return count;
}

std::vector<VariantMaterial> read_variant_materials(const GltfDocument& document,
                                                    const nlohmann::json& primitive,
                                                    const std::string& pointer) {
  std::vector<VariantMaterial> variant_materials;
  const nlohmann::json* extension = find_extension(primitive, kExtension);
  if (!extension) return variant_materials;
  const std::string place = pointer + "/extensions/" + kExtension + "/mappings";
  size_t i = 0;
  for (const nlohmann::json& mapping : extension->at("mappings")) {
    const std::string mapping_pointer = place + "/" + std::to_string(i++);
    if (mapping.is_null()) {
      if (document.requires_extension(kExtension)) document.faults->require(mapping_pointer);
      continue;
    }
    const int material = mapping.at("material").get<int>();
    const std::string material_pointer = "/materials/" + std::to_string(material);
    if (!document.requires_extension(kExtension) && document.faults->has(material_pointer))
      continue;
    for (const nlohmann::json& variant : mapping.at("variants")) {
      variant_materials.push_back({variant.get<int>(), material});
    }
  }
  std::ranges::sort(variant_materials, {}, &VariantMaterial::variant);
  const auto twice = std::ranges::adjacent_find(variant_materials, {}, &VariantMaterial::variant);
  if (twice != variant_materials.end()) {
    throw InputError(document.place(place), "variant {} has two materials", twice->variant);
  }
  return variant_materials;
}

}  // namespace emberline
