#include "io/gltf_variants.h"

#include <algorithm>

#include "renderer/core/errors.h"

namespace emberline {
namespace {

constexpr const char* kExtension = "KHR_materials_variants";

}  // namespace

std::vector<VariantDescription> read_variants(const GltfDocument& document) {
  std::vector<VariantDescription> variants;
  const nlohmann::json* extension = find_extension(document.json, kExtension);
  if (!extension) return variants;
  for (const nlohmann::json& variant : extension->at("variants")) {
    variants.push_back({variant.at("name").get<std::string>()});
  }
  return variants;
}

uint64_t variant_material_count(const nlohmann::json& primitive) {
  const nlohmann::json* extension = find_extension(primitive, kExtension);
  if (!extension) return 0;
  uint64_t count = 0;
  for (const nlohmann::json& mapping : extension->at("mappings")) {
    count += mapping.at("variants").size();
  }
  return count;
}

std::vector<VariantMaterial> read_variant_materials(const GltfDocument& document,
                                                    const nlohmann::json& primitive,
                                                    const std::string& pointer) {
  std::vector<VariantMaterial> worn;
  const nlohmann::json* extension = find_extension(primitive, kExtension);
  if (!extension) return worn;
  for (const nlohmann::json& mapping : extension->at("mappings")) {
    const int material = mapping.at("material").get<int>();
    for (const nlohmann::json& variant : mapping.at("variants")) {
      worn.push_back({variant.get<int>(), material});
    }
  }
  std::ranges::sort(worn, {}, &VariantMaterial::variant);
  const auto twice = std::ranges::adjacent_find(worn, {}, &VariantMaterial::variant);
  if (twice != worn.end()) {
    throw InputError(document.place(pointer + "/extensions/" + kExtension + "/mappings"),
                     "variant {} has two materials", twice->variant);
  }
  return worn;
}

}  // namespace emberline
