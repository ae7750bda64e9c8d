#include "io/gltf_material.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "io/gltf_extensions.h"
#include "io/gltf_images.h"
#include "io/gltf_specular_glossiness.h"
#include "io/tiny_gltf_renamed.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

using nlohmann::json;

WrapMode wrap_mode(int code, const std::string& place) {
  switch (code) {
    case 10497:
      return WrapMode::kRepeat;
    case 33648:
      return WrapMode::kMirroredRepeat;
    case 33071:
      return WrapMode::kClampToEdge;
    default:
      throw InputError(place, "unknown wrap mode {}", code);
  }
}

// KHR_texture_transform: uv' = translation * rotation * scale * uv, with the rotation as its
// README writes it (counter-clockwise in a space with v downwards).
std::array<float, 6> transform_matrix(const json& extension) {
  const std::vector<double> offset = extension.value("offset", std::vector<double>{0.0, 0.0});
  const std::vector<double> scale = extension.value("scale", std::vector<double>{1.0, 1.0});
  const double angle = extension.value("rotation", 0.0);
  const double c = std::cos(angle), s = std::sin(angle);
  return {float(c * scale[0]),  float(s * scale[1]), float(offset[0]),
          float(-s * scale[0]), float(c * scale[1]), float(offset[1])};
}

class MaterialReader {
 public:
  MaterialReader(const GltfDocument& document, const tinygltf::Model& model,
                 const GltfOptions& options, CoverageReport& coverage)
      : document_(document), model_(model), options_(options), coverage_(coverage) {}

  MaterialDescription read(size_t i);

 private:
  // The slot `name` of `owner`; none when the member is absent.
  TextureRef texture(const json& owner, const char* name, const std::string& pointer);
  float unit(double value) {
    if (value >= 0.0 && value <= 1.0) return float(value);
    log_warning(document_.file + ": material factors outside [0, 1] are clamped");
    return float(std::clamp(value, 0.0, 1.0));
  }
  void read_dielectric(const json& object, const std::string& pointer,
                       MaterialDescription& material);
  void read_alpha(const tinygltf::Material& source, const std::string& pointer,
                  MaterialDescription& material) const;

  const GltfDocument& document_;
  const tinygltf::Model& model_;
  const GltfOptions& options_;
  CoverageReport& coverage_;
};

TextureRef MaterialReader::texture(const json& owner, const char* name,
                                   const std::string& pointer) {
  TextureRef ref;
  const json* info = find_member(owner, name);
  if (!info) return ref;
  const size_t index = info->at("index").get<size_t>();
  const tinygltf::Texture& source = model_.textures[index];
  const json& texture_object = document_.json.at("textures")[index];
  const std::vector<int> sources = texture_sources(texture_object);
  if (!sources.empty()) ref.image = sources[0];
  if (ref.image < 0 && options_.lenient) {
    report_ignored(document_.file, "a texture without a PNG, JPEG, WebP or KTX 2 image", coverage_);
    return ref;
  }
  if (ref.image < 0) {
    throw InputError(document_.place("/textures/" + std::to_string(index)),
                     "the texture of " + pointer + "/" + name +
                         " has no image in a format that is supported (PNG, JPEG, WebP, KTX 2)");
  }
  ref.uv_set = info->value("texCoord", 0);
  if (source.sampler >= 0) {
    const tinygltf::Sampler& sampler = model_.samplers[size_t(source.sampler)];
    const std::string place = document_.place("/samplers/" + std::to_string(source.sampler));
    ref.wrap_s = wrap_mode(sampler.wrapS, place + "/wrapS");
    ref.wrap_t = wrap_mode(sampler.wrapT, place + "/wrapT");
    ref.nearest = sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
  }
  if (const json* transform = find_extension(*info, "KHR_texture_transform")) {
    ref.uv_transform = transform_matrix(*transform);
    ref.uv_set = transform->value("texCoord", ref.uv_set);
  }
  return ref;
}

void MaterialReader::read_alpha(const tinygltf::Material& source, const std::string& pointer,
                                MaterialDescription& material) const {
  if (source.alphaMode == "MASK") {
    material.alpha_mode = AlphaMode::kMask;
  } else if (source.alphaMode == "BLEND") {
    material.alpha_mode = AlphaMode::kBlend;
  } else if (source.alphaMode != "OPAQUE" && !source.alphaMode.empty()) {
    throw InputError(document_.place(pointer + "/alphaMode"),
                     "unknown alphaMode \"{}\", expected OPAQUE, MASK or BLEND",
                     shortened(source.alphaMode));
  }
  material.alpha_cutoff = float(source.alphaCutoff);
}

