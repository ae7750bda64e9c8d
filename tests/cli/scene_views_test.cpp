// Tests scenes that lack something, and options that change the view.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>

#include "cli/command_test.h"
#include "support/animated_gltf.h"

namespace emberline::test {
namespace {

class Views : public CommandTest {
 protected:
  ExrPicture picture(const Words& words) {
    result_ = render(words);
    return read_exr(path("out.exr"));
  }
  RunResult result_;
};

double mean(const std::vector<float>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / double(values.size());
}

// Returns the bounding box of the pixels that see the scene.
Rect coverage(const ExrPicture& picture) {
  Rect box{1 << 20, 1 << 20, -1, -1};
  for (int y = picture.data.y0; y < picture.data.y1; ++y) {
    for (int x = picture.data.x0; x < picture.data.x1; ++x) {
      if (picture.at("A", x, y) <= 0.0f) continue;
      box = {std::min(box.x0, x), std::min(box.y0, y), std::max(box.x1, x + 1),
             std::max(box.y1, y + 1)};
    }
  }
  return box;
}

TEST_F(Views, UnlitSceneGetsAWhiteEnvironment) {
  unlit_scene().write_glb(path("scene.glb"));
  const ExrPicture seen = picture(render_words({"--spp", "16"}));
  EXPECT_NE(result_.err.find("warning"), std::string::npos) << result_.err;
  EXPECT_NE(result_.err.find("light"), std::string::npos) << result_.err;
  // Above the floor, the camera sees the environment, whose radiance is 1.
  EXPECT_EQ(seen.at("R", 8, 0), 1.0f);
  EXPECT_EQ(seen.at("A", 8, 0), 1.0f);
  // Under a constant sky, the radiance of a convex matte floor is its albedo, except for Fresnel
  // reflection and noise.
  EXPECT_NEAR(seen.at("G", 8, 11), 0.5, 0.15);
  EXPECT_GT(mean(seen.channels.at("G")), 0.3);

  EXPECT_EQ(picture(render_words({"--quiet"})).at("R", 8, 0), 1.0f);
  EXPECT_EQ(result_.err, "");

  const ExrPicture behind = picture(render_words({"--transparent"}));
  EXPECT_EQ(behind.at("A", 8, 0), 0.0f);
  EXPECT_EQ(behind.at("R", 8, 0), 0.0f);
  EXPECT_EQ(behind.at("A", 8, 11), 1.0f);
  EXPECT_GT(behind.at("G", 8, 11), 0.1f) << "it still lights the floor";
}

TEST_F(Views, ATransparentPngHasAlpha) {
  unlit_scene().write_glb(path("scene.glb"));
  render(render_words({"-o", path("a.png"), "-o", path("a.jpg"), "--transparent"}));
  const BytePicture png = read_bytes_picture(path("a.png"));
  EXPECT_EQ(png.channels, 4);
  EXPECT_EQ(png.at(8, 0)[3], 0);
  EXPECT_EQ(png.at(8, 11)[3], 255);
  EXPECT_EQ(read_bytes_picture(path("a.jpg")).channels, 3);
}

TEST_F(Views, WithoutACameraTheSceneIsFramed) {
  for (const float scale : {1e-3f, 1.0f, 1e5f}) {
    for (const char* size : {"64x64", "96x40", "30x90"}) {
      GltfBuilder gltf;
      // Make a cube far from the origin, from three pairs of faces.
      gltf.push("materials", {{"doubleSided", true}});
      const float o = 3 * scale, s = scale;
      add_quad(gltf, {o, o, o}, {s, 0, 0}, {0, s, 0}, 0);
      add_quad(gltf, {o, o, o + s}, {s, 0, 0}, {0, s, 0}, 0);
      add_quad(gltf, {o, o, o}, {s, 0, 0}, {0, 0, s}, 0);
      add_quad(gltf, {o, o + s, o}, {s, 0, 0}, {0, 0, s}, 0);
      add_quad(gltf, {o, o, o}, {0, s, 0}, {0, 0, s}, 0);
      add_quad(gltf, {o + s, o, o}, {0, s, 0}, {0, 0, s}, 0);
      gltf.write_glb(path("cube.glb"));
      const ExrPicture seen = picture({"render", path("cube.glb"), "-o", path("out.exr"), "--size",
                                       size, "--spp", "4", "--transparent"});
      EXPECT_NE(result_.err.find("no camera"), std::string::npos) << result_.err;
      const Rect box = coverage(seen), frame = seen.display;
      SCOPED_TRACE(std::string(size) + " scale " + std::to_string(scale));
      // The cube must be completely visible, centred to within a twelfth of the frame, and not
      // small.
      EXPECT_GT(box.x0, 0);
      EXPECT_GT(box.y0, 0);
      EXPECT_LT(box.x1, frame.x1);
      EXPECT_LT(box.y1, frame.y1);
      EXPECT_LE(std::abs(box.x0 + box.x1 - frame.x1), std::max(4, frame.x1 / 6));
      EXPECT_LE(std::abs(box.y0 + box.y1 - frame.y1), std::max(4, frame.y1 / 6));
      EXPECT_GT(std::max(double(box.width()) / frame.x1, double(box.height()) / frame.y1), 0.4);
    }
  }
}

TEST_F(Views, CamerasAreChosenByNameOrIndex) {
  GltfBuilder gltf = lamp_scene();
  gltf.push("cameras", {{"name", "side on"},
                        {"type", "orthographic"},
                        {"orthographic", {{"xmag", 2}, {"ymag", 2}, {"znear", 0}, {"zfar", 100}}}});
  gltf.add_to_scene(gltf.push("nodes", {{"camera", 1}, {"translation", {0, 0, 10}}}));
  gltf.write_glb(path("scene.glb"));
  const ExrPicture first = picture(render_words());
  EXPECT_EQ(first_difference(first, picture(render_words({"--camera", "main"}))), "");
  EXPECT_EQ(first_difference(first, picture(render_words({"--camera", "0"}))), "");
  const ExrPicture second = picture(render_words({"--camera", "side on"}));
  EXPECT_NE(first_difference(first, second), "");
  EXPECT_EQ(first_difference(second, picture(render_words({"--camera", "1"}))), "");
  expect_failure(render_words({"--camera", "2"}), 2, {"0 'main'", "1 'side on'"});
  expect_failure(render_words({"--camera", "1", "--fov-y", "30"}), 2, {"--fov-y", "orthographic"});
  expect_failure(render_words({"--camera", "1", "--f-stop", "2", "--focus-distance", "3"}), 2,
                 {"--f-stop", "orthographic"});
  EXPECT_NE(first_difference(first, picture(render_words({"--fov-y", "20"}))), "");
}

TEST_F(Views, CamerasAreAlsoChosenByNode) {
  GltfBuilder gltf = lamp_scene();
  gltf.push("cameras",
            {{"name", "Camera"},
             {"type", "orthographic"},
             {"orthographic", {{"xmag", 4}, {"ymag", 2}, {"znear", 0.01}, {"zfar", 100}}}});
  float x = 0;
  const double h = std::sqrt(0.5);  // makes the cameras look down
  for (const char* name : {"Wide", "Tele", "main"}) {
    gltf.add_to_scene(gltf.push(
        "nodes",
        {{"camera", 1}, {"name", name}, {"rotation", {-h, 0, 0, h}}, {"translation", {x, 5, 0}}}));
    x += 1.5f;
  }
  gltf.write_glb(path("scene.glb"));
  const auto fits = [&] { return result_.err.find("matches several cameras: "); };
  const ExrPicture wide = picture(render_words({"--camera", "Wide"}));
  EXPECT_EQ(fits(), std::string::npos) << result_.err;
  // As with a perspective camera, there is a hint about the shape of the frame.
  EXPECT_NE(result_.err.find(
                "camera 'Camera' has an aspect ratio of 2, but the frame has 1; --size 32x16"),
            std::string::npos)
      << result_.err;
  EXPECT_EQ(first_difference(wide, picture(render_words({"--camera", "1"}))), "");
  const ExrPicture tele = picture(render_words({"--camera", "Tele"}));
  EXPECT_NE(first_difference(wide, tele), "");
  EXPECT_EQ(first_difference(wide, picture(render_words({"--camera", "Camera"}))), "");
  EXPECT_NE(
      result_.err.find("--camera: 'Camera' matches several cameras: 1 'Camera' (node 'Wide'), "
                       "2 'Camera' (node 'Tele'), 3 'Camera' (node 'main'); using 1 "),
      std::string::npos)
      << result_.err;
  // The name of a camera takes precedence over the name of another camera's node.
  picture(render_words({"--camera", "main"}));
  EXPECT_NE(
      result_.err.find("matches several cameras: 0 'main', 3 'Camera' (node 'main'); using 0 "),
      std::string::npos)
      << result_.err;
  expect_failure(render_words({"--camera", "Zoom"}), 2, {"0 'main'", "2 'Camera' (node 'Tele')"});
  write("shot.json", R"({"emberline_edits": 1, "camera": {"file_camera": {"name": "Tele"}}})");
  EXPECT_EQ(first_difference(tele, picture(render_words({"--edits", path("shot.json")}))), "");
  const RunResult info = run({"info", path("scene.glb")});
  EXPECT_NE(info.out.find("camera 2 'Camera' orthographic, node 'Tele'\n"), std::string::npos)
      << info.out;
  EXPECT_NE(info.out.find("approximated\n  clip planes of cameras (nothing is clipped)\n"),
            std::string::npos)
      << info.out;
}

TEST_F(Views, BrokenCameraIsRefusedOnlyIfChosen) {
  GltfBuilder gltf = lamp_scene();
  const nlohmann::json flat = {{"yfov", 0.0}, {"znear", 0.1}};
  gltf.push("cameras", {{"name", "flat"}, {"type", "perspective"}, {"perspective", flat}});
  gltf.add_to_scene(gltf.push("nodes", {{"camera", 1}}));
  gltf.write_glb(path("scene.glb"));
  const std::string fault = "scene.glb#/cameras/1/perspective/yfov: expected an angle";
  picture(render_words());
  EXPECT_NE(result_.err.find(fault), std::string::npos) << result_.err;
  EXPECT_NE(result_.err.find("camera 'flat' cannot be used"), std::string::npos) << result_.err;
  expect_failure(render_words({"--camera", "flat"}), 3, {fault});
  const RunResult info = run({"info", path("scene.glb")});
  EXPECT_EQ(info.exit_code, 0) << info.describe();
  EXPECT_NE(info.out.find("camera 1 'flat' unusable"), std::string::npos) << info.out;
  // By default, the first camera of the file is used, so it must be usable. If another view is
  // requested, it need not be usable.
  gltf.root["cameras"].erase(0);
  for (auto& node : gltf.root["nodes"]) node.erase("camera");
  gltf.root["nodes"].back()["camera"] = 0;
  gltf.write_glb(path("scene.glb"));
  expect_failure(render_words(), 3, {"scene.glb#/cameras/0/perspective/yfov: expected an angle"});
  picture(render_words({"--look-from", "0,1,3", "--look-at", "0,0.5,0"}));
}

TEST_F(Views, LensFocusesOnLookAt) {
  scene();
  const Words view = {"--look-from", "0,1,3", "--look-at", "0,0.5,0", "--spp", "16"};
  const ExrPicture sharp = picture(render_words(view));
  const ExrPicture seen = picture(render_words(view + Words{"--f-stop", "0.05"}));
  EXPECT_NE(first_difference(sharp, seen), "");
  EXPECT_EQ(seen.attributes.at("emberline:f_stop"), "0.05");
  const std::string distance = "3.0413812651491097";  // between (0, 1, 3) and (0, 0.5, 0)
  EXPECT_EQ(
      first_difference(seen, picture(render_words(
                                 view + Words{"--f-stop", "0.05", "--focus-distance", distance}))),
      "");
  EXPECT_NE(
      first_difference(
          seen, picture(render_words(view + Words{"--f-stop", "0.05", "--focus-distance", "1"}))),
      "");
  // A focus distance without an f-stop must have no effect.
  EXPECT_EQ(first_difference(sharp, picture(render_words(view + Words{"--focus-distance", "1"}))),
            "");
  write("shot.json", R"({"emberline_edits": 1, "camera": {"look_from": [0, 1, 3],
      "look_at": [0, 0.5, 0], "fov_y": 40, "f_stop": 0.05}})");
  const Words edits = {"--spp", "16", "--edits", path("shot.json")};
  EXPECT_EQ(first_difference(seen, picture(render_words(edits))), "");
  // The lens from the command line must apply to the view from the edits.
  EXPECT_EQ(first_difference(picture(render_words(view + Words{"--f-stop", "1"})),
                             picture(render_words(edits + Words{"--f-stop", "1"}))),
            "");
  write("shot.json", R"({"emberline_edits": 1, "camera": {"f_stop": 2}})");
  expect_failure(render_words({"--edits", path("shot.json")}), 3,
                 {"shot.json#/camera", "focus_distance"});
}

