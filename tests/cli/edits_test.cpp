// Tests --edits, which changes the look of a scene without changing its file.
#include "cli/command_test.h"

#include <nlohmann/json.hpp>

namespace emberline::test {
namespace {

class EditsOption : public CommandTest {
 protected:
  // Renders scene.glb with `edits`, a JSON object to which this function adds the version.
  ExrPicture edited(nlohmann::json edits, const Words& more = {}) {
    edits["emberline_edits"] = 1;
    write("shot.json", edits.dump());
    return picture(Words{"--edits", path("shot.json")} + more);
  }
  ExrPicture picture(const Words& more = {}) {
    result_ = render(render_words(Words{"--spp", "4"} + more));
    return read_exr(path("out.exr"));
  }
  void expect_refused(const std::string& text, const Words& message_parts) {
    write("shot.json", text);
    expect_failure(render_words({"--edits", path("shot.json"), "--report", path("r.json")}), 3,
                   Words{"shot.json"} + message_parts);
  }
  RunResult result_;
};

TEST_F(EditsOption, EqualAChangedFile) {
  const ExrPicture seen = edited({{"materials",
                                   {{{"name", "matte"},
                                     {"base_color", {0.1, 0.6, 0.2}},
                                     {"roughness", 0.25},
                                     {"metallic", 1}}}},
                                  {"lights",
                                   {{{"kind", "material"},
                                     {"name", "lamp"},
                                     {"intensity", 0.5},
                                     {"color", {1, 0.5, 0.25}}}}}});
  EXPECT_EQ(seen.attributes.at("emberline:edits"), path("shot.json"));
  GltfBuilder gltf = lamp_scene();
  nlohmann::json& matte = gltf.root["materials"][0]["pbrMetallicRoughness"];
  matte["baseColorFactor"] = {0.1, 0.6, 0.2, 1};
  matte["roughnessFactor"] = 0.25;
  matte["metallicFactor"] = 1;
  gltf.root["materials"][1]["emissiveFactor"] = {0.5, 0.9f * 0.25f, 0.8f * 0.125f};
  gltf.write_glb(path("scene.glb"));
  EXPECT_EQ(first_difference(seen, picture()), "");
}

// Anisotropy needs tangents, which the file lacks. They must be generated for an edit in the same
// way as for a changed file.
TEST_F(EditsOption, LayersEqualThoseOfAChangedFile) {
  const ExrPicture seen = edited({{"materials",
                                   {{{"name", "matte"},
                                     {"ior", 1.8},
                                     {"specular_color", {4, 2, 1}},
                                     {"anisotropy", 0.5},
                                     {"clearcoat", 0.75},
                                     {"clearcoat_roughness", 0.25},
                                     {"sheen_color", {0.5, 0.25, 0.125}},
                                     {"sheen_roughness", 0.5}}}}});
  GltfBuilder gltf = lamp_scene();
  gltf.root["materials"][0]["extensions"] = {
      {"KHR_materials_ior", {{"ior", 1.8}}},
      {"KHR_materials_specular", {{"specularColorFactor", {4, 2, 1}}}},
      {"KHR_materials_anisotropy", {{"anisotropyStrength", 0.5}}},
      {"KHR_materials_clearcoat", {{"clearcoatFactor", 0.75}, {"clearcoatRoughnessFactor", 0.25}}},
      {"KHR_materials_sheen",
       {{"sheenColorFactor", {0.5, 0.25, 0.125}}, {"sheenRoughnessFactor", 0.5}}}};
  gltf.write_glb(path("scene.glb"));
  EXPECT_EQ(first_difference(seen, picture()), "");
}

TEST_F(EditsOption, EmptyEditsChangeNothing) {
  const ExrPicture plain = picture();
  EXPECT_EQ(first_difference(plain, edited(nlohmann::json::object())), "");
}

// Tests all of our scenes, and therefore every kind of light, layer and texture in them.
TEST_F(EditsOption, TemplateOfInfoChangesNothing) {
  std::vector<Words> scenes = {{EMBERLINE_SCENES "/teapot.glb", "--sun", "20,50", "--env-strength",
                                "0.3", "--env-rotation", "33.3"}};
  for (const auto& entry : std::filesystem::directory_iterator(EMBERLINE_SCENES)) {
    if (entry.path().extension() == ".glb") scenes.push_back({entry.path().string()});
  }
  for (const Words& words : scenes) {
    const RunResult result = run(Words{"info", "--edits"} + words);
    ASSERT_EQ(result.exit_code, 0) << result.describe();
    write("template.json", result.out);
    const Words frame = Words{"render"} + words + Words{"-o", path("out.exr"), "--size", "32x18"} +
                        Words{"--spp", "4", "--aov", "albedo,N,emission"};
    render(frame);
    const ExrPicture plain = read_exr(path("out.exr"));
    render(frame + Words{"--edits", path("template.json")});
    EXPECT_EQ(first_difference(plain, read_exr(path("out.exr"))), "") << words[0];
  }
}

TEST_F(EditsOption, TemplateHasEveryLightMaterialAndTheEnvironment) {
  GltfBuilder gltf = lamp_scene();
  gltf.root["extensionsUsed"] = {"KHR_lights_punctual"};
  gltf.root["extensions"] = {
      {"KHR_lights_punctual", {{"lights", {{{"type", "point"}, {"intensity", 5}}}}}}};
  gltf.add_to_scene(
      gltf.push("nodes", {{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}}));
  add_quad(gltf, {3, 0, 2}, {1, 0, 0}, {0, 0, -4}, -1);
  gltf.root["materials"][0]["extensions"] = {
      {"KHR_materials_anisotropy", {{"anisotropyStrength", 0.5}, {"anisotropyRotation", 1}}}};
  gltf.root["materials"][0]["name"] = gltf.root["materials"][1]["name"];
  gltf.write_glb(path("scene.glb"));
  const RunResult result = run({"info", path("scene.glb"), "--edits", "--sun", "20,50"});
  ASSERT_EQ(result.exit_code, 0) << result.describe();
  const nlohmann::json edits = nlohmann::json::parse(result.out);
  EXPECT_EQ(edits["environment"], nlohmann::json({{"strength", 1.0}, {"rotation", 0.0}}));
  ASSERT_EQ(edits["lights"].size(), 3u);
  EXPECT_EQ(edits["lights"][0]["kind"], "punctual");
  EXPECT_EQ(edits["lights"][1], nlohmann::json({{"kind", "material"},
                                                {"name", "lamp"},
                                                {"index", 1},
                                                {"intensity", 1.0},
                                                {"color", {1.0, 1.0, 1.0}},
                                                {"on", true}}));
  EXPECT_EQ(edits["lights"][2]["kind"], "environment");
  ASSERT_EQ(edits["materials"].size(), 3u);
  EXPECT_EQ(edits["materials"][0]["base_color"], nlohmann::json({0.7, 0.5, 0.3}));
  EXPECT_FALSE(edits["materials"][0].contains("attenuation_distance"));
  EXPECT_EQ(edits["materials"][2]["name"], "default material");
  write("template.json", result.out);
  const Words sun = {"--sun", "20,50", "--spp", "4", "--light-groups"};
  EXPECT_EQ(first_difference(picture(sun), picture(sun + Words{"--edits", path("template.json")})),
            "");
}

TEST_F(EditsOption, SwitchingOffTheLastLampGivesDarkness) {
  const ExrPicture dark =
      edited({{"lights", {{{"kind", "material"}, {"name", "lamp"}, {"on", false}}}}});
  for (const char* channel : {"R", "G", "B"}) {
    for (const float value : dark.channels.at(channel)) ASSERT_EQ(value, 0.0f);
  }
  EXPECT_EQ(result_.err.find("warning"), std::string::npos) << result_.err;
}

TEST_F(EditsOption, DefaultEnvironmentIsEditable) {
  unlit_scene().write_glb(path("scene.glb"));
  const ExrPicture seen =
      edited({{"lights", {{{"kind", "environment"}, {"intensity", 3}, {"color", {1, 0.5, 0}}}}}});
  EXPECT_EQ(seen.at("R", 8, 0), 3.0f);
  EXPECT_EQ(seen.at("G", 8, 0), 1.5f);
  EXPECT_EQ(seen.at("B", 8, 0), 0.0f);
}

TEST_F(EditsOption, EnvironmentInEditsOverridesTheCommandLine) {
  write_floats(path("grey.exr"), 8, 4, 3, std::vector<float>(8 * 4 * 3, 0.25f));
  write_floats(path("bright.exr"), 8, 4, 3, std::vector<float>(8 * 4 * 3, 2.0f));
  const Words bright = {"--env", path("bright.exr")};
  EXPECT_EQ(edited({{"environment", {{"strength", 0.5}}}}, bright).at("R", 8, 0), 1.0f);
  const nlohmann::json grey = {{"environment", {{"file", "grey.exr"}, {"strength", 2}}}};
  EXPECT_EQ(edited(grey, bright).at("R", 8, 0), 0.5f);
}

TEST_F(EditsOption, CommandLineOverridesTheView) {
  const Words words = {"--look-from", "1,2,3", "--look-at", "0,0.5,0", "--fov-y", "35"};
  const nlohmann::json view = {
      {"camera", {{"look_from", {1, 2, 3}}, {"look_at", {0, 0.5, 0}}, {"fov_y", 35}}}};
  const ExrPicture seen = edited(view);
  EXPECT_EQ(first_difference(seen, picture(words)), "");
  const ExrPicture main = picture({"--camera", "main"});
  EXPECT_NE(first_difference(seen, main), "");
  EXPECT_EQ(first_difference(edited(view, {"--camera", "main"}), main), "");
  EXPECT_NE(result_.err.find("shot.json#/camera"), std::string::npos) << result_.err;
  EXPECT_EQ(first_difference(edited({{"camera", {{"file_camera", {{"index", 0}}}}}}), main), "");
}

TEST_F(EditsOption, ErrorsAreOneLine) {
  expect_refused("{", {"not valid JSON near byte 2"});
  expect_refused(std::string(100000, '['), {"nested deeper than 256 levels"});
  expect_refused(R"({"emberline_edits": 1, "environment": {"rotation": 1e400}})",
                 {"#/environment/rotation", "too large"});
  expect_refused("{}", {"emberline_edits"});
  expect_refused(R"({"emberline_edits": 9})", {"#/emberline_edits", "9"});
  expect_refused(R"({"emberline_edits": 1, "material": []})", {"#/material", "'materials'"});
  expect_refused(R"({"emberline_edits": 1, "materials": [{"name": "mat", "roughness": 1}]})",
                 {"#/materials/0", "'mat'", "0 'matte'", "1 'lamp'"});
  expect_refused(R"({"emberline_edits": 1, "materials": [{"index": 0, "roughness": 2}]})",
                 {"#/materials/0/roughness", "0 to 1"});
  expect_refused(R"({"emberline_edits": 1, "lights": [{"kind": "punctual", "index": 0}]})",
                 {"#/lights/0", "no lights"});
  expect_refused(R"({"emberline_edits": 1, "environment": {"rotation": 90}})",
                 {"#/environment", "no environment"});
  expect_refused(R"({"emberline_edits": 1, "environment": {"file": "gone.hdr"}})",
                 {"#/environment/file", "gone.hdr"});
  expect_refused(R"({"emberline_edits": 1, "camera": {"file_camera": {"name": "B"}}})",
                 {"#/camera/file_camera", "'B'", "0 'main'"});
  expect_failure(render_words({"--edits", path("nowhere.json")}), 3, {"nowhere.json"});
  expect_failure(render_words({"--edits"}), 2, {"--edits", "FILE"});
}

}  // namespace
}  // namespace emberline::test
