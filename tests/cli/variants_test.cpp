// Tests --variant, which selects the materials of one of the variants in a file.
#include "cli/command_test.h"

#include <nlohmann/json.hpp>

namespace emberline::test {
namespace {

class VariantOption : public CommandTest {
 protected:
  // lamp_scene() with two variants. "meadow" has a green floor, and "night" has a dim lamp.
  GltfBuilder varied() {
    GltfBuilder gltf = lamp_scene();
    gltf.root["extensionsUsed"] = {"KHR_materials_variants"};
    gltf.root["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "meadow"}},
                                                                     {{"name", "night"}}};
    nlohmann::json green = gltf.root["materials"][0], dim = gltf.root["materials"][1];
    green["pbrMetallicRoughness"]["baseColorFactor"] = {0.1, 0.6, 0.2, 1};
    dim["emissiveFactor"] = {0.01, 0.01, 0.02};
    const int green_index = gltf.push("materials", green), dim_index = gltf.push("materials", dim);
    for (nlohmann::json& mesh : gltf.root["meshes"]) {
      nlohmann::json& primitive = mesh["primitives"][0];
      const bool lamp = primitive["material"] == 1;
      primitive["extensions"]["KHR_materials_variants"]["mappings"] = {
          {{"material", lamp ? dim_index : green_index}, {"variants", {lamp ? 1 : 0}}}};
    }
    return gltf;
  }
  ExrPicture picture(const Words& more = {}) {
    render(render_words(Words{"--spp", "4"} + more));
    return read_exr(path("out.exr"));
  }
  void SetUp() override {
    scene();
    varied().write_glb(path("scene.glb"));
  }
};

TEST_F(VariantOption, EqualsAFileWithThoseMaterials) {
  GltfBuilder meadow = lamp_scene();
  meadow.root["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = {0.1, 0.6, 0.2, 1};
  meadow.write_glb(path("meadow.glb"));
  const ExrPicture own = picture(), named = picture({"--variant", "meadow"});
  EXPECT_EQ(named.attributes.at("emberline:variant"), "meadow");
  EXPECT_NE(first_difference(own, named), "");
  EXPECT_EQ(first_difference(named, picture({"--variant", "0"})), "");
  varied().write_glb(path("varied.glb"));
  std::filesystem::rename(path("meadow.glb"), path("scene.glb"));
  EXPECT_EQ(first_difference(named, picture()), "");
}

TEST_F(VariantOption, EditsChooseOneAndTheCommandLineAnother) {
  write("shot.json", R"({"emberline_edits": 1, "variant": {"name": "night"}})");
  const ExrPicture night = picture({"--variant", "night"});
  EXPECT_EQ(first_difference(night, picture({"--edits", path("shot.json")})), "");
  EXPECT_EQ(first_difference(picture({"--variant", "meadow"}),
                             picture({"--edits", path("shot.json"), "--variant", "meadow"})),
            "");
}

TEST_F(VariantOption, UnknownVariantListsTheNames) {
  expect_failure(render_words({"--variant", "beach"}), 2,
                 {"--variant: no variant 'beach'", "0 'meadow'", "1 'night'"});
  expect_failure(render_words({"--variant", "2"}), 2, {"no variant '2'"});
  write("shot.json", R"({"emberline_edits": 1, "variant": {"name": "beach"}})");
  expect_failure(render_words({"--edits", path("shot.json")}), 3,
                 {"shot.json#/variant: ", "no variant 'beach'", "0 'meadow', 1 'night'"});
  lamp_scene().write_glb(path("scene.glb"));
  expect_failure(render_words({"--variant", "meadow"}), 2,
                 {"--variant: no variant 'meadow'", "the file has none"});
}

TEST_F(VariantOption, InfoListsThem) {
  const RunResult json = run({"info", path("scene.glb"), "--json"});
  ASSERT_EQ(json.exit_code, 0) << json.describe();
  const nlohmann::json list = nlohmann::json::parse(json.out)["variants"];
  ASSERT_EQ(list.size(), 2u);
  EXPECT_EQ(list[1]["name"], "night");
  EXPECT_NE(run({"info", path("scene.glb")}).out.find("variant 0 'meadow'\n"), std::string::npos);
}

}  // namespace
}  // namespace emberline::test