TEST_F(Views, AnOrthographicCameraKeepsSizes) {
  // The view has 4 x 4 units. At any distance, a square with sides of 1 unit must cover exactly a
  // quarter of the frame's width and height.
  for (const float z : {-1.0f, -50.0f}) {
    GltfBuilder gltf;
    add_quad(gltf, {-0.5f, -0.5f, z}, {1, 0, 0}, {0, 1, 0}, -1);
    gltf.push("cameras",
              {{"type", "orthographic"},
               {"orthographic", {{"xmag", 2}, {"ymag", 2}, {"znear", 0}, {"zfar", 99}}}});
    gltf.add_to_scene(gltf.push("nodes", {{"camera", 0}}));
    gltf.write_glb(path("scene.glb"));
    const ExrPicture seen =
        picture(render_words({"--size", "32x32", "--filter", "box", "--transparent"}));
    EXPECT_EQ(coverage(seen), (Rect{12, 12, 20, 20})) << z;
    for (int y = 0; y < 32; ++y) {
      for (int x = 0; x < 32; ++x) {
        EXPECT_EQ(seen.at("A", x, y), (Rect{12, 12, 20, 20}.contains(x, y) ? 1.0f : 0.0f));
      }
    }
  }
}

// Tests an octahedron that has the normals of a ball and is far from its local origin. It is
// flattened in many ways. The light arrives at 60 degrees to the flat surface's normal, so every
// pixel must have a radiance of 0.5.
class FlatThings : public Views {
 protected:
  FlatThings() {
    std::vector<float> positions, normals;
    std::vector<uint16_t> indices;
    for (const float side : {1.0f, -1.0f}) {
      for (int axis = 0; axis < 3; ++axis) {
        for (int c = 0; c < 3; ++c) {
          normals.push_back(c == axis ? side : 0.0f);
          positions.push_back(3 * normals.back() + (c == 2 ? 7.0f : 0.0f));
        }
      }
    }
    for (uint16_t face = 0; face < 8; ++face) {
      const auto x = uint16_t(face & 1 ? 3 : 0), y = uint16_t(face & 2 ? 4 : 1),
                 z = uint16_t(face & 4 ? 5 : 2);
      const bool mirrored = ((face & 1) + (face >> 1 & 1) + (face >> 2)) % 2 == 1;
      for (const uint16_t v : {x, mirrored ? z : y, mirrored ? y : z}) indices.push_back(v);
    }
    gltf_.push("materials",
               {{"pbrMetallicRoughness", {{"metallicFactor", 0}}},
                {"extensions", {{"KHR_materials_specular", {{"specularFactor", 0}}}}}});
    gltf_.add_mesh({{"attributes",
                     {{"POSITION", gltf_.add_accessor<float>("VEC3", positions)},
                      {"NORMAL", gltf_.add_accessor<float>("VEC3", normals)}}},
                    {"indices", gltf_.add_accessor<uint16_t>("SCALAR", indices)},
                    {"material", 0}});
    gltf_.root["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "directional"}, {"intensity", 3.14159265358979}}};
    gltf_.add_to_scene(
        gltf_.push("nodes", {{"rotation", {-0.5, 0, 0, std::sqrt(0.75)}},
                             {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}}));
    gltf_.push("cameras",
               {{"type", "orthographic"},
                {"orthographic", {{"xmag", 1}, {"ymag", 1}, {"znear", 0}, {"zfar", 99}}}});
    gltf_.add_to_scene(gltf_.push("nodes", {{"camera", 0}, {"translation", {0, 0, 20}}}));
  }
  void add(const GltfBuilder::json& node) { gltf_.add_to_scene(gltf_.push("nodes", node)); }
  void expect_half(const Words& more = {}) {
    gltf_.write_glb(path("scene.glb"));
    const ExrPicture seen = picture(render_words(Words{"--spp", "4", "--max-depth", "3"} + more));
    EXPECT_EQ(result_.err.find("left out"), std::string::npos) << result_.err;
    for (const float value : seen.channels.at("G")) ASSERT_NEAR(value, 0.5f, 1e-5f);
    for (const float value : seen.channels.at("A")) ASSERT_EQ(value, 1.0f);
  }

  GltfBuilder gltf_;
};

TEST_F(FlatThings, AreSeenAtRest) {
  const GltfBuilder without = gltf_;
  add({{"mesh", 0}, {"scale", {1, 1, 0}}});
  expect_half();
  add({{"mesh", 0}, {"scale", {-1, 1, 0}}, {"translation", {0, 0, -1}}});  // a second instance
  expect_half();
  gltf_ = without;
  const int child = gltf_.push("nodes", {{"mesh", 0}, {"rotation", {0.2, 0.4, 0.4, 0.8}}});
  add({{"children", {child}}, {"scale", {2, 2, 0}}, {"translation", {-4, -2, 0}}});
  add({{"children", {gltf_.push("nodes", {{"mesh", 0}})}}, {"scale", {9, 9, 0}}});
  expect_half();
  gltf_ = without;
  add({{"mesh", 0},
       {"extensions",
        {{"EXT_mesh_gpu_instancing",
          {{"attributes",
            {{"SCALE", gltf_.add_accessor<float>("VEC3", {1, 1, 0, 2, 2, 0})},
             {"TRANSLATION", gltf_.add_accessor<float>("VEC3", {0, 0, 0, 0, 0, -1})}}}}}}}});
  expect_half();
}

TEST_F(FlatThings, AreSeenInMotion) {
  add({{"mesh", 0}});
  AnimationBuilder(gltf_).move(2, "scale", {0, 1, 2, 3}, "VEC3",
                               {1, 1, 0, 1, 1, 0, 1, 1, 1, 0, 0, 0});
  expect_half({"--time", "0.5"});
  expect_half({"--time", "0", "--fps", "1", "--shutter", "0,1"});
  expect_half({"--time", "0.5", "--aov", "velocity"});
  // During the first half of this shutter, the octahedron is flat. Then it grows, so only its
  // visibility can be tested.
  gltf_.write_glb(path("scene.glb"));
  const ExrPicture grows =
      picture(render_words({"--spp", "16", "--time", "0.5", "--fps", "1", "--shutter", "0,1"}));
  for (const float value : grows.channels.at("A")) ASSERT_EQ(value, 1.0f);
}

TEST_F(Views, AnOrthographicCameraCanBeSeenFromElsewhere) {
  GltfBuilder gltf;
  add_quad(gltf, {-0.5f, -0.5f, -3}, {1, 0, 0}, {0, 1, 0}, -1);
  gltf.push("cameras", {{"name", "flat"},
                        {"type", "orthographic"},
                        {"orthographic", {{"xmag", 2}, {"ymag", 2}, {"znear", 0}, {"zfar", 99}}}});
  gltf.add_to_scene(gltf.push("nodes", {{"camera", 0}}));
  gltf.write_glb(path("scene.glb"));
  const Words shifted = {"--size",        "32x32",       "--filter", "box",
                         "--transparent", "--camera",    "flat",     "--look-at",
                         "1,0,0",         "--look-from", "1,0,20"};
  EXPECT_EQ(coverage(picture(render_words(shifted))), (Rect{4, 12, 12, 20}));
  // An angle requests a perspective camera. At a distance of 23, an angle of 2 atan(2 / 23) shows
  // the same part of the scene.
  const Words angle = {"--fov-y", "9.93920"};
  EXPECT_EQ(coverage(picture(render_words(shifted + angle))), (Rect{4, 12, 12, 20}));
  write("shot.json", R"({"emberline_edits": 1, "camera": {"look_from": [1, 0, 20],
      "look_at": [1, 0, 0], "orthographic_height": 4, "mirrored": true}})");
  const Words edits = {"--size",        "32x32",   "--filter",       "box",
                       "--transparent", "--edits", path("shot.json")};
  EXPECT_EQ(coverage(picture(render_words(edits))), (Rect{20, 12, 28, 20}));
}

