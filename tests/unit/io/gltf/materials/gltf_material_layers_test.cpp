// Tests material extensions as the renderer gets them: every member, its default, and invalid
// values.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "io/gltf/materials/material.h"
#include "unit/gltf_material_fixture.h"

namespace emberline {
namespace {

using Material = MaterialDescription;

struct NumberMember {
  const char* extension;
  const char* name;
  float Material::*field;
  float value;  // not the default
};
constexpr NumberMember kNumbers[] = {
    {"KHR_materials_anisotropy", "anisotropyStrength", &Material::anisotropy, 0.25f},
    {"KHR_materials_anisotropy", "anisotropyRotation", &Material::anisotropy_rotation, -7.5f},
    {"KHR_materials_clearcoat", "clearcoatFactor", &Material::clearcoat, 0.25f},
    {"KHR_materials_clearcoat", "clearcoatRoughnessFactor", &Material::clearcoat_roughness, 0.25f},
    {"KHR_materials_diffuse_transmission", "diffuseTransmissionFactor",
     &Material::diffuse_transmission, 0.25f},
    {"KHR_materials_dispersion", "dispersion", &Material::dispersion, 2.5f},
    {"KHR_materials_ior", "ior", &Material::ior, 2.5f},
    {"KHR_materials_ior", "ior", &Material::ior, 0.0f},
    {"KHR_materials_iridescence", "iridescenceFactor", &Material::iridescence, 0.25f},
    {"KHR_materials_iridescence", "iridescenceIor", &Material::iridescence_ior, 1.0f},
    {"KHR_materials_iridescence", "iridescenceThicknessMinimum",
     &Material::iridescence_thickness_minimum, 850.5f},
    {"KHR_materials_iridescence", "iridescenceThicknessMaximum",
     &Material::iridescence_thickness_maximum, 0.0f},
    {"KHR_materials_sheen", "sheenRoughnessFactor", &Material::sheen_roughness, 0.25f},
    {"KHR_materials_specular", "specularFactor", &Material::specular, 0.25f},
    {"KHR_materials_transmission", "transmissionFactor", &Material::transmission, 0.25f},
};

struct ColorMember {
  const char* extension;
  const char* name;
  Rgb Material::*field;
};
constexpr ColorMember kColors[] = {
    {"KHR_materials_diffuse_transmission", "diffuseTransmissionColorFactor",
     &Material::diffuse_transmission_color},
    {"KHR_materials_sheen", "sheenColorFactor", &Material::sheen_color},
    {"KHR_materials_specular", "specularColorFactor", &Material::specular_color},
};

struct TextureMember {
  const char* extension;
  const char* name;
  TextureRef Material::*field;
};
constexpr TextureMember kTextures[] = {
    {"KHR_materials_anisotropy", "anisotropyTexture", &Material::anisotropy_texture},
    {"KHR_materials_clearcoat", "clearcoatTexture", &Material::clearcoat_texture},
    {"KHR_materials_clearcoat", "clearcoatRoughnessTexture",
     &Material::clearcoat_roughness_texture},
    {"KHR_materials_clearcoat", "clearcoatNormalTexture", &Material::clearcoat_normal_texture},
    {"KHR_materials_diffuse_transmission", "diffuseTransmissionTexture",
     &Material::diffuse_transmission_texture},
    {"KHR_materials_diffuse_transmission", "diffuseTransmissionColorTexture",
     &Material::diffuse_transmission_color_texture},
    {"KHR_materials_iridescence", "iridescenceTexture", &Material::iridescence_texture},
    {"KHR_materials_iridescence", "iridescenceThicknessTexture",
     &Material::iridescence_thickness_texture},
    {"KHR_materials_pbrSpecularGlossiness", "diffuseTexture", &Material::base_color_texture},
    {"KHR_materials_pbrSpecularGlossiness", "specularGlossinessTexture",
     &Material::specular_color_texture},
    {"KHR_materials_sheen", "sheenColorTexture", &Material::sheen_color_texture},
    {"KHR_materials_sheen", "sheenRoughnessTexture", &Material::sheen_roughness_texture},
    {"KHR_materials_specular", "specularTexture", &Material::specular_texture},
    {"KHR_materials_specular", "specularColorTexture", &Material::specular_color_texture},
    {"KHR_materials_transmission", "transmissionTexture", &Material::transmission_texture},
};

size_t lines(const std::string& text) { return size_t(std::ranges::count(text, '\n')); }

class GltfMaterialLayers : public test::GltfMaterialTest {
 protected:
  // Loads the material and captures the messages on stderr.
  SceneDescription load_loudly(const json& value, bool lenient = true) {
    testing::internal::CaptureStderr();
    SceneDescription scene = load(value, lenient);
    said_ = testing::internal::GetCapturedStderr();
    return scene;
  }
  // Returns the error message for a file that requires the extension.
  std::string message_if_required(const char* extension, const json& value) {
    gltf_.root["extensionsRequired"] = {extension};
    const std::string message = message_of(value);
    gltf_.root.erase("extensionsRequired");
    return message;
  }
  std::string said_;
};

TEST_F(GltfMaterialLayers, DefaultsAreTheExtensions) {
  const Material none;
  for (const NumberMember& member : kNumbers) {
    const Material m = material(with(member.extension, json::object()));
    EXPECT_EQ(m.*member.field, none.*member.field) << member.name;
  }
  for (const ColorMember& member : kColors) {
    const Material m = material(with(member.extension, json::object()));
    EXPECT_EQ(m.*member.field, none.*member.field) << member.name;
  }
  EXPECT_EQ(none.iridescence_ior, 1.3f);
  EXPECT_EQ(none.iridescence_thickness_minimum, 100.0f);
  EXPECT_EQ(none.iridescence_thickness_maximum, 400.0f);
  EXPECT_EQ(none.clearcoat_normal_scale, 1.0f);
  for (const TextureRef* slot : texture_slots(none)) EXPECT_EQ(slot->image, -1);
}

TEST_F(GltfMaterialLayers, NumbersAndColoursAreRead) {
  for (const NumberMember& member : kNumbers) {
    const Material m = material(with(member.extension, {{member.name, member.value}}));
    EXPECT_EQ(m.*member.field, member.value) << member.name;
  }
  for (const ColorMember& member : kColors) {
    const Material m = material(with(member.extension, {{member.name, {0.5, 0.25, 1}}}));
    EXPECT_EQ(m.*member.field, Rgb(0.5f, 0.25f, 1.0f)) << member.name;
  }
}

// Each texture has its own UV set, transform and sampler, and appears only in its own slot.
TEST_F(GltfMaterialLayers, TexturesAreRead) {
  gltf_.push("samplers", {{"wrapS", 33071}, {"magFilter", 9728}});
  test::add_texture(gltf_, {1, 2, 3});  // unused, so not decoded
  test::add_texture(gltf_, test::small_png());
  gltf_.root["textures"][1]["sampler"] = 0;
  const json slot = {
      {"index", 1},
      {"texCoord", 1},
      {"extensions", {{"KHR_texture_transform", {{"offset", {0.25, 0.5}}, {"texCoord", 2}}}}}};
  for (const TextureMember& member : kTextures) {
    const SceneDescription scene = load(with(member.extension, {{member.name, slot}}));
    const Material& m = scene.materials[0];
    const TextureRef& ref = m.*member.field;
    EXPECT_EQ(ref.image, 0) << member.name;
    EXPECT_EQ(ref.uv_set, 2) << member.name;
    EXPECT_EQ(ref.wrap_s, WrapMode::kClampToEdge) << member.name;
    EXPECT_TRUE(ref.nearest) << member.name;
    EXPECT_EQ(ref.uv_transform, (std::array<float, 6>{1, 0, 0.25f, 0, 1, 0.5f})) << member.name;
    EXPECT_EQ(scene.images.size(), 1u) << member.name;
    EXPECT_EQ(scene.meshes[0].uv_sets.at(2).size(), 3u) << member.name;
    const auto used =
        std::ranges::count_if(texture_slots(m), [](const TextureRef* s) { return s->image >= 0; });
    EXPECT_EQ(used, std::string(member.name) == "specularGlossinessTexture" ? 2 : 1) << member.name;
  }
}

TEST_F(GltfMaterialLayers, AClearCoatsNormalMapHasAScale) {
  test::add_texture(gltf_, test::small_png());
  const json slot = {{"index", 0}, {"scale", 0.25}};
  const Material m = material(with("KHR_materials_clearcoat", {{"clearcoatNormalTexture", slot}}));
  EXPECT_EQ(m.clearcoat_normal_scale, 0.25f);
  EXPECT_EQ(m.normal_scale, 1.0f);
}

TEST_F(GltfMaterialLayers, FactorsBeyondTheirRangeAreClampedAndWarnedOf) {
  const json colors = with("KHR_materials_sheen", {{"sheenColorFactor", {2, -1, 0.5}}});
  EXPECT_EQ(load_loudly(colors, false).materials[0].sheen_color, Rgb(1.0f, 0.0f, 0.5f));
  EXPECT_NE(said_.find("factors outside [0, 1] are clamped: "
                       "/materials/0/extensions/KHR_materials_sheen/sheenColorFactor is "
                       "[2,-1,0.5]"),
            std::string::npos)
      << said_;
  for (const NumberMember& member : kNumbers) {
    if (member.value != 0.25f) continue;
    const json high = with(member.extension, {{member.name, 1.5}});
    EXPECT_EQ(material(high).*member.field, 1.0f) << member.name;
    EXPECT_EQ(material(with(member.extension, {{member.name, -3}})).*member.field, 0.0f);
  }
  // The colour of a reflection may exceed 1.
  const json bright = with("KHR_materials_specular", {{"specularColorFactor", {20, -1, 0.5}}});
  EXPECT_EQ(material(bright).specular_color, Rgb(20.0f, 0.0f, 0.5f));
}

TEST_F(GltfMaterialLayers, ANumberThatCannotBeIsAnErrorOrTheDefault) {
  struct Bad {
    const char* extension;
    const char* name;
    json value;
    float Material::*field;
    const char* expected;
  };
  const Bad bads[] = {
      {"KHR_materials_ior", "ior", -1.5, &Material::ior, "at least 1, or 0"},
      {"KHR_materials_ior", "ior", 0.5, &Material::ior, "at least 1, or 0"},
      {"KHR_materials_ior", "ior", 1e39, &Material::ior, "at least 1, or 0"},
      {"KHR_materials_iridescence", "iridescenceIor", 0.99, &Material::iridescence_ior,
       "index of refraction of at least 1"},
      {"KHR_materials_iridescence", "iridescenceIor", 0, &Material::iridescence_ior, "at least 1"},
      {"KHR_materials_iridescence", "iridescenceThicknessMinimum", -1,
       &Material::iridescence_thickness_minimum, "nanometres of at least 0"},
      {"KHR_materials_iridescence", "iridescenceThicknessMaximum", -1e-3,
       &Material::iridescence_thickness_maximum, "nanometres of at least 0"},
      {"KHR_materials_dispersion", "dispersion", -0.1, &Material::dispersion, "at least 0"},
      {"KHR_materials_anisotropy", "anisotropyRotation", 1e39, &Material::anisotropy_rotation,
       "finite"},
  };
  for (const Bad& bad : bads) {
    const json value = with(bad.extension, {{bad.name, bad.value}});
    const std::string message = message_if_required(bad.extension, value);
    const std::string place =
        std::string("a.glb#/materials/0/extensions/") + bad.extension + "/" + bad.name + ": ";
    EXPECT_NE(message.find(place), std::string::npos) << message;
    EXPECT_NE(message.find(bad.expected), std::string::npos) << message;
    EXPECT_NE(message.find("found " + bad.value.dump()), std::string::npos) << message;
    EXPECT_EQ(lines(message), 0u) << message;

    for (const bool lenient : {false, true}) {
      EXPECT_EQ(load_loudly(value, lenient).materials[0].*bad.field, Material().*bad.field)
          << bad.name;
      EXPECT_NE(said_.find(place), std::string::npos) << said_;
      EXPECT_NE(said_.find(lenient ? "the default" : "it is left out"), std::string::npos) << said_;
      EXPECT_EQ(lines(said_), 1u) << said_;
    }
  }
  // An invalid member of an optional extension is ignored.
  EXPECT_EQ(load_loudly(with("KHR_materials_ior", {{"ior", "glass"}})).materials[0].ior, 1.5f);
  EXPECT_NE(said_.find("KHR_materials_ior/ior: expected a number"), std::string::npos) << said_;
}

TEST_F(GltfMaterialLayers, MissingTextureIsRefusedOrReplaced) {
  test::add_texture(gltf_, test::small_png());
  const auto expect_refused = [&](const json& value, const std::string& pointer,
                                  const char* extension = "KHR_texture_transform") {
    const std::string message = message_if_required(extension, value);
    EXPECT_NE(message.find("#/materials/0" + pointer +
                           "/index: index 1 is out of range: the file "
                           "has 1 textures"),
              std::string::npos)
        << message;
    const SceneDescription scene = load_loudly(value);
    for (const TextureRef* slot : texture_slots(scene.materials[0])) EXPECT_EQ(slot->image, -1);
    EXPECT_EQ(lines(said_), 1u) << said_;
  };
  for (const TextureMember& member : kTextures) {
    expect_refused(with(member.extension, {{member.name, {{"index", 1}}}}),
                   std::string("/extensions/") + member.extension + "/" + member.name,
                   member.extension);
  }
  expect_refused(base_color_slot({{"index", 1}}), "/pbrMetallicRoughness/baseColorTexture");
  expect_refused({{"normalTexture", {{"index", 1}}}}, "/normalTexture");
}

TEST_F(GltfMaterialLayers, AnInteriorIsReadWithoutClearTransmissionToo) {
  const json volume = {
      {"thicknessFactor", 2}, {"attenuationColor", {0.5, 0.25, 1}}, {"attenuationDistance", 0.125}};
  const Material m =
      material({{"extensions",
                 {{"KHR_materials_diffuse_transmission", {{"diffuseTransmissionFactor", 1}}},
                  {"KHR_materials_volume", volume}}}});
  EXPECT_FALSE(m.thin_walled);
  EXPECT_EQ(m.attenuation_color, Rgb(0.5f, 0.25f, 1.0f));
  EXPECT_EQ(m.attenuation_distance, 0.125f);
}

TEST_F(GltfMaterialLayers, ADistanceThatCannotBeIsAnErrorOrInfinite) {
  for (const double distance : {0.0, -1.0, 1e39}) {
    const json volume = {{"thicknessFactor", 1}, {"attenuationDistance", distance}};
    const json value = with("KHR_materials_volume", volume);
    const std::string message = message_if_required("KHR_materials_volume", value);
    EXPECT_NE(message.find("KHR_materials_volume/attenuationDistance: expected a number greater "
                           "than 0"),
              std::string::npos)
        << message;
    for (const bool lenient : {false, true}) {
      EXPECT_EQ(load_loudly(value, lenient).materials[0].attenuation_distance,
                std::numeric_limits<float>::infinity());
      EXPECT_EQ(lines(said_), 1u) << said_;
    }
  }
  const json thin = with("KHR_materials_volume", {{"thicknessFactor", -1}});
  EXPECT_NE(
      message_if_required("KHR_materials_volume", thin).find("KHR_materials_volume/thickness"),
      std::string::npos);
  EXPECT_TRUE(load_loudly(thin).materials[0].thin_walled);
}

// A broken texture is white, but a texture of directions points straight up, or along the tangent.
TEST_F(GltfMaterialLayers, BrokenAnisotropyTextureHasNoDirection) {
  test::add_texture(gltf_, {'n', 'o', 't', ' ', 'a', 'n', ' ', 'i', 'm', 'a', 'g', 'e'});
  const SceneDescription scene =
      load({{"extensions",
             {{"KHR_materials_clearcoat",
               {{"clearcoatTexture", {{"index", 0}}}, {"clearcoatNormalTexture", {{"index", 0}}}}},
              {"KHR_materials_anisotropy", {{"anisotropyTexture", {{"index", 0}}}}}}}},
           true);
  const Material& m = scene.materials[0];
  const auto texel = [&](const TextureRef& slot) {
    const auto& texels = scene.images.at(size_t(slot.image))->texels;
    return std::array{int(texels.at(0)), int(texels.at(1)), int(texels.at(2))};
  };
  EXPECT_EQ(texel(m.clearcoat_texture), (std::array{255, 255, 255}));
  EXPECT_EQ(texel(m.clearcoat_normal_texture), (std::array{128, 128, 255}));
  EXPECT_EQ(texel(m.anisotropy_texture), (std::array{255, 128, 255}));
}

TEST_F(GltfMaterialLayers, SpecularGlossinessIsADielectricThatReflectsItsColour) {
  gltf_.root["extensionsUsed"] = {"KHR_materials_pbrSpecularGlossiness"};
  test::add_texture(gltf_, test::small_png());
  const json values = {{"diffuseFactor", {0.5, 0.25, 0.125, 0.75}},
                       {"specularFactor", {0.25, 0.5, 1}},
                       {"glossinessFactor", 0.25}};
  const SceneDescription scene = load(with("KHR_materials_pbrSpecularGlossiness", values));
  const Material& m = scene.materials[0];
  EXPECT_EQ(m.ior, 0.0f);
  EXPECT_EQ(m.metallic, 0.0f);
  EXPECT_EQ(m.specular, 1.0f);
  EXPECT_EQ(m.base_color, Rgb(0.5f, 0.25f, 0.125f));
  EXPECT_EQ(m.alpha, 0.75f);
  EXPECT_EQ(m.specular_color, Rgb(0.25f, 0.5f, 1.0f));
  EXPECT_EQ(m.roughness, 0.75f);
  EXPECT_EQ(m.glossiness_texture.image, -1);
  EXPECT_EQ(scene.coverage.used, std::vector<std::string>{"KHR_materials_pbrSpecularGlossiness"});
  EXPECT_TRUE(scene.coverage.approximated.empty() && scene.coverage.ignored.empty());

  const Material defaults = material(with("KHR_materials_pbrSpecularGlossiness", json::object()));
  EXPECT_EQ(defaults.base_color, Rgb(1.0f));
  EXPECT_EQ(defaults.specular_color, Rgb(1.0f));
  EXPECT_EQ(defaults.roughness, 0.0f);

  const json slot = {{"index", 0}, {"texCoord", 1}};
  const Material textured =
      material(with("KHR_materials_pbrSpecularGlossiness", {{"specularGlossinessTexture", slot}}));
  EXPECT_EQ(textured.specular_color_texture.image, 0);
  EXPECT_EQ(textured.glossiness_texture.image, 0);
  EXPECT_EQ(textured.glossiness_texture.uv_set, 1);
}

// The extension says: "any client implementation that supports the extension should always render
// the asset using the specular-glossiness material properties".
TEST_F(GltfMaterialLayers, SpecularGlossinessReplacesMetallicRoughness) {
  test::add_texture(gltf_, test::small_png());
  json value = with("KHR_materials_pbrSpecularGlossiness",
                    {{"diffuseFactor", {0.5, 0.5, 0.5, 1}}, {"glossinessFactor", 0.5}});
  value["pbrMetallicRoughness"] = {{"baseColorFactor", {1, 0, 0, 1}},
                                   {"metallicFactor", 0.5},
                                   {"baseColorTexture", {{"index", 0}}},
                                   {"metallicRoughnessTexture", {{"index", 0}}}};
  Material m = material(value);
  EXPECT_EQ(m.base_color, Rgb(0.5f));
  EXPECT_EQ(m.metallic, 0.0f);
  EXPECT_EQ(m.roughness, 0.5f);
  EXPECT_EQ(m.base_color_texture.image, -1);
  EXPECT_EQ(m.metallic_roughness_texture.image, -1);
  // Specular-glossiness takes precedence over ior and specular, which must not be combined with it.
  // A clear coat is kept.
  value["extensions"]["KHR_materials_ior"] = {{"ior", 1.4}};
  value["extensions"]["KHR_materials_specular"] = {{"specularFactor", 0.5}};
  value["extensions"]["KHR_materials_clearcoat"] = {{"clearcoatFactor", 0.5}};
  const SceneDescription scene = load(value);
  m = scene.materials[0];
  EXPECT_EQ(m.ior, 0.0f);
  EXPECT_EQ(m.specular, 1.0f);
  EXPECT_EQ(m.clearcoat, 0.5f);
  EXPECT_EQ(scene.coverage.ignored,
            (std::vector<std::string>{
                "KHR_materials_ior together with KHR_materials_pbrSpecularGlossiness",
                "KHR_materials_specular together with KHR_materials_pbrSpecularGlossiness"}));
}

TEST_F(GltfMaterialLayers, AnUnlitMaterialHasNone) {
  test::add_texture(gltf_, test::small_png());
  json value = with("KHR_materials_unlit", json::object());
  value["extensions"]["KHR_materials_sheen"] = {{"sheenColorFactor", {1, 1, 1}},
                                                {"sheenColorTexture", {{"index", 0}}}};
  value["extensions"]["KHR_materials_pbrSpecularGlossiness"] = {{"diffuseFactor", {0, 1, 0, 1}}};
  SceneDescription scene = load(value);
  EXPECT_TRUE(scene.materials[0].unlit);
  EXPECT_EQ(scene.materials[0].sheen_color, Rgb(0.0f));
  EXPECT_EQ(scene.materials[0].base_color, Rgb(0.0f, 1.0f, 0.0f));
  EXPECT_TRUE(scene.images.empty());
  EXPECT_EQ(scene.coverage.ignored,
            std::vector<std::string>{"KHR_materials_sheen of unlit materials"});
  value["pbrMetallicRoughness"] = {{"baseColorFactor", {0, 0, 1, 1}}};
  EXPECT_EQ(material(value).base_color, Rgb(0.0f, 0.0f, 1.0f));
}

}  // namespace
}  // namespace emberline
