#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "renderer/core/errors.h"
#include "support/loaded_gltf.h"

namespace emberline {
namespace {

using test::GltfBuilder;
using test::load;

bool contains(const std::vector<std::string>& list, const std::string& text) {
  return std::find(list.begin(), list.end(), text) != list.end();
}

TEST(GltfCoverage, UsedExtensionsAreSorted) {
  GltfBuilder gltf;
  gltf.add_triangle();
  gltf.root["extensionsUsed"] = {"KHR_materials_unlit",    "KHR_materials_clearcoat",
                                 "KHR_materials_variants", "KHR_materials_specular",
                                 "VENDOR_new_thing",       "KHR_materials_unlit"};
  const CoverageReport coverage = load(gltf).coverage;
  EXPECT_EQ(coverage.used,
            (std::vector<std::string>{"KHR_materials_unlit", "KHR_materials_clearcoat",
                                      "KHR_materials_variants", "KHR_materials_specular"}));
  EXPECT_TRUE(coverage.approximated.empty());
  EXPECT_EQ(coverage.ignored, std::vector<std::string>{"VENDOR_new_thing (unknown extension)"});
}

TEST(GltfCoverage, IgnoredExtensionsHaveAReason) {
  GltfBuilder gltf;
  gltf.add_triangle();
  gltf.root["extensionsUsed"] = {"MSFT_lod", "KHR_xmp_json_ld"};
  const CoverageReport coverage = load(gltf).coverage;
  EXPECT_EQ(coverage.ignored,
            (std::vector<std::string>{"MSFT_lod (the finest level of detail is rendered)",
                                      "KHR_xmp_json_ld (does not affect the picture)"}));
}

TEST(GltfCoverage, SplatsAreNamed) {
  GltfBuilder gltf;
  gltf.add_triangle();
  gltf.root["extensionsUsed"] = {"KHR_gaussian_splatting"};
  EXPECT_EQ(load(gltf).coverage.ignored,
            std::vector<std::string>{"KHR_gaussian_splatting (splats are not drawn)"});
}

// A file of a later minor version may have members that this version does not support.
TEST(GltfCoverage, MembersOfLaterVersionsAreNamed) {
  GltfBuilder gltf;
  gltf.add_triangle();
  gltf.add_mesh_node(0);
  gltf.push("materials", {{"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, 1}}}}});
  for (const char* pointer :
       {"/nodes/0/lod", "/nodes/1/lod", "/nodes/1/extras", "/meshes/0/skinning",
        "/meshes/0/primitives/0/meshlets", "/materials/0/layers",
        "/materials/0/pbrMetallicRoughness/diffuseModel", "/scenes/0/sky"}) {
    gltf.root[nlohmann::json::json_pointer(pointer)] = nlohmann::json::object();
  }
  for (const char* version : {"2.0", "2.1", "2.10"}) {
    gltf.root["asset"]["version"] = version;
    std::vector<std::string> expected;
    for (const char* member :
         {"\"lod\" of nodes", "\"skinning\" of meshes", "\"meshlets\" of meshes/primitives",
          "\"layers\" of materials", "\"diffuseModel\" of materials/pbrMetallicRoughness"}) {
      if (std::string(version) == "2.0") continue;
      expected.push_back(member + std::string(" (the file is glTF ") + version +
                         ", this version reads 2.0)");
    }
    std::vector<std::string> found = load(gltf).coverage.ignored;
    std::ranges::sort(found);
    std::ranges::sort(expected);
    EXPECT_EQ(found, expected) << version;
  }
  // The list of ignored members is limited.
  for (int i = 0; i < 10000; ++i) gltf.root["nodes"][0]["new " + std::to_string(i)] = i;
  EXPECT_LE(load(gltf).coverage.ignored.size(), 101u);
}

TEST(GltfCoverage, ExtensionsThatTheFileForgetsToListAreFound) {
  GltfBuilder gltf;
  gltf.add_triangle();
  gltf.push("materials", {{"extensions",
                           {{"KHR_materials_unlit", nlohmann::json::object()},
                            {"VENDOR_other", 1},
                            {"KHR_materials_emissive_strength", nlohmann::json::object()}}}});
  gltf.root["extensionsUsed"] = {"KHR_materials_unlit"};
  const CoverageReport coverage = load(gltf).coverage;
  EXPECT_EQ(coverage.used,
            (std::vector<std::string>{"KHR_materials_unlit", "KHR_materials_emissive_strength"}));
  EXPECT_EQ(coverage.ignored, std::vector<std::string>{"VENDOR_other (unknown extension)"});
}

TEST(GltfCoverage, EveryHonouredExtensionMayBeRequired) {
  for (const char* name : {"EXT_mesh_gpu_instancing",
                           "EXT_meshopt_compression",
                           "EXT_texture_webp",
                           "KHR_draco_mesh_compression",
                           "KHR_lights_punctual",
                           "KHR_materials_anisotropy",
                           "KHR_materials_clearcoat",
                           "KHR_materials_diffuse_transmission",
                           "KHR_materials_dispersion",
                           "KHR_materials_emissive_strength",
                           "KHR_materials_ior",
                           "KHR_materials_iridescence",
                           "KHR_materials_pbrSpecularGlossiness",
                           "KHR_materials_sheen",
                           "KHR_materials_specular",
                           "KHR_materials_transmission",
                           "KHR_materials_unlit",
                           "KHR_materials_variants",
                           "KHR_materials_volume",
                           "KHR_mesh_quantization",
                           "KHR_texture_basisu",
                           "KHR_texture_transform"}) {
    GltfBuilder gltf;
    gltf.add_triangle();
    gltf.root["extensionsUsed"] = gltf.root["extensionsRequired"] = {name};
    const CoverageReport coverage = load(gltf).coverage;
    EXPECT_EQ(coverage.used, std::vector<std::string>{name});
    EXPECT_TRUE(coverage.approximated.empty() && coverage.ignored.empty()) << name;
  }
}

TEST(GltfCoverage, UnsupportedRequiredExtensionsAreErrors) {
  for (const char* name : {"KHR_materials_subsurface", "VENDOR_new_thing"}) {
    GltfBuilder gltf;
    gltf.add_triangle();
    gltf.root["extensionsUsed"] = {"KHR_materials_unlit", name};
    gltf.root["extensionsRequired"] = {"KHR_materials_unlit", name};
    try {
      load(gltf);
      ADD_FAILURE() << name << " was accepted";
    } catch (const InputError& error) {
      EXPECT_EQ(error.exit_code(), kExitInput);
      const std::string message = error.what();
      EXPECT_NE(message.find("a.glb#/extensionsRequired/1: "), std::string::npos) << message;
      EXPECT_NE(message.find(name), std::string::npos) << message;
    }
  }
}

TEST(GltfCoverage, OcclusionIsIgnoredAndAnimationsAreNotPlayed) {
  GltfBuilder gltf;
  gltf.add_triangle();
  gltf.push("animations",
            {{"channels", nlohmann::json::array()}, {"samplers", nlohmann::json::array()}});
  gltf.push("images", {{"uri", "not_there.png"}});
  gltf.push("textures", {{"source", 0}});
  gltf.push("materials", {{"occlusionTexture", {{"index", 0}}}});
  gltf.primitive()["material"] = 0;
  const CoverageReport coverage = load(gltf).coverage;
  EXPECT_EQ(coverage.not_played, "1 animation; set `time` or `frame` to play it");
  EXPECT_TRUE(
      contains(coverage.ignored, "occlusionTexture (occlusion is computed by ray tracing)"));
}

}  // namespace
}  // namespace emberline
