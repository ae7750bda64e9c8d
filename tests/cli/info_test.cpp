// Tests `emberline info`, which lists the contents of a scene as text and as JSON.
#include "cli/command_test.h"

#include <nlohmann/json.hpp>
#include "support/embedded_images.h"

namespace emberline::test {
namespace {

class Info : public CommandTest {
 protected:
  // Returns a scene that contains one of everything that `info` lists.
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
  for (const char* part : {"scene.glb", "a test", "camera 0 'main'", "light 0 'bulb'", "honoured\n",
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
  // In the text output, control characters must not reach the terminal.
  const RunResult text = run({"info", path("scene.glb")});
  EXPECT_NE(text.out.find("camera 0 '\\x1b[31m red \\n \xc3\xa4'"), std::string::npos) << text.out;
}

// Adds a chain of nodes without names to the scene. Each node is the child of the one before it.
void add_chain(GltfBuilder& gltf, size_t length) {
  const size_t first = gltf.root["nodes"].size();
  for (size_t i = 0; i < length; ++i) {
    nlohmann::json node = nlohmann::json::object();
    if (i + 1 < length) node["children"] = {first + i + 1};
    gltf.root["nodes"].push_back(node);
  }
  gltf.add_to_scene(int(first));
}

TEST_F(Info, NodesAreATreeWithIndices) {
  GltfBuilder gltf = lamp_scene();
  gltf.root["nodes"][1]["name"] = "eye";
  gltf.root["nodes"][2]["name"] = "lamp\n\x1b[31m";
  const int set = gltf.push("nodes", {{"name", "set"}, {"children", {2, 1}}});
  gltf.root["scenes"][0]["nodes"] = {0, set};
  gltf.push("nodes", {{"name", "spare"}});
  const std::string file = gltf.write_glb(path("scene.glb"));
  const RunResult text = run({"info", file});
  EXPECT_NE(text.out.find("nodes\n"
                          "  0 'node 0'  mesh\n"
                          "  3 'set'\n"
                          "    1 'eye'  camera\n"
                          "    2 'lamp\\n\\x1b[31m'  mesh\n"
                          "  4 'spare'  not in the scene\n"),
            std::string::npos)
      << text.out;
  EXPECT_NE(text.out.find("material 0 'matte'\nmaterial 1 'lamp', emissive\n"), std::string::npos)
      << text.out;
  const nlohmann::json json = nlohmann::json::parse(run({"info", file, "--json"}).out);
  ASSERT_EQ(json["nodes"].size(), 5u);
  EXPECT_EQ(json["nodes"][2], nlohmann::json({{"index", 2},
                                              {"name", "lamp\n\x1b[31m"},
                                              {"parent", set},
                                              {"mesh", true},
                                              {"camera", false},
                                              {"light", false},
                                              {"in_scene", true}}));
  EXPECT_TRUE(json["nodes"][0]["parent"].is_null());
  EXPECT_EQ(json["nodes"][4]["in_scene"], false);
  EXPECT_EQ(json["material_list"][1],
            nlohmann::json({{"index", 1}, {"name", "lamp"}, {"emissive", true}}));
}

TEST_F(Info, LargeTreesAreCutAndJsonHasAllNodes) {
  constexpr size_t kCount = 100'000;
  GltfBuilder gltf = lamp_scene();
  nlohmann::json children = nlohmann::json::array();
  for (size_t i = 0; i < kCount; ++i) children.push_back(4 + i);
  gltf.push("nodes", {{"name", "crowd"}, {"children", children}});
  for (size_t i = 0; i < kCount; ++i) {
    gltf.root["nodes"].push_back({{"name", std::string(100, 'x')}});
  }
  gltf.add_to_scene(3);
  gltf.add_to_scene(gltf.push("nodes", {{"name", "last root"}}));
  const std::string file = gltf.write_glb(path("scene.glb"));
  const std::string text = run({"info", file}).out;
  EXPECT_LT(text.size(), 30'000u);
  EXPECT_NE(text.find("nodes 100005"), std::string::npos) << text;
  EXPECT_NE(text.find("  3 'crowd'  99,805 more below\n"), std::string::npos) << text;
  EXPECT_NE(text.find("'last root'\n"), std::string::npos) << text;
  const nlohmann::json json = nlohmann::json::parse(run({"info", file, "--json"}).out);
  EXPECT_EQ(json["nodes"].size(), kCount + 5);
}

TEST_F(Info, DeepNodesAreCounted) {
  GltfBuilder gltf = lamp_scene();
  add_chain(gltf, 50'000);
  const RunResult text = run({"info", gltf.write_glb(path("scene.glb"))});
  ASSERT_EQ(text.exit_code, 0) << text.describe();
  EXPECT_NE(text.out.find("\n" + std::string(48, ' ') + "26 'node 26'  49,976 more below\n"),
            std::string::npos)
      << text.out;
}

TEST_F(Info, CyclesOutsideTheSceneAreListed) {
  GltfBuilder gltf = lamp_scene();
  gltf.push("nodes", {{"name", "egg"}, {"children", {4}}});
  gltf.push("nodes", {{"name", "hen"}, {"children", {3, 5}}});
  gltf.push("nodes", {{"name", "chick"}, {"children", {5}}});
  const RunResult text = run({"info", gltf.write_glb(path("scene.glb"))});
  ASSERT_EQ(text.exit_code, 0) << text.describe();
  for (const char* line : {"  3 'egg'  not in the scene\n", "  4 'hen'  not in the scene\n",
                           "  5 'chick'  not in the scene\n"}) {
    EXPECT_NE(text.out.find(line), std::string::npos) << text.out;
  }
}

TEST_F(Info, EnvironmentIsTheRenders) {
  scene();
  const RunResult json =
      run({"info", path("scene.glb"), "--sun", "30,90", "--env-strength", "2", "--json"});
  ASSERT_EQ(json.exit_code, 0) << json.describe();
  EXPECT_EQ(nlohmann::json::parse(json.out)["environment"]["strength"], 2.0);
  expect_failure({"info", path("scene.glb"), "--env-strength", "2"}, 2, {"--env-strength"});
  expect_failure({"info", path("scene.glb"), "--env", "gone.hdr"}, 3, {"gone.hdr"});
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
