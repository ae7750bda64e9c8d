// Tests members that are missing, of the wrong type or out of range. The error names each such
// member by its pointer. If the picture does not need the member, a warning does the same.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "failure/bad_input.h"
#include "renderer/core/log.h"
#include "support/embedded_images.h"

namespace emberline {
namespace {

using nlohmann::json;
using test::expect_input_error;
using test::expect_warning;
using test::GltfBuilder;
using test::TempFolder;

// Returns a scene with one of everything, so that any member can be spoiled. If `in_use`, the
// picture needs everything in the scene, and the extensions are required.
GltfBuilder rich_scene(bool in_use = false) {
  GltfBuilder gltf;
  gltf.add_triangle();
  gltf.push("samplers", {{"wrapS", 10497}});
  const int texture = test::add_texture(gltf, test::small_png());
  gltf.root["textures"][0]["sampler"] = 0;
  gltf.push("materials", {{"pbrMetallicRoughness", {{"metallicFactor", 0.5}}},
                          {"emissiveTexture", {{"index", texture}}}});
  gltf.push("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1.0}, {"znear", 0.1}}}});
  gltf.push("skins", {{"joints", {0}}});
  gltf.root["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
  gltf.root["scene"] = 0;
  if (!in_use) return gltf;
  gltf.primitive()["material"] = 0;
  gltf.primitive()["attributes"]["TEXCOORD_0"] =
      gltf.add_accessor<float>("VEC2", {0, 0, 1, 0, 0, 1});
  json& node = gltf.root["nodes"][0];
  node["skin"] = 0;
  node["extensions"]["KHR_lights_punctual"]["light"] = 0;
  gltf.root["extensionsRequired"] = {"EXT_texture_webp",       "KHR_draco_mesh_compression",
                                     "KHR_lights_punctual",    "KHR_materials_ior",
                                     "KHR_materials_specular", "KHR_materials_transmission",
                                     "KHR_materials_volume"};
  return gltf;
}

// Says when the picture needs the spoiled member: always, only in rich_scene(true), or never.
enum class Needed { kAlways, kInUse, kNever };
struct BrokenValue {
  const char* pointer;
  json value;
  Needed needed = Needed::kAlways;
};

std::vector<BrokenValue> broken_values() {
  using enum Needed;
  return {
      {"/asset", 1},
      {"/asset/version", 2},
      {"/asset/generator", 2, kNever},
      {"/scene", "first"},
      {"/scene", 3},
      {"/scene", 0.5},
      {"/scenes", json::object()},
      {"/scenes/0", 1},
      {"/scenes/0/nodes", 0},
      {"/scenes/0/nodes/0", 99},
      {"/scenes/0/nodes/0", -1},
      {"/scenes/0/nodes/0", "0"},
      {"/scenes/0/name", 1, kNever},
      {"/nodes", json::object()},
      {"/nodes/0/mesh", 1},
      {"/nodes/0/skin", 7},
      {"/nodes/0/name", 5, kNever},
      {"/nodes/0/matrix", {1, 2, 3}},
      {"/nodes/0/translation", {1, 2}},
      {"/nodes/0/translation", {1, 2, 3, 4}},
      {"/nodes/0/rotation", {0, 0, 1}},
      {"/nodes/0/scale", "big"},
      {"/nodes/0/scale/1", nullptr},
      {"/nodes/0/children", {99}},
      {"/nodes/0/weights", {true}},
      {"/nodes/0/extensions", 1},
      {"/nodes/0/extensions/KHR_lights_punctual/light", 9, kInUse},
      {"/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes/TRANSLATION", 99},
      {"/meshes", "mesh"},
      {"/meshes/0/primitives/0", json::array()},
      {"/meshes/0/primitives/0/attributes", json::array()},
      {"/meshes/0/primitives/0/attributes/POSITION", 44},
      {"/meshes/0/primitives/0/attributes/A~1B", 44, kNever},
      {"/meshes/0/primitives/0/mode", 7},
      {"/meshes/0/primitives/0/mode", 1.5},
      {"/meshes/0/primitives/0/targets", json::object()},
      {"/meshes/0/primitives/0/targets/0/POSITION", 44, kNever},  // its weight is 0
      {"/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression", 1, kInUse},
      {"/accessors/0/count", 0},
      {"/accessors/0/count", -5},
      {"/accessors/0/count", 2.5},
      {"/accessors/0/count", "3"},
      {"/accessors/0/componentType", 5124},
      {"/accessors/0/componentType", 99999999999},
      {"/accessors/0/type", "VEC5"},
      {"/accessors/0/normalized", 1},
      {"/accessors/0/byteOffset", -4},
      {"/accessors/0/sparse", 1},
      {"/bufferViews/0/byteStride", 0},
      {"/bufferViews/0/byteLength", -1},
      {"/buffers/0/byteLength", "many"},
      {"/buffers/0/uri", 3},
      {"/images/0/bufferView", 99, kInUse},
      {"/images/0/mimeType", 1, kNever},
      {"/textures", "texture", kInUse},
      {"/textures/0/source", 99, kInUse},
      {"/textures/0/sampler", 99, kInUse},
      {"/textures/0/extensions/EXT_texture_webp/source", 99, kInUse},
      {"/samplers/0/wrapS", "repeat", kInUse},
      {"/samplers/0/wrapS", 7, kInUse},
      {"/materials", "material", kInUse},
      {"/materials/0/pbrMetallicRoughness", 1, kInUse},
      {"/materials/0/pbrMetallicRoughness/baseColorFactor", {1, 1, 1}, kInUse},
      {"/materials/0/pbrMetallicRoughness/metallicFactor", "full", kInUse},
      {"/materials/0/normalTexture/index", 99, kInUse},
      {"/materials/0/occlusionTexture/index", 99, kNever},
      {"/materials/0/emissiveTexture/texCoord", -1, kInUse},
      {"/materials/0/emissiveTexture/texCoord", 1000000, kInUse},
      {"/materials/0/emissiveFactor", {1}, kInUse},
      {"/materials/0/alphaMode", 1, kInUse},
      {"/materials/0/alphaCutoff", -1, kInUse},
      {"/materials/0/doubleSided", "yes", kInUse},
      {"/materials/0/extensions/KHR_materials_ior/ior", "high", kInUse},
      {"/materials/0/extensions/KHR_materials_specular/specularFactor", "full", kInUse},
      {"/materials/0/extensions/KHR_materials_transmission/transmissionFactor", {1}, kInUse},
      {"/materials/0/extensions/KHR_materials_transmission/transmissionTexture/index", 99, kInUse},
      {"/materials/0/extensions/KHR_materials_volume/attenuationColor", {1, 1}, kInUse},
      {"/materials/0/extensions/KHR_materials_volume/attenuationDistance", "far", kInUse},
      {"/cameras", 1, kNever},
      {"/cameras/0/type", 1, kNever},
      {"/cameras/0/type", "pinhole", kNever},
      {"/cameras/0/perspective", 1, kNever},
      {"/cameras/0/perspective/yfov", "wide", kNever},
      {"/skins", 1, kInUse},
      {"/skins/0/joints", {99}, kInUse},
      {"/skins/0/joints", json::array(), kInUse},
      {"/skins/0/skeleton", 99, kNever},
      {"/skins/0/inverseBindMatrices", 99, kInUse},
      {"/extensions/KHR_lights_punctual/lights", 1, kInUse},
      {"/extensions/KHR_lights_punctual/lights/0/type", "tube", kInUse},
      {"/extensions/KHR_lights_punctual/lights/0/color", {1, 1}, kInUse},
      {"/extensions/KHR_lights_punctual/lights/0/intensity", -1, kInUse},
      {"/extensionsUsed", "all", kNever},
      {"/extensionsRequired", {1}},
      {"/animations", 1, kNever},
      {"/animations/0", 1, kNever},
  };
}

TEST(BadJson, WrongTypesAndRanges) {
  const TempFolder folder;
  for (const bool in_use : {false, true}) {
    const GltfBuilder good = rich_scene(in_use);
    const SceneDescription scene = load_gltf(good.write_gltf(folder / "good.gltf"), {});
    EXPECT_TRUE(scene.coverage.ignored.empty()) << scene.coverage.ignored.front();
    for (const BrokenValue& broken : broken_values()) {
      json document = good.document("data.bin");
      const std::string text = broken.pointer;
      document[json::json_pointer(text)] = broken.value;
      test::write_text(folder / "a.gltf", document.dump());
      // The message may name the member itself, its contents or its parent.
      const std::string place = "a.gltf#" + text.substr(0, std::max(text.rfind('/'), size_t(1)));
      SCOPED_TRACE(text + " = " + broken.value.dump() + (in_use ? ", in use" : ""));
      if (broken.needed == Needed::kAlways || (in_use && broken.needed == Needed::kInUse)) {
        expect_input_error(folder / "a.gltf", {place});
      } else {
        EXPECT_EQ(expect_warning(folder / "a.gltf", {place}).instances.size(), 1u);
      }
    }
  }
}

TEST(BadJson, RequiredMembers) {
  const std::pair<const char*, Needed> cases[] = {
      {"/asset", Needed::kAlways},
      {"/asset/version", Needed::kAlways},
      {"/meshes/0/primitives", Needed::kAlways},
      {"/meshes/0/primitives/0/attributes", Needed::kAlways},
      {"/accessors/0/count", Needed::kAlways},
      {"/accessors/0/componentType", Needed::kAlways},
      {"/accessors/0/type", Needed::kAlways},
      {"/bufferViews/0/buffer", Needed::kAlways},
      {"/bufferViews/0/byteLength", Needed::kAlways},
      {"/buffers/0/byteLength", Needed::kAlways},
      {"/cameras/0/type", Needed::kNever},
      {"/cameras/0/perspective", Needed::kNever},
      {"/cameras/0/perspective/yfov", Needed::kNever},
      {"/cameras/0/perspective/znear", Needed::kNever},
      {"/skins/0/joints", Needed::kInUse},
      {"/extensions/KHR_lights_punctual/lights/0/type", Needed::kInUse}};
  const TempFolder folder;
  for (const bool in_use : {false, true}) {
    const GltfBuilder good = rich_scene(in_use);
    good.write_gltf(folder / "good.gltf");
    for (const auto& [pointer, needed] : cases) {
      json document = good.document("data.bin");
      const json::json_pointer place(pointer);
      document[place.parent_pointer()].erase(place.back());
      test::write_text(folder / "a.gltf", document.dump());
      const std::string words = "the required member \"" + place.back() + "\" is missing";
      SCOPED_TRACE(pointer);
      if (needed == Needed::kAlways || (in_use && needed == Needed::kInUse)) {
        expect_input_error(folder / "a.gltf", {words});
      } else {
        expect_warning(folder / "a.gltf", {words});
      }
    }
  }
}

TEST(BadJson, WholeNumbersMayBeWrittenWithAFraction) {
  const TempFolder folder;
  json document = rich_scene().document("data.bin");
  rich_scene().write_gltf(folder / "good.gltf");
  document["scene"] = 0.0;
  document["nodes"][0]["mesh"] = 0.0;
  document["accessors"][0]["count"] = 3.0;
  std::string text = document.dump();
  text.replace(text.find("\"count\":3.0"), 11, "\"count\":0.3e1");
  test::write_text(folder / "a.gltf", text);
  EXPECT_EQ(load_gltf(folder / "a.gltf", {}).meshes.size(), 1u);
}

TEST(BadJson, VersionsThatAreNotTwo) {
  const std::pair<const char*, const char*> cases[] = {
      {"1.0", "glTF 1.0 is not supported"}, {"3.0", "glTF 3.0 is not supported"},
      {"2", "expected a version"},          {"two", "expected a version"},
      {"2.", "expected a version"},         {"99999999999999.0", "expected a version"}};
  for (const auto& [version, expected] : cases) {
    GltfBuilder gltf = rich_scene();
    gltf.root["asset"]["version"] = version;
    expect_input_error(gltf, {"#/asset/version: ", expected});
  }
  GltfBuilder gltf = rich_scene();
  gltf.root["asset"]["version"] = "2.7";  // minor versions are compatible
  EXPECT_NO_THROW(load_gltf(gltf.write_glb(TempFolder() / "a.glb"), {}));
  gltf.root["asset"]["minVersion"] = "2.7";
  expect_input_error(gltf, {"#/asset/minVersion: "});
}

TEST(BadJson, InvalidJson) {
  const TempFolder folder;
  const std::pair<std::string, std::string> cases[] = {
      {"PK\x03\x04zip", "not a glTF file"},
      {"   \n ", "not a glTF file"},
      {"[1, 2]", "not a glTF file"},
      {"\x89PNG\r\n\x1a\n", "not a glTF file"},
      {"{\"asset\": {\"version\": \"2.0\"", "not valid JSON"},
      {"{\"asset\": {\"version\": \"2.0\"}} trailing", "not valid JSON"},
      {"{\"asset\": {\"version\": \"\xff\xfe\"}}", "#/asset/version: not valid JSON"},
      {"{\"nodes\": [{}, {\"mesh\": }]}", "#/nodes/1/mesh: not valid JSON"},
      {"{\"nodes\": [NaN]}", "#/nodes/0: not valid JSON"},
      {"{}", "\"asset\" is missing"},
      {std::string("{\0}", 3), "not valid JSON"},
  };
  for (const auto& [text, expected] : cases) {
    test::write_text(folder / "a.gltf", text);
    expect_input_error(folder / "a.gltf", {expected});
  }
}

// Files with duplicate members exist. A reader that takes the first member and a reader that takes
// the last would see different scenes.
TEST(BadJson, DuplicateMembersGiveAWarning) {
  const TempFolder folder;
  std::string text = rich_scene().document("data.bin").dump();
  rich_scene().write_gltf(folder / "good.gltf");
  const size_t at = text.find("\"scene\":0");
  ASSERT_NE(at, std::string::npos);
  text.insert(at, "\"scene\":99,");
  test::write_text(folder / "a.gltf", text);
  EXPECT_EQ(load_gltf(folder / "a.gltf", {}).meshes.size(), 1u);
  const std::vector<std::string> warnings = warnings_so_far();
  EXPECT_EQ(
      std::ranges::count(
          warnings,
          folder / "a.gltf#/scene: the member appears twice in one object; the last one is used"),
      1);
}

TEST(BadJson, DeeplyNestedJsonIsRefused) {
  const TempFolder folder;
  std::string text = "{\"asset\":{\"version\":\"2.0\"},\"extras\":";
  text += std::string(1000000, '[') + std::string(1000000, ']') + "}";
  test::write_text(folder / "a.gltf", text);
  expect_input_error(folder / "a.gltf", {"nested deeper than"});
}

}  // namespace
}  // namespace emberline