TEST_F(Views, CameraFromTheCommandLine) {
  // The camera looks straight down, so any direction may be up. The floor must fill the frame.
  const ExrPicture above =
      picture(render_words({"--look-from", "0,1,0", "--look-at", "0,0,0", "--fov-y", "60"}));
  EXPECT_EQ(coverage(above), (Rect{0, 0, 16, 16}));
  // Negative coordinates must be read as values and not as options.
  const ExrPicture below = picture(
      render_words({"--look-from", "-1,-1,-1", "--look-at", "-1,-5,-1.5", "--transparent"}));
  EXPECT_TRUE(coverage(below).empty());
}

TEST_F(Views, BackfacesAreCulledByDefault) {
  const Words from_below = {"--look-from", "0,-3,0.1", "--look-at", "0,0,0", "--transparent"};
  unlit_scene().write_glb(path("scene.glb"));
  EXPECT_TRUE(coverage(picture(render_words(from_below))).empty());
  EXPECT_TRUE(coverage(picture(render_words(from_below + Words{"--backfaces", "cull"}))).empty());
  EXPECT_FALSE(coverage(picture(render_words(from_below + Words{"--backfaces", "show"}))).empty());
}

TEST_F(Views, LenientReplacesAnImageThatDoesNotDecode) {
  GltfBuilder gltf = lamp_scene();
  const std::string text = "this is no PNG, whatever it says";
  const int image = gltf.push("images", {{"bufferView", gltf.add_view(text.data(), text.size())},
                                         {"mimeType", "image/png"},
                                         {"name", "wood"}});
  const int texture = gltf.push("textures", {{"source", image}});
  gltf.root["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = texture;
  gltf.write_glb(path("scene.glb"));
  expect_failure(render_words(), 3, {"scene.glb", "images/0"});
  const ExrPicture seen =
      picture(render_words({"--lenient", "--spp", "4", "--report", path("r.json")}));
  EXPECT_NE(result_.err.find("warning"), std::string::npos) << result_.err;
  EXPECT_EQ(read_json("r.json")["numerics"]["replaced_images"], 1);
  EXPECT_GT(mean(seen.channels.at("R")), 0.0);
  EXPECT_EQ(run({"info", scene(), "--lenient"}).exit_code, 0);
  expect_failure({"info", scene()}, 3, {"scene.glb"});
}

TEST_F(Views, AnEnvironmentIsSeenScaledAndTurned) {
  // The +X half of the sky (u in [0.25, 0.75], centred on u = 0.5) is red. The other half is blue.
  std::vector<float> texels;
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 32; ++x) {
      const bool red = x >= 8 && x < 24;
      for (const float value : {red ? 0.5f : 0.0f, 0.0f, red ? 0.0f : 0.5f})
        texels.push_back(value);
    }
  }
  write_floats(path("sky.exr"), 32, 16, 3, texels);
  const auto towards = [&](const char* at, const Words& more) {
    return picture(render_words(
        Words{"--env", path("sky.exr"), "--look-from", "0,9,0", "--look-at", at, "--fov-y", "10"} +
        more));
  };
  EXPECT_EQ(towards("9,9,0", {}).at("R", 8, 8), 0.5f);
  EXPECT_EQ(towards("-9,9,0", {}).at("B", 8, 8), 0.5f);
  EXPECT_EQ(towards("9,9,0", {"--env-strength", "4"}).at("R", 8, 8), 2.0f);
  // --env-rotation 90 must move the part of the sky at +X to -Z.
  EXPECT_EQ(towards("0,9,-9", {"--env-rotation", "90"}).at("R", 8, 8), 0.5f);
  EXPECT_EQ(towards("0,9,9", {"--env-rotation", "90"}).at("B", 8, 8), 0.5f);
}

}  // namespace
}  // namespace emberline::test
