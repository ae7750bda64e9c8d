// Tests materials, texture slots, samplers and images as the renderer gets them.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "io/gltf/gltf_file.h"
#include "support/encoded_images.h"
#include "support/ktx2_files.h"
#include "unit/gltf_material_fixture.h"

namespace emberline {
namespace {

class GltfMaterial : public test::GltfMaterialTest {};

TEST_F(GltfMaterial, DefaultsAreGltfs) {
  const MaterialDescription m = material(json::object());
  EXPECT_EQ(m.base_color, Rgb(1.0f));
  EXPECT_EQ(m.alpha, 1.0f);
  EXPECT_EQ(m.metallic, 1.0f);
  EXPECT_EQ(m.roughness, 1.0f);
  EXPECT_EQ(m.emission, Rgb(0.0f));
  EXPECT_EQ(m.alpha_mode, AlphaMode::kOpaque);
  EXPECT_EQ(m.alpha_cutoff, 0.5f);
  EXPECT_FALSE(m.double_sided);
  EXPECT_FALSE(m.unlit);
  EXPECT_EQ(m.base_color_texture.image, -1);
}

TEST_F(GltfMaterial, FactorsAndModes) {
  const MaterialDescription m =
      material({{"name", "paint"},
                {"pbrMetallicRoughness",
                 {{"baseColorFactor", {0.1, 0.2, 0.3, 0.4}},
                  {"metallicFactor", 0.5},
                  {"roughnessFactor", 0}}},
                {"emissiveFactor", {1, 0.5, 0.25}},
                {"alphaMode", "MASK"},
                {"alphaCutoff", 0.75},
                {"doubleSided", true},
                {"extensions",
                 {{"KHR_materials_emissive_strength", {{"emissiveStrength", 8}}},
                  {"KHR_materials_unlit", json::object()}}}});
  EXPECT_EQ(m.name, "paint");
  EXPECT_EQ(m.base_color, Rgb(0.1f, 0.2f, 0.3f));
  EXPECT_EQ(m.alpha, 0.4f);
  EXPECT_EQ(m.metallic, 0.5f);
  EXPECT_EQ(m.roughness, 0.0f);
  EXPECT_EQ(m.emission, Rgb(8, 4, 2));
  EXPECT_EQ(m.alpha_mode, AlphaMode::kMask);
  EXPECT_EQ(m.alpha_cutoff, 0.75f);
  EXPECT_TRUE(m.double_sided);
  EXPECT_TRUE(m.unlit);
  EXPECT_EQ(material({{"alphaMode", "BLEND"}}).alpha_mode, AlphaMode::kBlend);
  EXPECT_NE(message_of({{"alphaMode", "GLASS"}}).find("#/materials/0/alphaMode: "),
            std::string::npos);
}

TEST_F(GltfMaterial, FactorsOutOfRangeAreClamped) {
  const MaterialDescription m = material(
      {{"pbrMetallicRoughness",
        {{"baseColorFactor", {2, -1, 0.5, 3}}, {"metallicFactor", 1.5}, {"roughnessFactor", -1}}},
       {"emissiveFactor", {-1, 3, 0}}});
  EXPECT_EQ(m.base_color, Rgb(1, 0, 0.5f));
  EXPECT_EQ(m.alpha, 1.0f);
  EXPECT_EQ(m.metallic, 1.0f);
  EXPECT_EQ(m.roughness, 0.0f);
  EXPECT_EQ(m.emission, Rgb(0, 3, 0));
}

// There is one warning of each kind, which names at most eight members.
TEST_F(GltfMaterial, ClampedFactorsAreNamed) {
  const auto warnings_of = [&](const json& value) {
    testing::internal::CaptureStderr();
    material(value);
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(warnings_of({{"name", "Gold"}, {"pbrMetallicRoughness", {{"metallicFactor", 1}}}}), "");
  const std::string warnings = warnings_of(
      {{"name", "Gold"},
       {"pbrMetallicRoughness",
        {{"baseColorFactor", {0, 1, 1, 1.5}}, {"metallicFactor", 2}, {"roughnessFactor", -1}}},
       {"emissiveFactor", {-1, 3, 0}}});
  const std::string in = "/materials/0/pbrMetallicRoughness/";
  EXPECT_NE(
      warnings.find("factors outside [0, 1] are clamped: " + in +
                    "baseColorFactor of 'Gold' is [0,1,1,1.5], " + in +
                    "metallicFactor of 'Gold' is 2, " + in + "roughnessFactor of 'Gold' is -1\n"),
      std::string::npos)
      << warnings;
  EXPECT_NE(
      warnings.find("negative material colours are replaced by 0: /materials/0/emissiveFactor of "
                    "'Gold' is [-1,3,0]\n"),
      std::string::npos)
      << warnings;
  EXPECT_EQ(std::ranges::count(warnings, '\n'), 2) << warnings;
}

TEST_F(GltfMaterial, SamplersAndUvSets) {
  gltf_.push("samplers", {{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}});
  test::add_texture(gltf_, test::small_png());
  gltf_.root["textures"][0]["sampler"] = 0;
  const SceneDescription scene = load(base_color_slot({{"index", 0}, {"texCoord", 2}}));
  const TextureRef& ref = scene.materials[0].base_color_texture;
  EXPECT_EQ(ref.image, 0);
  EXPECT_EQ(ref.uv_set, 2);
  EXPECT_EQ(ref.wrap_s, WrapMode::kClampToEdge);
  EXPECT_EQ(ref.wrap_t, WrapMode::kMirroredRepeat);
  EXPECT_TRUE(ref.nearest);
  // Set 0 is always read. Set 2 is read because it is used, and set 1 is not read.
  ASSERT_EQ(scene.meshes[0].uv_sets.size(), 3u);
  EXPECT_EQ(scene.meshes[0].uv_sets[0].size(), 3u);
  EXPECT_EQ(scene.meshes[0].uv_sets[1].size(), 0u);
  EXPECT_EQ(scene.meshes[0].uv_sets[2][1], Vec2f(8, 1));
  gltf_.root["samplers"][0]["wrapS"] = 7;
  EXPECT_NE(message_of(base_color_slot({{"index", 0}})).find("#/samplers/0/wrapS"),
            std::string::npos);
}

TEST_F(GltfMaterial, AMissingUvSetIsFilledAndReported) {
  test::add_texture(gltf_, test::small_png());
  const SceneDescription scene = load(base_color_slot({{"index", 0}, {"texCoord", 3}}));
  EXPECT_EQ(scene.meshes[0].uv_sets.at(3), std::vector<Vec2f>(3, Vec2f(0.0f)));
  ASSERT_EQ(scene.coverage.ignored.size(), 1u);
  EXPECT_NE(scene.coverage.ignored[0].find("TEXCOORD_3"), std::string::npos);
}

// The extension's README defines uv' = translation * rotation * scale * uv. It gives the rotation
// mat3(cos, sin, 0, -sin, cos, 0, 0, 0, 1) in transposed (row) form.
TEST_F(GltfMaterial, TextureTransform) {
  test::add_texture(gltf_, test::small_png());
  const double angle = 0.5;
  const TextureRef ref = material(base_color_slot({{"index", 0},
                                                   {"extensions",
                                                    {{"KHR_texture_transform",
                                                      {{"offset", {0.25, 0.5}},
                                                       {"rotation", angle},
                                                       {"scale", {2, 3}},
                                                       {"texCoord", 1}}}}}}))
                             .base_color_texture;
  EXPECT_EQ(ref.uv_set, 1);
  const double u = 0.3, v = 0.7, c = std::cos(angle), s = std::sin(angle);
  const double x = 2 * u, y = 3 * v;  // scaled; rotated and moved below
  const auto& m = ref.uv_transform;
  EXPECT_NEAR(m[0] * u + m[1] * v + m[2], c * x + s * y + 0.25, 1e-6);
  EXPECT_NEAR(m[3] * u + m[4] * v + m[5], -s * x + c * y + 0.5, 1e-6);
}

TEST_F(GltfMaterial, ImagesKeepTheirDepthAndAreSharedBetweenSlots) {
  OIIO::ImageSpec deep(1, 1, 4, OIIO::TypeDesc::UINT16);
  deep.attribute("oiio:UnassociatedAlpha", 1);
  const auto png16 = test::encode_image<uint16_t>("png", deep, {1000, 2000, 3000, 32768});
  test::add_texture(gltf_, test::small_png());
  test::add_texture(gltf_, png16);
  const SceneDescription scene =
      load({{"pbrMetallicRoughness",
             {{"baseColorTexture", {{"index", 1}}}, {"metallicRoughnessTexture", {{"index", 0}}}}},
            {"emissiveTexture", {{"index", 1}}}});
  ASSERT_EQ(scene.images.size(), 2u);
  const MaterialDescription& m = scene.materials[0];
  EXPECT_EQ(m.base_color_texture.image, m.emission_texture.image);
  const Image& image = *scene.images[size_t(m.base_color_texture.image)];
  EXPECT_EQ(image.type, TexelType::kUint16);
  EXPECT_EQ(image.channels, 4);
  uint16_t texel[4];
  std::memcpy(texel, image.texels.data(), sizeof(texel));
  EXPECT_EQ(texel[0], 1000);  // not multiplied by alpha
  EXPECT_EQ(texel[3], 32768);
}

// The image index and the UV set of this slot are read as for any other slot.
TEST_F(GltfMaterial, TransmissionTextures) {
  test::add_texture(gltf_, {1, 2, 3});
  test::add_texture(gltf_, test::small_png());
  const SceneDescription scene =
      load({{"extensions",
             {{"KHR_materials_transmission",
               {{"transmissionFactor", 0.5},
                {"transmissionTexture", {{"index", 1}, {"texCoord", 1}}}}}}}});
  EXPECT_EQ(scene.materials[0].transmission, 0.5f);
  EXPECT_EQ(scene.materials[0].transmission_texture.image, 0);
  EXPECT_EQ(scene.images.size(), 1u);
  EXPECT_EQ(scene.meshes[0].uv_sets.at(1).size(), 3u);
}

TEST_F(GltfMaterial, OnlyUsedImagesAreDecoded) {
  test::add_texture(gltf_, {1, 2, 3, 4});
  gltf_.root["materials"] = json::array({json::object(), base_color_slot({{"index", 0}})});
  gltf_.primitive()["material"] = 0;
  const SceneDescription scene = load_gltf(gltf_.write_glb(folder_ / "a.glb"), {});
  EXPECT_TRUE(scene.images.empty());
}

TEST_F(GltfMaterial, WebpTextures) {
  OIIO::ImageSpec spec(4, 4, 3, OIIO::TypeDesc::UINT8);
  const auto webp = test::encode_image<uint8_t>("webp", spec, std::vector<uint8_t>(4 * 4 * 3, 200));
  const int png = gltf_.push("images", {{"bufferView", gltf_.add_view(test::small_png())}});
  const int lossy = gltf_.push("images", {{"bufferView", gltf_.add_view(webp)}});
  gltf_.push("textures",
             {{"source", png}, {"extensions", {{"EXT_texture_webp", {{"source", lossy}}}}}});
  gltf_.root["extensionsRequired"] = {"EXT_texture_webp"};
  const SceneDescription scene = load(base_color_slot({{"index", 0}}));
  ASSERT_EQ(scene.images.size(), 1u);
  EXPECT_EQ(scene.images[0]->width, 4);
  EXPECT_NEAR(int(scene.images[0]->texels[0]), 200, 3);
}

TEST_F(GltfMaterial, BasisuTextures) {
  const int png = gltf_.push("images", {{"bufferView", gltf_.add_view(test::small_png())}});
  const int ktx2 = gltf_.push(
      "images",
      {{"bufferView", gltf_.add_view(test::ktx2_file("etc1s_odd"))}, {"mimeType", "image/ktx2"}});
  gltf_.push("textures",
             {{"source", png}, {"extensions", {{"KHR_texture_basisu", {{"source", ktx2}}}}}});
  gltf_.root["extensionsUsed"] = {"KHR_texture_basisu"};
  const SceneDescription scene = load(base_color_slot({{"index", 0}}));
  ASSERT_EQ(scene.images.size(), 1u);
  EXPECT_EQ(scene.images[0]->width, 65);
  EXPECT_EQ(scene.images[0]->height, 37);
  EXPECT_EQ(scene.coverage.used, std::vector<std::string>{"KHR_texture_basisu"});

  gltf_.root["extensionsRequired"] = {"KHR_texture_basisu"};
  gltf_.root["textures"][0].erase("source");
  EXPECT_EQ(load(base_color_slot({{"index", 0}})).images.at(0)->width, 65);
}

// The loader falls back to the texture's other image, if there is one and the extension is
// optional.
TEST_F(GltfMaterial, ABasisuTextureThatDoesNotDecodeFallsBack) {
  std::vector<uint8_t> damaged = test::ktx2_file("etc1s_odd");
  damaged.resize(damaged.size() - 1);
  const int png = gltf_.push("images", {{"bufferView", gltf_.add_view(test::small_png())}});
  const int ktx2 = gltf_.push("images", {{"bufferView", gltf_.add_view(damaged)}});
  gltf_.push("textures",
             {{"source", png}, {"extensions", {{"KHR_texture_basisu", {{"source", ktx2}}}}}});
  gltf_.root["extensionsUsed"] = {"KHR_texture_basisu"};
  const json slot = base_color_slot({{"index", 0}});
  testing::internal::CaptureStderr();
  const SceneDescription scene = load(slot);
  const std::string warnings = testing::internal::GetCapturedStderr();
  ASSERT_EQ(scene.images.size(), 1u);
  EXPECT_EQ(scene.images[0]->width, 2);
  EXPECT_EQ(scene.repairs.replaced_images, 0u);
  EXPECT_NE(warnings.find("a.glb#/images/1: "), std::string::npos) << warnings;
  EXPECT_NE(warnings.find("the texture's other image is used"), std::string::npos) << warnings;

  gltf_.root["extensionsRequired"] = {"KHR_texture_basisu"};
  EXPECT_NE(message_of(slot).find("a.glb#/images/1: cannot decode the image: the KTX 2"),
            std::string::npos)
      << message_of(slot);
  gltf_.root.erase("extensionsRequired");
  gltf_.root["textures"][0].erase("source");
  EXPECT_NE(message_of(slot).find("a.glb#/images/1: "), std::string::npos);
}

TEST_F(GltfMaterial, ATransferFunctionThatTheUseContradictsIsWarnedOf) {
  test::add_texture(gltf_, test::ktx2_file("etc1s_odd"), "image/ktx2");
  testing::internal::CaptureStderr();
  load({{"normalTexture", {{"index", 0}}}});
  const std::string warnings = testing::internal::GetCapturedStderr();
  EXPECT_NE(warnings.find("is marked as sRGB, but is used where linear is expected"),
            std::string::npos)
      << warnings;
  testing::internal::CaptureStderr();
  load(base_color_slot({{"index", 0}}));
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST_F(GltfMaterial, AnImageThatDoesNotDecodeIsNamed) {
  std::vector<uint8_t> broken = test::small_png();
  broken.resize(broken.size() / 2);
  test::add_texture(gltf_, broken);
  gltf_.root["images"][0]["name"] = "bricks";
  const std::string message = message_of(base_color_slot({{"index", 0}}));
  EXPECT_NE(message.find("a.glb#/images/0 (bricks): "), std::string::npos) << message;
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

TEST_F(GltfMaterial, LenientlyItBecomesNeutral) {
  test::add_texture(gltf_, {'n', 'o', 't', ' ', 'a', 'n', ' ', 'i', 'm', 'a', 'g', 'e'});
  gltf_.push("images", {{"uri", "missing.png"}});
  gltf_.push("textures", {{"source", 1}});
  gltf_.push("textures", json::object());
  json value = base_color_slot({{"index", 0}});
  value["normalTexture"] = {{"index", 1}};
  value["emissiveTexture"] = {{"index", 2}};
  EXPECT_NE(message_of(value), "no error");
  const SceneDescription scene = load(value, true);
  EXPECT_EQ(scene.repairs.replaced_images, 2u);
  const MaterialDescription& m = scene.materials[0];
  const Image& color = *scene.images.at(size_t(m.base_color_texture.image));
  EXPECT_EQ(color.texels, (std::vector<std::byte>(3, std::byte(255))));
  const Image& normal = *scene.images.at(size_t(m.normal_texture.image));
  EXPECT_EQ(normal.texels,
            (std::vector<std::byte>{std::byte(128), std::byte(128), std::byte(255)}));
  EXPECT_EQ(m.emission_texture.image, -1);
}

TEST_F(GltfMaterial, GlassIsReadWhole) {
  const MaterialDescription m =
      material({{"extensions",
                 {{"KHR_materials_transmission", {{"transmissionFactor", 0.9}}},
                  {"KHR_materials_ior", {{"ior", 1.33}}},
                  {"KHR_materials_specular",
                   {{"specularFactor", 0.25}, {"specularColorFactor", {0.5, 0.25, 0}}}},
                  {"KHR_materials_volume",
                   {{"thicknessFactor", 1},
                    {"attenuationColor", {0.5, 0.25, 1}},
                    {"attenuationDistance", 0.1}}}}}});
  EXPECT_FLOAT_EQ(m.transmission, 0.9f);
  EXPECT_FLOAT_EQ(m.ior, 1.33f);
  EXPECT_FLOAT_EQ(m.specular, 0.25f);
  EXPECT_EQ(m.specular_color, Rgb(0.5f, 0.25f, 0.0f));
  EXPECT_FALSE(m.thin_walled);
  EXPECT_EQ(m.attenuation_color, Rgb(0.5f, 0.25f, 1.0f));
  EXPECT_FLOAT_EQ(m.attenuation_distance, 0.1f);
}

TEST_F(GltfMaterial, TransmissionWithoutThicknessIsAThinWall) {
  const MaterialDescription m =
      material({{"extensions",
                 {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
                  {"KHR_materials_volume", {{"thicknessFactor", 0}}}}}});
  EXPECT_TRUE(m.thin_walled);
  EXPECT_FLOAT_EQ(m.ior, 1.5f);
}

TEST_F(GltfMaterial, GlassThatCannotBeIsAnError) {
  // If the extensions were optional, these values would be ignored.
  gltf_.root["extensionsRequired"] = {"KHR_materials_ior", "KHR_materials_transmission",
                                      "KHR_materials_volume"};
  EXPECT_NE(message_of(with("KHR_materials_ior", {{"ior", 0.5}})).find("KHR_materials_ior/ior"),
            std::string::npos);
  EXPECT_NE(message_of(with("KHR_materials_ior", {{"ior", "glass"}})).find("KHR_materials_ior"),
            std::string::npos);
  EXPECT_NE(
      message_of(with("KHR_materials_transmission", {{"transmissionTexture", {{"index", 7}}}}))
          .find("transmissionTexture/index"),
      std::string::npos);
  EXPECT_NE(
      message_of(
          {{"extensions",
            {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
             {"KHR_materials_volume", {{"thicknessFactor", 1}, {"attenuationDistance", 0}}}}}})
          .find("attenuationDistance"),
      std::string::npos);
}

}  // namespace
}  // namespace emberline
