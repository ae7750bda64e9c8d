// Tests KHR_materials_variants: the materials of meshes in each variant, and the data read for
// them.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "io/gltf/gltf_file.h"
#include "renderer/core/errors.h"
#include "renderer/description/scene_edits.h"
#include "support/embedded_images.h"

namespace emberline::test {
namespace {

using json = nlohmann::json;

// The first triangle has material 0, but material 1 in "red" and "late". The second triangle is the
// same in all variants. Material 2 is unused.
GltfBuilder varied() {
  GltfBuilder gltf;
  gltf.add_triangle();
  gltf.add_triangle();
  for (const char* name : {"own", "other", "spare"}) gltf.push("materials", {{"name", name}});
  gltf.root["extensionsUsed"] = {"KHR_materials_variants"};
  gltf.root["extensions"]["KHR_materials_variants"]["variants"] = {
      {{"name", "red"}}, {{"name", "blue"}}, {{"name", "late"}}};
  gltf.primitive()["material"] = 0;
  gltf.primitive()["extensions"]["KHR_materials_variants"]["mappings"] = {
      {{"material", 1}, {"variants", {2, 0}}}, {{"material", 0}, {"variants", {1}}}};
  return gltf;
}

json& mappings(GltfBuilder& gltf) {
  return gltf.primitive()["extensions"]["KHR_materials_variants"]["mappings"];
}

SceneDescription load_varied(const GltfBuilder& gltf, bool variants = true) {
  const TempFolder folder;
  return load_gltf(gltf.write_glb(folder / "a.glb"), {.variants = variants});
}

std::string rejection_message(const GltfBuilder& gltf) {
  try {
    load_varied(gltf);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(GltfVariants, AreReadPerMesh) {
  const SceneDescription scene = load_varied(varied());
  EXPECT_EQ(scene.coverage.used, std::vector<std::string>{"KHR_materials_variants"});
  ASSERT_EQ(scene.variants.size(), 3u);
  EXPECT_EQ(scene.variants[2].name, "late");
  EXPECT_EQ(scene.meshes[0].material, 0);
  EXPECT_EQ(scene.meshes[0].variant_materials,
            (std::vector<VariantMaterial>{{0, 1}, {1, 0}, {2, 1}}));
  EXPECT_EQ(scene.meshes[1].material, -1);
  EXPECT_TRUE(scene.meshes[1].variant_materials.empty());
}

TEST(GltfVariants, OnlyNamesAreReadIfNoneIsChosen) {
  GltfBuilder gltf = varied();
  add_texture(gltf, {'n', 'o', 'n', 'e'});
  gltf.root["materials"][1]["emissiveTexture"]["index"] = 0;
  SceneDescription scene = load_varied(gltf, false);  // the image is not decoded
  EXPECT_EQ(scene.variants.size(), 3u);
  EXPECT_TRUE(scene.meshes[0].variant_materials.empty());
  EXPECT_TRUE(scene.images.empty());
  SceneEdits edits;
  edits.variant = EditTarget{"red", 0, ""};
  EXPECT_THROW(apply(edits, scene), InputError);
  EXPECT_NE(rejection_message(gltf).find("/images/0"), std::string::npos);
}

// Loads the images, texture coordinates and tangents of every material that the mesh may have.
TEST(GltfVariants, LoadsDataThatAnyVariantNeeds) {
  GltfBuilder gltf = varied();
  const int uv = gltf.add_accessor<float>("VEC2", {0, 0, 1, 0, 0, 1});
  const int normals = gltf.add_accessor<float>("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1});
  for (const char* set : {"TEXCOORD_0", "TEXCOORD_1", "TEXCOORD_2"}) {
    gltf.primitive()["attributes"][set] = uv;
  }
  gltf.primitive()["attributes"]["NORMAL"] = normals;
  for (int i = 0; i < 3; ++i) add_texture(gltf, small_png());
  gltf.root["materials"][1]["normalTexture"] = {{"index", 1}, {"texCoord", 2}};
  gltf.root["materials"][2]["emissiveTexture"]["index"] = 2;
  const SceneDescription scene = load_varied(gltf);
  EXPECT_EQ(scene.images.size(), 1u);
  EXPECT_EQ(scene.materials[1].normal_texture.image, 0);
  const MeshDescription& mesh = scene.meshes[0];
  ASSERT_EQ(mesh.uv_sets.size(), 3u);
  EXPECT_FALSE(mesh.uv_sets[2].empty());
  EXPECT_TRUE(mesh.uv_sets[1].empty());
  EXPECT_EQ(mesh.tangents.size(), 3u);
  EXPECT_TRUE(load_varied(gltf, false).meshes[0].tangents.empty());
}

// A mesh has only one set of tangents, so a normal map with other coordinates is approximated.
TEST(GltfVariants, NormalMapsWithOtherCoordinatesAreNamed) {
  GltfBuilder gltf = varied();
  gltf.primitive()["attributes"]["TEXCOORD_0"] =
      gltf.add_accessor<float>("VEC2", {0, 0, 1, 0, 0, 1});
  add_texture(gltf, small_png());
  for (int m : {0, 1}) gltf.root["materials"][size_t(m)]["normalTexture"]["index"] = 0;
  EXPECT_TRUE(load_varied(gltf).coverage.approximated.empty());
  gltf.root["materials"][1]["normalTexture"]["extensions"]["KHR_texture_transform"]["rotation"] = 1;
  const std::vector<std::string> named = load_varied(gltf).coverage.approximated;
  ASSERT_EQ(named.size(), 1u);
  EXPECT_NE(named[0].find("normal maps of variants on mesh 0/0"), std::string::npos) << named[0];
}

// If the extension is required, these faults are errors. If it is optional, they are warnings
// (failure/needless_faults_test).
TEST(GltfVariants, FaultsAreNamedWithTheirPlace) {
  const auto expect = [](GltfBuilder gltf, const std::string& place, const std::string& words) {
    gltf.root["extensionsRequired"] = {"KHR_materials_variants"};
    const std::string message = rejection_message(gltf);
    EXPECT_NE(message.find("a.glb#" + place + ": "), std::string::npos) << message;
    EXPECT_NE(message.find(words), std::string::npos) << message;
  };
  const std::string at = "/meshes/0/primitives/0/extensions/KHR_materials_variants/mappings";
  GltfBuilder gltf = varied();
  mappings(gltf)[0]["material"] = 3;
  expect(gltf, at + "/0/material", "the file has 3 materials");
  gltf = varied();
  mappings(gltf)[1]["variants"] = {3};
  expect(gltf, at + "/1/variants/0", "the file has 3 variants");
  gltf = varied();
  mappings(gltf)[1]["variants"] = {1, 2};
  expect(gltf, at, "variant 2 has two materials");
  gltf = varied();
  mappings(gltf)[1].erase("material");
  expect(gltf, at + "/1", "\"material\" is missing");
  gltf = varied();
  gltf.root.erase("extensions");
  expect(gltf, at + "/0/variants/0", "the file has 0 variants");
}

}  // namespace
}  // namespace emberline::test
