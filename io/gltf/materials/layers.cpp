#include "io/gltf/materials/object.h"

namespace emberline {
namespace {

constexpr ValidNumbers kAnyNumber = {[](float) { return true; }, "a finite number"};
constexpr ValidNumbers kPositive = {[](float x) { return x > 0.0f; }, "a number greater than 0"};
constexpr ValidNumbers kIndexOfRefraction = {[](float x) { return x >= 1.0f; },
                                             "an index of refraction of at least 1"};
constexpr ValidNumbers kIndexOfRefractionOrZero = {[](float x) { return x >= 1.0f || x == 0.0f; },
                                                   "an index of refraction of at least 1, or 0"};
constexpr ValidNumbers kNanometres = {[](float x) { return x >= 0.0f; },
                                      "a thickness in nanometres of at least 0"};

void read_ior(const GltfMaterialObject& in, MaterialDescription& m) {
  in.number("ior", m.ior, kIndexOfRefractionOrZero);
}

void read_specular(const GltfMaterialObject& in, MaterialDescription& m) {
  in.unit_factor("specularFactor", m.specular);
  in.texture("specularTexture", m.specular_texture);
  in.non_negative("specularColorFactor", m.specular_color);
  in.texture("specularColorTexture", m.specular_color_texture);
}

void read_transmission(const GltfMaterialObject& in, MaterialDescription& m) {
  in.unit_factor("transmissionFactor", m.transmission);
  in.texture("transmissionTexture", m.transmission_texture);
}

// The mesh itself bounds the volume. The thickness texture is only for rasterisers.
void read_volume(const GltfMaterialObject& in, MaterialDescription& m) {
  float thickness = 0.0f;
  in.number("thicknessFactor", thickness, kNotNegative);
  m.thin_walled = !(thickness > 0.0f);
  if (m.thin_walled) return;
  in.unit_factors("attenuationColor", m.attenuation_color);
  in.number("attenuationDistance", m.attenuation_distance, kPositive);
}

void read_dispersion(const GltfMaterialObject& in, MaterialDescription& m) {
  in.number("dispersion", m.dispersion, kNotNegative);
}

void read_diffuse_transmission(const GltfMaterialObject& in, MaterialDescription& m) {
  in.unit_factor("diffuseTransmissionFactor", m.diffuse_transmission);
  in.texture("diffuseTransmissionTexture", m.diffuse_transmission_texture);
  in.unit_factors("diffuseTransmissionColorFactor", m.diffuse_transmission_color);
  in.texture("diffuseTransmissionColorTexture", m.diffuse_transmission_color_texture);
}

void read_anisotropy(const GltfMaterialObject& in, MaterialDescription& m) {
  in.unit_factor("anisotropyStrength", m.anisotropy);
  in.number("anisotropyRotation", m.anisotropy_rotation, kAnyNumber);
  in.texture("anisotropyTexture", m.anisotropy_texture);
}

void read_iridescence(const GltfMaterialObject& in, MaterialDescription& m) {
  in.unit_factor("iridescenceFactor", m.iridescence);
  in.texture("iridescenceTexture", m.iridescence_texture);
  in.number("iridescenceIor", m.iridescence_ior, kIndexOfRefraction);
  in.number("iridescenceThicknessMinimum", m.iridescence_thickness_minimum, kNanometres);
  in.number("iridescenceThicknessMaximum", m.iridescence_thickness_maximum, kNanometres);
  in.texture("iridescenceThicknessTexture", m.iridescence_thickness_texture);
}

void read_sheen(const GltfMaterialObject& in, MaterialDescription& m) {
  in.unit_factors("sheenColorFactor", m.sheen_color);
  in.texture("sheenColorTexture", m.sheen_color_texture);
  in.unit_factor("sheenRoughnessFactor", m.sheen_roughness);
  in.texture("sheenRoughnessTexture", m.sheen_roughness_texture);
}

void read_clearcoat(const GltfMaterialObject& in, MaterialDescription& m) {
  in.unit_factor("clearcoatFactor", m.clearcoat);
  in.texture("clearcoatTexture", m.clearcoat_texture);
  in.unit_factor("clearcoatRoughnessFactor", m.clearcoat_roughness);
  in.texture("clearcoatRoughnessTexture", m.clearcoat_roughness_texture);
  in.normal_texture("clearcoatNormalTexture", m.clearcoat_normal_texture, m.clearcoat_normal_scale);
}

struct Layer {
  const char* extension;
  void (*read)(const GltfMaterialObject&, MaterialDescription&);
  bool is_base_layer = false;  // replaced by specular-glossiness, so not read together with it
};
constexpr Layer kLayers[] = {{"KHR_materials_ior", read_ior, true},
                             {"KHR_materials_specular", read_specular, true},
                             {"KHR_materials_transmission", read_transmission},
                             {"KHR_materials_volume", read_volume},
                             {"KHR_materials_dispersion", read_dispersion},
                             {"KHR_materials_diffuse_transmission", read_diffuse_transmission},
                             {"KHR_materials_anisotropy", read_anisotropy},
                             {"KHR_materials_iridescence", read_iridescence},
                             {"KHR_materials_sheen", read_sheen},
                             {"KHR_materials_clearcoat", read_clearcoat}};

}  // namespace

void read_material_layers(const GltfMaterialObject& object, MaterialDescription& material) {
  const bool glossy = object.extension(kSpecularGlossiness).has_value();
  for (const Layer& layer : kLayers) {
    const auto extension = object.extension(layer.extension);
    if (!extension) continue;
    const std::string name = layer.extension;
    if (material.unlit) {
      extension->report_ignored(name + " of unlit materials");
    } else if (layer.is_base_layer && glossy) {
      extension->report_ignored(name + " together with " + kSpecularGlossiness);
    } else {
      layer.read(*extension, material);
    }
  }
}

void read_specular_glossiness(const GltfMaterialObject& object, MaterialDescription& material) {
  MaterialDescription& m = material;
  m.ior = 0.0f;
  m.metallic = 0.0f;
  object.unit_factors("diffuseFactor", m.base_color, m.alpha);
  object.texture("diffuseTexture", m.base_color_texture);
  object.unit_factors("specularFactor", m.specular_color);
  object.texture("specularGlossinessTexture", m.specular_color_texture);
  m.glossiness_texture = m.specular_color_texture;
  float glossiness = 1.0f;
  object.unit_factor("glossinessFactor", glossiness);
  m.roughness = 1.0f - glossiness;
}

}  // namespace emberline