// KHR_materials_ior, _specular, _transmission and _volume.
void MaterialReader::read_dielectric(const json& object, const std::string& pointer,
                                     MaterialDescription& material) {
  if (const json* ior = find_extension(object, "KHR_materials_ior")) {
    material.ior = ior->value("ior", 1.5f);
    if (!(material.ior >= 1.0f || material.ior == 0.0f) || !std::isfinite(material.ior)) {
      throw InputError(document_.place(pointer + "/extensions/KHR_materials_ior/ior"),
                       "an index of refraction is at least 1, or 0");
    }
  }
  if (const json* specular = find_extension(object, "KHR_materials_specular")) {
    material.specular = unit(specular->value("specularFactor", 1.0));
    const std::string place = pointer + "/extensions/KHR_materials_specular";
    material.specular_texture = texture(*specular, "specularTexture", place);
    material.specular_color_texture = texture(*specular, "specularColorTexture", place);
    const std::vector<double> color =
        specular->value("specularColorFactor", std::vector<double>{1.0, 1.0, 1.0});
    for (size_t c = 0; c < 3; ++c) {
      material.specular_color[int(c)] = float(std::max(0.0, c < color.size() ? color[c] : 1.0));
    }
  }
  const json* transmission = find_extension(object, "KHR_materials_transmission");
  if (!transmission) return;
  material.transmission = unit(transmission->value("transmissionFactor", 0.0));
  material.transmission_texture = texture(*transmission, "transmissionTexture",
                                          pointer + "/extensions/KHR_materials_transmission");
  const json* volume = find_extension(object, "KHR_materials_volume");
  if (!volume || !(volume->value("thicknessFactor", 0.0) > 0.0)) return;
  material.thin_walled = false;
  const std::vector<double> color =
      volume->value("attenuationColor", std::vector<double>{1.0, 1.0, 1.0});
  for (size_t c = 0; c < 3; ++c) {
    material.attenuation_color[int(c)] = unit(c < color.size() ? color[c] : 1.0);
  }
  const float distance =
      volume->value("attenuationDistance", std::numeric_limits<float>::infinity());
  if (!(distance > 0.0f)) {
    throw InputError(document_.place(pointer + "/extensions/KHR_materials_volume"),
                     "attenuationDistance must be greater than 0");
  }
  material.attenuation_distance = distance;
}

MaterialDescription MaterialReader::read(size_t i) {
  const tinygltf::Material& source = model_.materials[i];
  const json& object = document_.json.at("materials")[i];
  const std::string pointer = "/materials/" + std::to_string(i);
  static const json none = json::object();
  const json* pbr_member = find_member(object, "pbrMetallicRoughness");
  const json& pbr_object = pbr_member ? *pbr_member : none;
  const tinygltf::PbrMetallicRoughness& pbr = source.pbrMetallicRoughness;

  MaterialDescription material;
  material.name = source.name;
  material.base_color = Rgb(unit(pbr.baseColorFactor.at(0)), unit(pbr.baseColorFactor.at(1)),
                            unit(pbr.baseColorFactor.at(2)));
  material.alpha = unit(pbr.baseColorFactor.at(3));
  material.metallic = unit(pbr.metallicFactor);
  material.roughness = unit(pbr.roughnessFactor);
  const std::string pbr_pointer = pointer + "/pbrMetallicRoughness";
  material.base_color_texture = texture(pbr_object, "baseColorTexture", pbr_pointer);
  material.metallic_roughness_texture =
      texture(pbr_object, "metallicRoughnessTexture", pbr_pointer);
  material.normal_texture = texture(object, "normalTexture", pointer);
  if (const json* normal = find_member(object, "normalTexture")) {
    material.normal_scale = normal->value("scale", 1.0f);
  }
  material.emission_texture = texture(object, "emissiveTexture", pointer);
  for (int c = 0; c < 3; ++c) {
    material.emission[c] = float(std::max(source.emissiveFactor.at(size_t(c)), 0.0));
  }
  if (const json* strength = find_extension(object, "KHR_materials_emissive_strength")) {
    material.emission *= strength->value("emissiveStrength", 1.0f);
    if (!is_finite(material.emission)) {
      throw InputError(document_.place(pointer + "/extensions/KHR_materials_emissive_strength"),
                       "the emission is too large to be finite");
    }
  }
  read_dielectric(object, pointer, material);
  read_alpha(source, pointer, material);
  material.double_sided = source.doubleSided;
  material.unlit = find_extension(object, "KHR_materials_unlit") != nullptr;
  if (object.contains("occlusionTexture")) {
    report_ignored(document_.file, "occlusionTexture", coverage_);
  }
  // Where a file carries both, its own metallic-roughness values are the better fallback.
  const json* glossy = find_extension(object, "KHR_materials_pbrSpecularGlossiness");
  if (glossy && !pbr_member) {
    convert_specular_glossiness(*glossy, material);
    material.base_color_texture = texture(
        *glossy, "diffuseTexture", pointer + "/extensions/KHR_materials_pbrSpecularGlossiness");
  }
  return material;
}

}  // namespace

std::vector<MaterialDescription> read_materials(const GltfDocument& document,
                                                const tinygltf::Model& model,
                                                const GltfOptions& options,
                                                CoverageReport& coverage) {
  MaterialReader reader(document, model, options, coverage);
  std::vector<MaterialDescription> materials;
  for (size_t i = 0; i < model.materials.size(); ++i) {
    materials.emplace_back().name = model.materials[i].name;
    if (document.array("materials")[i].is_null()) continue;
    try {
      materials.back() = reader.read(i);
    } catch (const InputError& error) {
      document.faults->note("/materials/" + std::to_string(i), error);
    }
  }
  return materials;
}

}  // namespace emberline
