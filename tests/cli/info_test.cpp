// `emberline info`: a scene's contents as text and as JSON.
#include "cli/command_test.h"

#include <nlohmann/json.hpp>
#include "support/embedded_images.h"

namespace emberline::test {
namespace {

class Info : public CommandTest {
 protected:
  // Contains one of everything that info lists.
  GltfBuilder rich_scene() {
    GltfBuilder gltf = lamp_scene();
    gltf.root["asset"]["generator"] = "a test";
    auto& matte = gltf.root["materials"][0];
    const int texture = add_texture(gltf, small_png());
    matte["pbrMetallicRoughness"]["baseColorTexture"]["index"] = texture;
    matte["occlusionTexture"]["index"] = texture;
    gltf.root["extensionsUsed"] = {"KHR_lights_punctual", "EXT_made_up"};
    gltf.root["extensions"] = {
        {"KHR_lights_punctual",
         {{"lights", {{{"name", "bulb"}, {"type", "point"}, {"intensity", 5}}}}}},
        {"EXT_made_up", nlohmann::json::object()}};
    gltf.add_to_scene(
        gltf.push("nodes", {{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}}));
    gltf.add_to_scene(gltf.push("nodes", {{"mesh", 0}, {"translation", {0, -1, 0}}}));
    return gltf;
  }
};

bool mentions(const nlohmann::json& list, const std::string& word) {
  for (const auto& entry : list) {
    if (entry.get<std::string>().find(word) != std::string::npos) return true;
  }
  return false;
}

TEST_F(Info, Json) {
  const RunResult result = run({"info", rich_scene().write_glb(path("scene.glb")), "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.describe();
  const nlohmann::json json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json["file"], path("scene.glb"));
  EXPECT_EQ(json["generator"], "a test");
  EXPECT_EQ(json["meshes"], 2);
  EXPECT_EQ(json["instances"], 3);
  EXPECT_EQ(json["triangles"]["stored"], 4);
  EXPECT_EQ(json["triangles"]["placed"], 6);
  EXPECT_NEAR(json["bounds"]["min"][1].get<double>(), -1.0, 1e-6);
  EXPECT_NEAR(json["bounds"]["max"][1].get<double>(), 1.2, 1e-6);
  ASSERT_EQ(json["images"].size(), 1u);
  EXPECT_EQ(json["images"][0]["width"], 2);
  ASSERT_EQ(json["lights"].size(), 1u);
  EXPECT_EQ(json["lights"][0]["name"], "bulb");
  ASSERT_EQ(json["cameras"].size(), 1u);
  EXPECT_EQ(json["cameras"][0]["name"], "main");
  EXPECT_NEAR(json["cameras"][0]["fov_y_degrees"].get<double>(), 0.8 * 180 / 3.14159265, 1e-4);
  EXPECT_TRUE(mentions(json["gltf"]["used"], "KHR_lights_punctual")) << json["gltf"];
  EXPECT_TRUE(mentions(json["gltf"]["ignored"], "EXT_made_up")) << json["gltf"];
  EXPECT_TRUE(mentions(json["gltf"]["ignored"], "occlusionTexture")) << json["gltf"];
  EXPECT_TRUE(json["gltf"]["approximated"].is_array());
  EXPECT_TRUE(mentions(json["features"], "texture")) << json["features"];
}

TEST_F(Info, Text) {
  const RunResult result = run({"info", rich_scene().write_glb(path("scene.glb"))});
  ASSERT_EQ(result.exit_code, 0) << result.describe();
  for (const char* part : {"scene.glb", "a test", "camera 'main'", "light 'bulb'", "honoured\n",
                           "  KHR_lights_punctual", "ignored\n", "occlusionTexture", "EXT_made_up",
                           "scene features\n"}) {
    EXPECT_NE(result.out.find(part), std::string::npos) << part << "\n" << result.out;
  }
  EXPECT_EQ(result.out.find('\033'), std::string::npos);
}

TEST_F(Info, InvalidUtf8NamesDoNotBreakTheJson) {
  GltfBuilder gltf = lamp_scene();
  gltf.root["cameras"][0]["name"] = "\x1b[31m red \n \xc3\xa4";
  const RunResult result = run({"info", gltf.write_glb(path("scene.glb")), "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.describe();
  EXPECT_EQ(nlohmann::json::parse(result.out)["cameras"][0]["name"], "\x1b[31m red \n \xc3\xa4");
  // In text output, no control character reaches the terminal.
  const RunResult text = run({"info", path("scene.glb")});
  EXPECT_NE(text.out.find("camera '\\x1b[31m red \\n \xc3\xa4'"), std::string::npos) << text.out;
}

TEST_F(Info, OurOwnScenesLoad) {
  for (const auto& entry : std::filesystem::directory_iterator(EMBERLINE_SCENES)) {
    if (entry.path().extension() != ".glb") continue;
    const RunResult result = run({"info", entry.path().string(), "--json"});
    EXPECT_EQ(result.exit_code, 0) << result.describe();
    const nlohmann::json json = nlohmann::json::parse(result.out, nullptr, false);
    EXPECT_GT(json["triangles"]["placed"], 0) << entry.path();
    EXPECT_FALSE(json["cameras"].empty()) << entry.path();
  }
}

}  // namespace
}  // namespace emberline::test
