// Tests writing and reading edits, and the errors of invalid files.
#include "io/json/edits_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include "renderer/core/errors.h"
#include "renderer/description/material_parameters.h"
#include "support/image_files.h"
#include "unit/output_folder.h"

namespace emberline {
namespace {

class EditsFile : public OutputFolder {
 protected:
  std::string write(const std::string& text) const {
    std::ofstream(path("shot.json")) << text;
    return path("shot.json");
  }
  std::string rejection_message(const std::string& text) const {
    try {
      read_edits(write(text));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
};

SceneEdits everything() {
  SceneEdits edits;
  edits.camera.camera = EditTarget{"main", 2, ""};
  edits.camera.look_from = Vec3d(0.1, -1e-17, 12345.678901234567);
  edits.camera.look_at = Vec3d(1.0 / 3.0, 2, 3);
  edits.camera.up = Vec3d(0.1, 0.9, -0.2);
  edits.camera.fov_y_degrees = 33.3;
  edits.camera.f_stop = 2.8;
  edits.camera.focus_distance = 1.0 / 7.0;
  edits.animation.name = "walk";
  edits.animation.time = 0.1;
  edits.animation.fps = 29.97;
  edits.animation.shutter_open = -0.25;
  edits.animation.shutter_close = 1.0 / 3.0;
  edits.variant = EditTarget{"beach", 3, ""};
  edits.environment.strength = 0.1f;
  edits.environment.rotation_degrees = -123.4f;
  LightEdit& light = edits.lights.emplace_back();
  light.target = {"K\"ey \xc3\xa9", 1, ""};
  light.intensity = 1.7f;
  light.color = {0.1f, 0.2f, 0.3f};
  light.on = false;
  edits.lights.emplace_back().kind = EditedLight::kEnvironment;
  edits.lights.emplace_back().kind = EditedLight::kMaterial;
  edits.lights.back().target.index = 0;
  MaterialEdit& material = edits.materials.emplace_back();
  material.target = {"glass", -1, ""};
  material.base_color = Rgb(0.7f);
  material.roughness = 0.15f;
  material.metallic = 1.0f;
  material.emission = Rgb(1e9f, 0.0f, 1e-30f);
  material.transmission = 0.9f;
  material.normal_scale = -2.5f;
  float number = 0.1f;
  for (const MaterialParameter& p : material_parameters()) {  // parameters that are not set above
    if (p.color) {
      auto& color = material.*p.edited_color;
      if (!color) color = Rgb(number, 0.5f * number, 0.25f);
    } else if (!(material.*p.edited_number)) {
      material.*p.edited_number = float(p.minimum) + number;
    }
    number += 0.03f;
  }
  edits.materials.emplace_back().target.index = 7;
  edits.materials.back().roughness = 0.0f;
  return edits;
}

SceneEdits flat_and_mirrored() {
  SceneEdits edits;
  edits.camera.look_from = Vec3d(0.1, 0.2, 0.3);
  edits.camera.look_at = Vec3d(1.0 / 3.0, 2, 3);
  edits.camera.mirrored = true;
  edits.camera.orthographic_height = 1e-6 / 7.0;
  return edits;
}

TEST_F(EditsFile, ComesBackAsItWas) {
  write_edits(path("flat.json"), flat_and_mirrored());
  EXPECT_EQ(read_edits(path("flat.json")), flat_and_mirrored());
  write_edits(path("shot.json"), everything());
  EXPECT_EQ(read_edits(path("shot.json")), everything());
  write_edits(path("none.json"), {});
  EXPECT_EQ(read_edits(path("none.json")), SceneEdits{});
}

TEST_F(EditsFile, AMaterialsParametersAreHeldToTheirRanges) {
  const auto edit = [&](std::string_view name, double value, bool color) {
    const std::string number = std::to_string(value);
    const std::string text = color ? "[1, " + number + ", 1]" : number;
    return rejection_message(R"({"emberline_edits": 1, "materials": [{"index": 0, ")" +
                             std::string(name) + "\": " + text + "}]}");
  };
  for (const MaterialParameter& p : material_parameters()) {
    EXPECT_EQ(
        edit(p.name, p.minimum + 0.5 * std::min(1.0, p.maximum - p.minimum), p.color != nullptr),
        "")
        << p.name;
    const std::string place = "#/materials/0/" + std::string(p.name);
    for (const double bad : {p.minimum - 1.0, 2.0 * p.maximum}) {
      EXPECT_NE(edit(p.name, bad, p.color != nullptr).find(place), std::string::npos) << p.name;
    }
  }
}

// For readability, floats are written with the fewest digits that restore them. The numbers come
// from std::mt19937 with seed 1.
TEST_F(EditsFile, FloatsAreWrittenShortAndComeBackToTheBit) {
  std::mt19937 random(1);
  SceneEdits edits;
  for (int i = 0; i < 2000; ++i) {
    MaterialEdit& edit = edits.materials.emplace_back();
    edit.target.index = i;
    const auto number = [&] { return std::ldexp(float(random()) * 0x1p-32f, -int(random() % 90)); };
    edit.emission = Rgb(number(), number(), number());
    edit.roughness = std::min(1.0f, number());
  }
  edits.materials[0].roughness = 0.1f;
  write_edits(path("shot.json"), edits);
  EXPECT_EQ(read_edits(path("shot.json")), edits);
  const std::string text = read_text(path("shot.json"));
  EXPECT_NE(text.find("\"roughness\": 0.1,"), std::string::npos);
}

TEST_F(EditsFile, EnvironmentPathIsRelativeToTheFile) {
  std::vector<float> texels(8 * 4 * 3, 0.5f);
  texels[0] = std::nanf("");
  test::write_floats(path("sky.exr"), 8, 4, 3, texels);
  SceneEdits edits =
      read_edits(write(R"({"emberline_edits": 1, "environment": {"file": "sky.exr"}})"));
  ASSERT_TRUE(edits.environment.image);
  EXPECT_EQ(edits.environment.image->width, 8);
  EXPECT_EQ(edits.environment.repaired_texels, 1u);
  EXPECT_EQ(edits.environment.file, path("sky.exr"));
  // Paths are written relative to the file, and are resolved from its folder.
  std::filesystem::create_directories(folder_ / "sub");
  edits.environment.file = std::filesystem::relative(path("sky.exr")).string();
  write_edits(path("sub/shot.json"), edits);
  const std::string text = read_text(path("sub/shot.json"));
  EXPECT_NE(text.find("\"../sky.exr\""), std::string::npos) << text;
  EXPECT_TRUE(read_edits(path("sub/shot.json")).environment.image);
}

TEST_F(EditsFile, ErrorsNameThePlace) {
  struct Wrong {
    const char* members;  // after the version
    std::vector<std::string> message_parts;
  };
  const Wrong wrongs[] = {
      {R"("light": [])", {"#/light: ", "did you mean 'lights'"}},
      {R"("camera": 3)", {"#/camera: ", "object"}},
      {R"("camera": {"fov": 30})", {"#/camera/fov: ", ", fov_y"}},
      {R"("camera": {"fov_y": 180})", {"#/camera/fov_y: ", "0.05", "179.9", "180"}},
      {R"("camera": {"f_stop": 0})", {"#/camera/f_stop: ", "1e-09", "0"}},
      {R"("camera": {"focus_distance": -3})", {"#/camera/focus_distance: ", "-3"}},
      {R"("camera": {"look_from": [0, 1, 2]})", {"#/camera: ", "look_at"}},
      {R"("camera": {"look_from": [0, 1], "look_at": [0, 0, 0]})", {"#/camera/look_from: ", "3"}},
      {R"("camera": {"look_from": [0, 1, 2], "look_at": [0, "a", 0]})",
       {"#/camera/look_at/1: ", "number", "\"a\""}},
      {R"("camera": {"up": [0, 1, 0]})", {"#/camera: ", "up"}},
      {R"("camera": {"look_from": [0, 1, 2], "look_at": [0, 0, 0], "up": [0, 0, 0]})",
       {"#/camera/up: ", "direction"}},
      {R"("camera": {"mirrored": true})", {"#/camera/mirrored: ", "look_from"}},
      {R"("animation": {"time": 1e7})", {"#/animation/time: ", "1000000"}},
      {R"("animation": {"fps": 0})", {"#/animation/fps: ", "0.001"}},
      {R"("animation": {"shutter_open": 0})", {"#/animation: ", "shutter_close"}},
      {R"("animation": {"shutter_open": 0.5, "shutter_close": 0})",
       {"#/animation/shutter_close: ", "before it opens"}},
      {R"("animation": {"when": 0})", {"#/animation", "when"}},
      {R"("camera": {"look_from": [0, 1, 2], "look_at": [0, 0, 0], "mirrored": 1})",
       {"#/camera/mirrored: ", "true or false"}},
      {R"("camera": {"orthographic_height": 0})", {"#/camera/orthographic_height: ", "1e-15"}},
      {R"("camera": {"orthographic_height": 2, "fov_y": 30})",
       {"#/camera/fov_y: ", "orthographic_height"}},
      {R"("camera": {"orthographic_height": 2, "f_stop": 3})",
       {"#/camera/f_stop: ", "orthographic_height"}},
      {R"("camera": {"file_camera": {}})", {"#/camera/file_camera: ", "name", "index"}},
      {R"("environment": {"rotate": 3})", {"#/environment/rotate: ", ", rotation"}},
      {R"("environment": {"strength": -1})", {"#/environment/strength: ", "-1"}},
      {R"("environment": {"file": 1})", {"#/environment/file: ", "string"}},
      {R"("environment": {"file": "nowhere.hdr"})", {"#/environment/file: ", "nowhere.hdr"}},
      {R"("variant": "beach")", {"#/variant: ", "object"}},
      {R"("variant": {})", {"#/variant: ", "name", "index"}},
      {R"("variant": {"index": -1})", {"#/variant/index: ", "-1"}},
      {R"("lights": {})", {"#/lights: ", "array"}},
      {R"("lights": [{"name": "Key"}])", {"#/lights/0: ", "kind"}},
      {R"("lights": [{"kind": "spot", "name": "Key"}])",
       {"#/lights/0/kind: ", "punctual, material, environment"}},
      {R"("lights": [{"kind": "punctual"}])", {"#/lights/0: ", "name", "index"}},
      {R"("lights": [{"kind": "environment", "index": 0}])", {"#/lights/0: ", "environment"}},
      {R"("lights": [{"kind": "punctual", "index": -1}])", {"#/lights/0/index: ", "-1"}},
      {R"("lights": [{"kind": "punctual", "index": 1.5}])", {"#/lights/0/index: ", "1.5"}},
      {R"("lights": [{"kind": "punctual", "index": 0, "on": 1}])", {"#/lights/0/on: ", "true"}},
      {R"("lights": [{"kind": "punctual", "index": 0, "color": [1, 1, -1]}])",
       {"#/lights/0/color/2: ", "-1"}},
      {R"("materials": [{"index": 0}, {"index": 1, "roughness": 1.1}])",
       {"#/materials/1/roughness: ", "0 to 1", "1.1"}},
      {R"("materials": [{"index": 0, "roughnes": 1}])",
       {"#/materials/0/roughnes: ", "did you mean 'roughness'"}},
      {R"("materials": [{"index": 0, "clear_coat": 1}])",
       {"#/materials/0/clear_coat: ", "did you mean 'clearcoat'"}},
      {R"("materials": [{"index": 0, "ior": 0.5}])", {"#/materials/0/ior: ", "1 to 10000", "0.5"}},
      {R"("materials": [{"index": 0, "sheen_color": 1}])", {"#/materials/0/sheen_color: ", "3"}},
      {R"("materials": [{"index": 0, "roughness": 1, "roughness": 0}])",
       {"#/materials/0/roughness: ", "twice"}},
      {R"("environment": {"rotation": 1e400})", {"#/environment/rotation: ", "too large"}},
      {R"("lights": [{"kind": "punctual", "index": })", {"#/lights/0/index: ", "JSON"}},
      {R"("materials": [{"index": 0, "emission": [1e300, 0, 0]}])", {"#/materials/0/emission/0: "}},
  };
  for (const Wrong& wrong : wrongs) {
    const std::string message =
        rejection_message(R"({"emberline_edits": 1, )" + std::string(wrong.members) + "}");
    for (const std::string& words : wrong.message_parts) {
      EXPECT_NE(message.find(words), std::string::npos)
          << wrong.members << " says \"" << message << "\" without " << words;
    }
    EXPECT_NE(message.find("shot.json"), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

// Deep nesting must not overflow the stack.
TEST_F(EditsFile, NestedTooDeeplyIsRefused) {
  for (const int depth : {257, 100000, 1000000}) {
    const std::string message = rejection_message("{\"emberline_edits\": 1, \"lights\": " +
                                                  std::string(size_t(depth), '['));
    EXPECT_NE(message.find("nested deeper than 256 levels"), std::string::npos) << message;
    EXPECT_LT(message.size(), 400u) << message;
  }
}

TEST_F(EditsFile, IsRefusedWhole) {
  EXPECT_THROW(read_edits(path("none.json")), InputError);
  EXPECT_THROW(read_edits(folder_.string()), InputError);
  for (const char* text : {"", "[]", "3", "{}", "{\"emberline_edits\": 1",
                           "{\"emberline_edits\": 2}", "{\"emberline_edits\": \"1\"}",
                           "\x89PNG\r\n", "{\"a\\ud800\": 1}", "{\"emberline_edits\": 1}}"}) {
    const std::string message = rejection_message(text);
    EXPECT_NE(message.find("shot.json"), std::string::npos) << text << ": " << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

}  // namespace
}  // namespace emberline
