// Tests unusable input. The command must exit with 3 and print one line that names the file. It
// must not write anything or crash.
//
// For each kind of damage, this file tests the whole command with one scene. tests/failure tests
// more variants of the damage, but only with the loader.
#include <cmath>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>

#include "cli/command_test.h"
#include "support/embedded_images.h"

namespace emberline::test {
namespace {

class BadInput : public CommandTest {
 protected:
  void expect_refused(const std::string& file, const Words& message_parts) {
    SCOPED_TRACE(file);
    const std::string name = std::filesystem::path(file).filename().string();
    expect_failure({"render", file, "-o", path("out.exr"), "-o", path("out.png"), "--size", "8x8",
                    "--spp", "1", "--report", path("r.json")},
                   3, Words{name} + message_parts);
    expect_failure({"info", file}, 3, Words{name} + message_parts);
  }
};

struct Damage {
  const char* name;
  Words message_parts;
  std::function<void(GltfBuilder&)> apply;
};

void PrintTo(const Damage& damage, std::ostream* out) { *out << damage.name; }

class DamagedScene : public BadInput, public ::testing::WithParamInterface<Damage> {};

TEST_P(DamagedScene, IsRefused) {
  GltfBuilder gltf = lamp_scene();
  GetParam().apply(gltf);
  expect_refused(gltf.write_gltf(path(std::string(GetParam().name) + ".gltf")),
                 GetParam().message_parts);
}

// Returns the accessor of the positions, which every picture needs.
nlohmann::json& positions(GltfBuilder& g) {
  return g.root["accessors"][g.primitive(0)["attributes"]["POSITION"].get<size_t>()];
}

const std::vector<Damage>& damages() {
  static const std::vector<Damage> list = {
      {"required_extension",
       {"KHR_made_up_lights"},
       [](GltfBuilder& g) {
         g.root["extensionsRequired"] = {"KHR_made_up_lights"};
         g.root["extensionsUsed"] = {"KHR_made_up_lights"};
       }},
      {"no_geometry", {}, [](GltfBuilder& g) { g.root["meshes"] = nlohmann::json::array(); }},
      {"wrong_version", {"version"}, [](GltfBuilder& g) { g.root["asset"]["version"] = "1.0"; }},
      {"no_asset", {"asset"}, [](GltfBuilder& g) { g.root.erase("asset"); }},
      {"wrong_type", {}, [](GltfBuilder& g) { g.root["nodes"] = "none"; }},
      {"accessor_past_buffer",
       {"accessors/"},
       [](GltfBuilder& g) { positions(g)["count"] = 1000; }},
      {"absurd_count", {"accessors/"}, [](GltfBuilder& g) { positions(g)["count"] = 1e18; }},
      {"negative_count", {}, [](GltfBuilder& g) { positions(g)["count"] = -3; }},
      {"buffer_too_short", {}, [](GltfBuilder& g) { g.bin.resize(16); }},
      {"index_past_vertices",
       {},
       [](GltfBuilder& g) {
         g.primitive(0)["indices"] = g.add_accessor<uint16_t>("SCALAR", {0, 1, 9999});
       }},
      {"missing_mesh", {}, [](GltfBuilder& g) { g.root["nodes"][0]["mesh"] = 77; }},
      {"missing_material", {}, [](GltfBuilder& g) { g.primitive(0)["material"] = 77; }},
      {"missing_accessor",
       {},
       [](GltfBuilder& g) { g.primitive(0)["attributes"]["POSITION"] = -1; }},
      {"cyclic_nodes",
       {"nodes"},
       [](GltfBuilder& g) {
         g.root["nodes"][0]["children"] = {1};
         g.root["nodes"][1]["children"] = {0};
       }},
      {"own_child", {"nodes"}, [](GltfBuilder& g) { g.root["nodes"][0]["children"] = {0}; }},
      {"missing_image_file",
       {"wood.png"},
       [](GltfBuilder& g) {
         g.push("images", {{"uri", "wood.png"}});
         g.push("textures", {{"source", 0}});
         g.root["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 0;
       }},
      {"image_does_not_decode",
       {"images/0"},
       [](GltfBuilder& g) {
         std::vector<uint8_t> png = small_png();
         png.resize(png.size() / 2);
         const int texture = add_texture(g, png);
         g.root["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = texture;
       }},
      // libpng must not print a message before ours.
      {"image_with_a_wrong_checksum",
       {"images/0", "CRC"},
       [](GltfBuilder& g) {
         std::vector<uint8_t> png = small_png();
         png[29] ^= 1;  // in the CRC of the header
         const int texture = add_texture(g, png);
         g.root["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = texture;
       }},
  };
  return list;
}
INSTANTIATE_TEST_SUITE_P(Kinds, DamagedScene, ::testing::ValuesIn(damages()),
                         [](const auto& kind) { return std::string(kind.param.name); });

// A scene may cause 20,000 warnings. If all were shown, they would hide every other message.
TEST_F(BadInput, AHundredWarningsAreShown) {
  GltfBuilder gltf = lamp_scene();
  const nlohmann::json mesh = gltf.root["meshes"][0];
  const int materials = int(gltf.root["materials"].size());
  for (int i = 0; i < 150; ++i) {
    gltf.push("images", {{"uri", "missing" + std::to_string(i) + ".png"}});
    gltf.push("textures", {{"source", i}});
    gltf.push("materials", {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", i}}}}}});
    nlohmann::json copy = mesh;
    copy["primitives"][0]["material"] = materials + i;
    gltf.add_mesh_node(gltf.push("meshes", copy));
  }
  const std::string file = gltf.write_gltf(path("many.gltf"));
  const RunResult result = run({"render", file, "-o", path("a.exr"), "--size", "8x8", "--spp", "1",
                                "--lenient", "--report", path("r.json")});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(std::ranges::count_if(
                result.error_lines(),
                [](const std::string& line) { return line.starts_with("emberline: warning: "); }),
            101);
  EXPECT_NE(result.err.find("there are more warnings"), std::string::npos) << result.err;
  EXPECT_GE(read_json("r.json")["warnings"].size(), 150u);
}

TEST_F(BadInput, NamesOfMegabytesAreShortened) {
  const std::string name(3'000'000, 'n');
  const auto expect_short = [&](const Words& words, int code, const std::string& part) {
    const RunResult result = run(words);
    EXPECT_EQ(result.exit_code, code) << result.err.substr(0, 500);
    EXPECT_LT(result.err.size(), 1500u);
    EXPECT_NE(result.err.find(part), std::string::npos) << result.err.substr(0, 500);
  };
  for (const std::string& text : {"{\"" + name + "\": 1}", "{\"sampler\": \"" + name + "\"}",
                                  "{\"spp\": \"" + name + "\"}"}) {
    write("settings.json", text);
    expect_short(render_words({"--settings", path("settings.json")}), 3, "settings.json#/");
  }
  write("settings.json", "{\"camera\": \"" + name + "\"}");
  expect_short(render_words({"--settings", path("settings.json")}), 2, "0 'main'");
  for (const std::string& text :
       {"\"" + name + "\": 1", "\"materials\": [{\"name\": \"" + name + "\"}]",
        "\"lights\": [{\"kind\": \"" + name + "\"}]"}) {
    write("edits.json", "{\"emberline_edits\": 1, " + text + "}");
    expect_short(render_words({"--edits", path("edits.json")}), 3, "edits.json#/");
  }
  // Lists of valid names contain names from the scene, which may also be long.
  GltfBuilder gltf = lamp_scene();
  gltf.root["cameras"][0]["name"] = name;
  const std::string named = gltf.write_gltf(path("named.gltf"));
  expect_short({"render", named, "-o", path("a.png"), "--camera", "none"}, 2, "nnn...'");
  expect_short({"render", named, "-o", path("a.png"), "--camera", name.substr(0, 99'999)}, 2,
               "nnn...'");
}

TEST_F(BadInput, FilesThatAreNotScenes) {
  const std::vector<uint8_t> glb = lamp_scene().glb();
  const auto shortened = [&](size_t size) {
    return std::vector<uint8_t>(glb.begin(), glb.begin() + long(size));
  };
  write_bytes(path("header_only.glb"), shortened(12));
  write_bytes(path("half.glb"), shortened(glb.size() / 2));
  write_bytes(path("one_byte_short.glb"), shortened(glb.size() - 1));
  write_bytes(path("magic_only.glb"), shortened(4));
  write_bytes(path("empty.glb"), shortened(0));
  std::vector<uint8_t> chunk = glb;
  chunk[12] = chunk[13] = chunk[14] = 0xff;  // in the length of the JSON chunk
  write_bytes(path("chunk_too_long.glb"), chunk);
  write("empty.gltf", "");
  write("syntax.gltf", "{\"asset\": {\"version\": \"2.0\"");
  write("array.gltf", "[1, 2, 3]");
  write("text.gltf", "Dear renderer, please find my scene attached.");
  write("deep.gltf", std::string(200000, '['));
  write("picture.gltf", std::string(reinterpret_cast<const char*>(small_png().data()), 20));
  std::filesystem::create_directories(path("folder.glb"));
  for (const char* name :
       {"header_only.glb", "half.glb", "one_byte_short.glb", "magic_only.glb", "empty.glb",
        "chunk_too_long.glb", "empty.gltf", "syntax.gltf", "array.gltf", "text.gltf", "deep.gltf",
        "picture.gltf", "folder.glb", "missing.glb"}) {
    expect_refused(path(name), {});
  }
  expect_failure(render_words({}) + Words{"--env", path("missing.hdr")}, 3, {"missing.hdr"});
}

TEST_F(BadInput, AMissingBufferFileIsNamed) {
  const std::string file = lamp_scene().write_gltf(path("scene.gltf"), "geometry.bin");
  std::filesystem::remove(path("geometry.bin"));
  expect_refused(file, {"geometry.bin"});
}

TEST_F(BadInput, AnUnreadableFile) {
  std::filesystem::permissions(path(""), std::filesystem::perms::all);
  const std::string file = scene();
  std::filesystem::permissions(file, std::filesystem::perms::none);
  expect_failure({"info", file}, 3, {"scene.glb", "ermission"}, {.unprivileged = true});
}

TEST_F(BadInput, RepairsAreCountedAndTheSceneRenders) {
  GltfBuilder gltf = lamp_scene();
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  gltf.add_mesh_node(gltf.add_mesh(
      {{"attributes",
        {{"POSITION", gltf.add_accessor<float>("VEC3", {kNan, 0, 0, 1, 0, 0, 0, 1, 0})}}}}));
  gltf.add_mesh_node(gltf.add_mesh(
      {{"attributes",
        {{"POSITION", gltf.add_accessor<float>("VEC3", {1, 1, 1, 2, 2, 2, 3, 3, 3})}}}}));
  const int line = gltf.push("nodes", {{"mesh", 0}, {"scale", {0, 0, 1}}});
  gltf.add_to_scene(line);
  gltf.write_glb(path("scene.glb"));
  const RunResult result = render(render_words({"--report", path("r.json")}));
  const auto numerics = read_json("r.json")["numerics"];
  EXPECT_EQ(numerics["non_finite_triangles"], 1);
  EXPECT_EQ(numerics["degenerate_triangles"], 1);
  EXPECT_EQ(numerics["singular_instances"], 1);
  EXPECT_EQ(numerics["non_finite_samples"], 0);
  EXPECT_NE(result.err.find("warning"), std::string::npos) << result.err;
  const ExrPicture picture = read_exr(path("out.exr"));
  for (const float value : picture.channels.at("R")) EXPECT_TRUE(std::isfinite(value));
}

TEST_F(BadInput, Environments) {
  scene();
  write("text.hdr", "#?RADIANCE or so it says");
  write("empty.exr", "");
  write("text.exr", "no picture");
  std::vector<float> texels(64 * 32 * 3, 0.5f);
  for (const char* name : {"sky.exr", "sky.hdr"}) {
    write_floats(path(name), 64, 32, 3, texels);
    std::vector<uint8_t> bytes = read_bytes(path(name));
    bytes.resize(bytes.size() / 2);
    write_bytes(path(std::string("cut_") + name), bytes);
  }
  std::filesystem::create_directories(path("folder.hdr"));
  for (const char* name : {"missing.hdr", "text.hdr", "empty.exr", "text.exr", "cut_sky.exr",
                           "cut_sky.hdr", "folder.hdr", "scene.glb"}) {
    expect_failure({"render", scene(), "-o", path("out.exr"), "--size", "8x8", "--spp", "1",
                    "--env", path(name)},
                   3, {name});
  }
}

TEST_F(BadInput, NanTexelsInASkyAreRepairedWithAWarning) {
  std::vector<float> texels(16 * 8 * 3, 0.25f);
  texels[3] = std::numeric_limits<float>::quiet_NaN();
  texels[100] = std::numeric_limits<float>::infinity();
  texels[200] = -1.0f;
  write_floats(path("sky.exr"), 16, 8, 3, texels);
  const RunResult result =
      render(render_words({"--env", path("sky.exr"), "--report", path("r.json"), "--spp", "4"}));
  EXPECT_EQ(read_json("r.json")["numerics"]["non_finite_texels"], 3);
  EXPECT_EQ(read_json("r.json")["numerics"]["non_finite_samples"], 0);
  EXPECT_NE(result.err.find("sky.exr"), std::string::npos) << result.err;
}

}  // namespace
}  // namespace emberline::test
