#include "io/gltf/materials/material.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "io/gltf/document/tiny_gltf_renamed.h"
#include "io/gltf/materials/object.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

void read_metallic_roughness(const GltfMaterialObject& object, MaterialDescription& material) {
  object.unit_factors("baseColorFactor", material.base_color, material.alpha);
  object.texture("baseColorTexture", material.base_color_texture);
  object.unit_factor("metallicFactor", material.metallic);
  object.unit_factor("roughnessFactor", material.roughness);
  object.texture("metallicRoughnessTexture", material.metallic_roughness_texture);
}

// If both models are present, uses specular-glossiness, since metallic-roughness is then a fallback
// (the extension's "Best practices"). An unlit material takes its colour from metallic-roughness.
void read_base(const GltfMaterialObject& object, MaterialDescription& material) {
  const auto metallic_roughness = object.member("pbrMetallicRoughness");
  const auto glossy = object.extension(kSpecularGlossiness);
  if (glossy && !(material.unlit && metallic_roughness)) {
    read_specular_glossiness(*glossy, material);
  } else if (metallic_roughness) {
    read_metallic_roughness(*metallic_roughness, material);
  }
}

void read_emission(const GltfMaterialObject& object, MaterialDescription& material) {
  object.texture("emissiveTexture", material.emission_texture);
  object.non_negative("emissiveFactor", material.emission);
  const char* const extension = "KHR_materials_emissive_strength";
  if (const auto strength = object.extension(extension)) {
    float factor = 1.0f;
    strength->number("emissiveStrength", factor, kNotNegative);
    if (is_finite(material.emission * factor)) {
      material.emission *= factor;
    } else {
      strength->fail("emissiveStrength", "the emission is not finite");
    }
  }
}

void read_alpha(const GltfMaterialObject& object, const tinygltf::Material& source,
                MaterialDescription& material) {
  if (source.alphaMode == "MASK") {
    material.alpha_mode = AlphaMode::kMask;
  } else if (source.alphaMode == "BLEND") {
    material.alpha_mode = AlphaMode::kBlend;
  } else if (source.alphaMode != "OPAQUE" && !source.alphaMode.empty()) {
    throw InputError(object.place("alphaMode"),
                     "unknown alphaMode \"{}\", expected OPAQUE, MASK or BLEND",
                     shortened(source.alphaMode));
  }
  material.alpha_cutoff = float(source.alphaCutoff);
}

MaterialDescription read_material(const MaterialFile& file, size_t i) {
  const tinygltf::Material& source = file.document.model->materials[i];
  const GltfMaterialObject object(file, file.document.json->at("materials")[i],
                                  "/materials/" + std::to_string(i));
  MaterialDescription material;
  material.name = source.name;
  material.unlit = object.extension("KHR_materials_unlit").has_value();
  read_base(object, material);
  object.normal_texture("normalTexture", material.normal_texture, material.normal_scale);
  read_emission(object, material);
  read_material_layers(object, material);
  read_alpha(object, source, material);
  material.double_sided = source.doubleSided;
  if (object.has_texture("occlusionTexture"))
    object.report_ignored("occlusionTexture (occlusion is computed by ray tracing)");
  return material;
}

void warn_clamped(const std::string& what, const ClampedFactors::List& list) {
  if (list.named.empty()) return;
  std::string text = fmt::format("{}: {}", what, fmt::join(list.named, ", "));
  if (list.more > 0) text += fmt::format(", and {} more", list.more);
  log_warning(text);
}

}  // namespace

std::vector<MaterialDescription> read_materials(const GltfDocument& document,
                                                const GltfOptions& options,
                                                CoverageReport& coverage) {
  ClampedFactors clamped;
  const MaterialFile file = {document, options, coverage, clamped};
  std::vector<MaterialDescription> materials;
  for (size_t i = 0; i < document.model->materials.size(); ++i) {
    materials.emplace_back().name = document.model->materials[i].name;
    if (document.array("materials")[i].is_null()) continue;
    try {
      materials.back() = read_material(file, i);
    } catch (const InputError& error) {
      document.faults->note_broken("/materials/" + std::to_string(i), error);
    }
  }
  warn_clamped(document.file + ": material factors outside [0, 1] are clamped",
               clamped.unit_factors);
  warn_clamped(document.file + ": negative material colours are replaced by 0", clamped.colors);
  return materials;
}

}  // namespace emberline
