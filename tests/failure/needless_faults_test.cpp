// A fault in a part that the picture does not need, or in an optional extension, gives a warning
// with file and JSON pointer, and the picture. The same fault in a needed part gives one line of
// errors and no picture.
#include <cstring>
#include <ctime>
#include <nlohmann/json.hpp>

#include "failure/bad_input.h"
#include "support/compressed_gltf.h"
#include "support/embedded_images.h"
#include "support/sanitized.h"

namespace emberline {
namespace {

using nlohmann::json;
using test::expect_input_error;
using test::expect_warning;
using test::GltfBuilder;
using test::TempFolder;

class NeedlessFault : public testing::Test {
 protected:
  NeedlessFault() { gltf_.add_triangle(); }

  SceneDescription warned(const std::vector<std::string>& parts, const GltfOptions& options = {}) {
    SceneDescription scene = expect_warning(gltf_, parts, options);
    EXPECT_FALSE(scene.instances.empty());
    return scene;
  }
  void refused(const std::vector<std::string>& parts, const GltfOptions& options = {}) {
    expect_input_error(gltf_, parts, options);
  }
  json& node(int i = 0) { return gltf_.root["nodes"][size_t(i)]; }
  // Adds a node outside every scene.
  int add_outside(const json& object) { return gltf_.push("nodes", object); }
  void require_extension(const char* name) { gltf_.root["extensionsRequired"] = {name}; }

  TempFolder folder_;
  GltfBuilder gltf_;
};

// ---- the graph

TEST_F(NeedlessFault, ASecondSceneAndItsNodes) {
  gltf_.push("scenes", {{"nodes", {77}}});
  warned({"#/scenes/1/nodes/0: index 77 is out of range", "it is not used"});
  gltf_.root["scene"] = 1;
  refused({"#/scenes/1/nodes/0: index 77 is out of range"});
}

TEST_F(NeedlessFault, NodesOutsideTheScene) {
  const int outside = add_outside({{"mesh", 5}});
  warned({"#/nodes/1/mesh: index 5 is out of range"});
  gltf_.add_to_scene(outside);
  refused({"#/nodes/1/mesh: index 5 is out of range"});
}

TEST_F(NeedlessFault, CyclesOutsideTheScene) {
  add_outside({{"children", {2}}});
  add_outside({{"children", {1}}});
  warned({"#/nodes/", "a cycle of nodes"});
  // With all nodes listed, loading must end as well.
  const SceneDescription scene = warned({"a cycle of nodes"}, {.nodes = true});
  ASSERT_EQ(scene.nodes.size(), 3u);
  EXPECT_EQ(scene.nodes[1].root, 1);
  EXPECT_EQ(scene.nodes[1].parent, -1);
  add_outside({{"children", {3}}});
  warned({"#/nodes/3/children/0: node 3 is its own child", "(and 1 more like it)"});
  node()["children"] = {1};
  refused({"#/nodes/"});
}

TEST_F(NeedlessFault, ParentsOutsideTheScene) {
  const int child = add_outside(json::object());
  node()["children"] = {child};
  add_outside({{"children", {child}}});
  warned({"#/nodes/2/children/0: node 1 already has another parent, node 0"});
  // Two parents outside the scene leave the joint's transform undefined.
  node().erase("children");
  add_outside({{"children", {child}}});
  gltf_.push("skins", {{"joints", {child}}});
  warned({"#/nodes/3/children/0: node 1 already has another parent, node 2"});
  node()["skin"] = 0;
  refused({"#/nodes/3/children/0: node 1 already has another parent, node 2"});
}

TEST_F(NeedlessFault, TransformsOutsideTheScene) {
  const int outside = add_outside({{"translation", {1e30, 0, 0}}, {"children", {2}}});
  add_outside({{"mesh", 0}});
  warned({"#/nodes/1: the node's world transform"});
  gltf_.add_to_scene(outside);
  refused({"#/nodes/1: the node's world transform"});
}

// In a chain of nodes outside the scene, where each node lists its child twice, there are 2^n paths
// to the end.
TEST_F(NeedlessFault, ChildrenListedTwiceAreFollowedOnce) {
  for (int i = 0; i < 200; ++i) add_outside({{"children", {i + 2, i + 2}}});
  add_outside(json::object());
  warned({"#/nodes/1/children/1: node 2 is listed twice", "(and 199 more like it)"});
}

TEST_F(NeedlessFault, FaultsAreNamedIfNothingIsLeft) {
  gltf_.push("scenes", {{"nodes", {77}}});
  gltf_.root["scenes"][0]["nodes"] = json::array();
  refused({": no geometry to render; the first error is: ", "#/scenes/1/nodes/0: index 77"});
}

// ---- meshes, skins, materials

TEST_F(NeedlessFault, UnusedMeshesAndSkins) {
  gltf_.push("meshes", {{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"indices", 9}}}}});
  warned({"#/meshes/1/primitives/0/indices: index 9 is out of range"});
  gltf_.add_mesh_node(1);
  refused({"#/meshes/1/primitives/0/indices: index 9 is out of range"});
}

TEST_F(NeedlessFault, UnreadAttributes) {
  json& attributes = gltf_.primitive()["attributes"];
  for (const char* name : {"TANGENT", "COLOR_1", "TEXCOORD_0", "TEXCOORD_3", "JOINTS_0", "_ID"}) {
    attributes[name] = 99;
    warned({"#/meshes/0/primitives/0/attributes/", "index 99 is out of range"});
    attributes.erase(name);
  }
  for (const char* name : {"NORMAL", "COLOR_0"}) {
    attributes[name] = 99;
    refused({std::string("#/meshes/0/primitives/0/attributes/") + name + ": index 99"});
    attributes.erase(name);
  }
}

TEST_F(NeedlessFault, MorphTargetsWithZeroWeight) {
  gltf_.primitive()["targets"] = {{{"POSITION", 0}}, {{"POSITION", 99}}};
  gltf_.root["meshes"][0]["weights"] = {0.5, 0.0};
  warned({"#/meshes/0/primitives/0/targets/1/POSITION: index 99 is out of range"});
  gltf_.root["meshes"][0]["weights"] = {0.5, 0.5};
  refused({"#/meshes/0/primitives/0/targets/1/POSITION: index 99 is out of range"});
}

TEST_F(NeedlessFault, AccessorsViewsAndBuffers) {
  gltf_.push("buffers", json::object());
  gltf_.push("buffers", {{"uri", "no.bin"}, {"byteLength", 16}});
  gltf_.push("bufferViews", {{"buffer", 1}, {"byteLength", 16}});
  gltf_.push("accessors",
             {{"bufferView", 2}, {"componentType", 5121}, {"count", 3}, {"type", "SCALAR"}});
  gltf_.push("accessors",
             {{"bufferView", 0}, {"componentType", 5126}, {"count", 900}, {"type", "VEC3"}});
  // Faults that follow from a broken buffer are not reported again.
  const SceneDescription scene = warned({"#/buffers/1/uri: file not found", "it is not used"});
  EXPECT_EQ(scene.coverage.ignored.size(), 2u);
  warned({"#/accessors/3: 900 elements"});
  gltf_.primitive()["indices"] = 2;
  refused({"#/buffers/1/uri: file not found"});
  gltf_.primitive() = {{"attributes", {{"POSITION", 3}}}};
  refused({"#/accessors/3: 900 elements"});
}

TEST_F(NeedlessFault, TexturesWithoutAnImage) {
  gltf_.push("textures", json::object());
  gltf_.push("textures", {{"source", 4}});
  warned({"#/textures/1/source: index 4 is out of range"});
  gltf_.push("materials", {{"normalTexture", {{"index", 0}}}});
  gltf_.push("materials", {{"normalTexture", {{"index", 1}}}});
  warned({"#/textures/0: the texture of /materials/0/normalTexture has no image"});
  gltf_.primitive()["material"] = 0;
  refused({"#/textures/0: the texture of /materials/0/normalTexture has no image"});
  gltf_.primitive()["material"] = 1;
  refused({"#/textures/1/source: index 4 is out of range"});
}

TEST_F(NeedlessFault, LenientReplacesAMissingImage) {
  gltf_.push("images", {{"uri", "gone.png"}});
  gltf_.push("textures", {{"source", 0}});
  gltf_.push("materials", {{"normalTexture", {{"index", 0}}}});
  EXPECT_TRUE(load_gltf(gltf_.write_glb(folder_ / "a.glb"), {}).images.empty());
  gltf_.primitive()["material"] = 0;
  refused({"#/images/0/uri: file not found"});
  const SceneDescription scene =
      warned({"#/images/0/uri: file not found", "neutral"}, {.lenient = true});
  EXPECT_EQ(scene.repairs.replaced_images, 1u);
  const Image& neutral = *scene.images.at(size_t(scene.materials[0].normal_texture.image));
  EXPECT_EQ(neutral.texels.at(2), std::byte(255));
  EXPECT_EQ(neutral.texels.at(0), std::byte(128));
}

// ---- cameras, lights, animations

TEST_F(NeedlessFault, CamerasCarryTheirFault) {
  const json lens = {{"yfov", 0.8}, {"znear", 0.1}};
  gltf_.push("cameras", {{"type", "perspective"}, {"perspective", lens}});
  gltf_.push("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 0}, {"znear", 1}}}});
  gltf_.push("cameras", {{"type", "pinhole"}, {"name", "odd"}});
  for (const int camera : {0, 1, 2, 3}) {
    gltf_.add_to_scene(gltf_.push("nodes", {{"camera", camera}, {"name", "here"}}));
  }
  const SceneDescription scene = load_gltf(gltf_.write_glb(folder_ / "a.glb"), {});
  ASSERT_EQ(scene.cameras.size(), 4u);  // so that indices match the file
  EXPECT_FALSE(scene.cameras[0].fault);
  const char* const faults[] = {"a.glb#/cameras/1/perspective/yfov: expected an angle",
                                "a.glb#/cameras/2/type: unknown type \"pinhole\"",
                                "a.glb#/nodes/4/camera: index 3 is out of range"};
  for (size_t i = 1; i < 4; ++i) {
    ASSERT_TRUE(scene.cameras[i].fault);
    EXPECT_NE(std::string(scene.cameras[i].fault->what()).find(faults[i - 1]), std::string::npos)
        << scene.cameras[i].fault->what();
  }
}

TEST_F(NeedlessFault, LightsAreOptional) {
  json& lights = gltf_.root["extensions"]["KHR_lights_punctual"]["lights"];
  lights = {{{"type", "point"}}, {{"type", "tube"}}};
  const std::string fault = "#/extensions/KHR_lights_punctual/lights/1/type: unknown type";
  warned({fault, "it is not used"});
  for (const int light : {0, 1, 2}) {
    gltf_.add_to_scene(
        gltf_.push("nodes", {{"extensions", {{"KHR_lights_punctual", {{"light", light}}}}}}));
  }
  EXPECT_EQ(warned({fault}).lights.size(), 1u);
  EXPECT_EQ(warned({"#/nodes/3/extensions/KHR_lights_punctual/light: index 2"}).lights.size(), 1u);
  require_extension("KHR_lights_punctual");
  refused({fault});
  gltf_.root["scenes"][0]["nodes"].erase(2);
  refused({"#/nodes/3/extensions/KHR_lights_punctual/light: index 2"});
}

TEST_F(NeedlessFault, Animations) {
  gltf_.root["animations"] = {3, {{"name", 5}}, {{"channels", {{{"target", {{"node", 99}}}}}}}};
  warned({"#/animations/0: expected an object, found 3"});
  warned({"#/animations/1/name: expected a string, found 5", "it is left out"});
}

// ---- optional extensions

TEST_F(NeedlessFault, VariantsWithMissingMaterials) {
  gltf_.push("materials", {{"name", "own"}});
  gltf_.push("materials", {{"alphaMode", "TORN"}});
  gltf_.root["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "a"}}, {{"name", 1}}};
  gltf_.primitive()["material"] = 0;
  gltf_.primitive()["extensions"]["KHR_materials_variants"]["mappings"] = {
      {{"material", 7}, {"variants", {0}}}, {{"material", 1}, {"variants", {1}}}};
  const std::string place = "#/meshes/0/primitives/0/extensions/KHR_materials_variants/mappings/0";
  for (const bool asked : {false, true}) {
    const GltfOptions options = {.variants = asked};
    const SceneDescription scene = warned({place + "/material: index 7 is out of range"}, options);
    EXPECT_EQ(scene.variants.size(), 2u);
    EXPECT_EQ(scene.meshes[0].material, 0);
    EXPECT_TRUE(scene.meshes[0].variant_materials.empty());
    warned({"#/materials/1/alphaMode: unknown"}, options);
    warned({"#/extensions/KHR_materials_variants/variants/1/name: "}, options);
  }
  json& mappings = gltf_.primitive()["extensions"]["KHR_materials_variants"]["mappings"];
  const json before = mappings;
  mappings = {{{"material", 0}, {"variants", {0}}}, {{"material", 0}, {"variants", {0}}}};
  const std::string twice = "KHR_materials_variants/mappings: variant 0 has two materials";
  EXPECT_TRUE(warned({twice}, {.variants = true}).meshes[0].variant_materials.empty());
  mappings = before;
  require_extension("KHR_materials_variants");
  warned({place + "/material: index 7 is out of range"});
  refused({place + "/material: index 7 is out of range"}, {.variants = true});
  mappings.erase(0);
  refused({"#/materials/1/alphaMode: unknown"}, {.variants = true});
}

// Numbers out of range get their defaults; the rest of the extension is kept.
TEST_F(NeedlessFault, NumbersOutOfRangeInOptionalExtensions) {
  gltf_.push("materials", json::object());
  gltf_.primitive()["material"] = 0;
  json& extensions = gltf_.root["materials"][0]["extensions"];
  extensions = {{"KHR_materials_emissive_strength", {{"emissiveStrength", 3e38}}},
                {"KHR_materials_iridescence", {{"iridescenceIor", 0}, {"iridescenceFactor", 1}}},
                {"KHR_materials_clearcoat",
                 {{"clearcoatFactor", 0.5}, {"clearcoatTexture", {{"index", 9}}}}}};
  gltf_.root["materials"][0]["emissiveFactor"] = {2, 2, 2};
  const std::string place = "#/materials/0/extensions/KHR_materials_";
  const MaterialDescription material =
      warned({place + "emissive_strength/emissiveStrength: the emission is not finite"})
          .materials[0];
  EXPECT_EQ(material.emission, Rgb(2.0f));
  EXPECT_EQ(material.iridescence, 1.0f);
  EXPECT_EQ(material.iridescence_ior, 1.3f);
  EXPECT_EQ(material.clearcoat, 0.5f);
  warned({place + "iridescence/iridescenceIor: expected an index of refraction", "left out"});
  warned({place + "clearcoat/clearcoatTexture/index: index 9 is out of range", "left out"});
  require_extension("KHR_materials_iridescence");
  refused({place + "iridescence/iridescenceIor: expected an index of refraction"});
  gltf_.root.erase("extensionsRequired");
  extensions.erase("KHR_materials_iridescence");

  json& light = gltf_.root["extensions"]["KHR_lights_punctual"]["lights"][0];
  light = {{"type", "spot"}, {"intensity", 5}, {"spot", {{"innerConeAngle", -1}}}};
  gltf_.add_to_scene(
      gltf_.push("nodes", {{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}}));
  const std::string lamp = "#/extensions/KHR_lights_punctual/lights/0";
  for (const double range : {0.0, -1.0, 1e40}) {
    light["range"] = range;
    const SceneDescription scene = warned({lamp + "/range: the number"});
    ASSERT_EQ(scene.lights.size(), 1u);
    EXPECT_EQ(scene.lights[0].range, std::numeric_limits<float>::infinity());
    EXPECT_EQ(scene.lights[0].inner_cone, 0.0f);
    EXPECT_EQ(scene.lights[0].intensity, Rgb(5.0f));
  }
  light.erase("range");
  for (const double outer : {9.0, 1e30, 3.14}) {
    light["spot"] = {{"innerConeAngle", 0.1}, {"outerConeAngle", outer}};
    EXPECT_FLOAT_EQ(warned({lamp + "/spot/outerConeAngle: the number"}).lights[0].outer_cone,
                    0.7853982f);
  }
  light["spot"] = {{"innerConeAngle", 2}, {"outerConeAngle", 1.2}};
  EXPECT_NEAR(warned({lamp + "/spot/innerConeAngle: the number 2"}).lights[0].inner_cone, 1.2f,
              1e-4f);
  light["color"] = {1, -1, 1};
  EXPECT_EQ(warned({lamp + "/color/1: expected a number of at least 0"}).lights[0].intensity,
            Rgb(5, 0, 5));
  light["spot"] = {{"innerConeAngle", 0.1}, {"outerConeAngle", 0}};
  EXPECT_FLOAT_EQ(warned({lamp + "/spot/outerConeAngle: the number"}).lights[0].outer_cone,
                  0.7853982f);
}

// Null counts as absent. No picture needs the members that are null here.
TEST_F(NeedlessFault, NullEqualsAMissingMember) {
  gltf_.push("cameras", {{"type", "perspective"},
                         {"perspective", {{"yfov", 0.5}, {"znear", 0.1}, {"aspectRatio", 2}}}});
  gltf_.push("cameras", {{"type", "orthographic"},
                         {"orthographic", {{"xmag", 1}, {"ymag", 2}, {"znear", 0}, {"zfar", 1}}}});
  for (const int camera : {0, 1}) gltf_.add_to_scene(gltf_.push("nodes", {{"camera", camera}}));
  const auto expect_usable = [&](const std::string& place) {
    const SceneDescription scene = warned({"#" + place + ": expected ", "found null", "left out"});
    ASSERT_EQ(scene.cameras.size(), 2u);
    EXPECT_FALSE(scene.cameras[0].fault || scene.cameras[1].fault) << place;
    EXPECT_EQ(scene.cameras[0].fov_y, 0.5);
    EXPECT_EQ(scene.cameras[1].y_mag, 2.0);
  };
  const json whole = gltf_.root;
  for (const char* place :
       {"/cameras/0/perspective/zfar", "/cameras/0/perspective/znear",
        "/cameras/0/perspective/aspectRatio", "/cameras/1/orthographic/znear",
        "/cameras/1/orthographic/zfar", "/cameras/0/name", "/nodes/0/scale", "/nodes/0/children",
        "/meshes/0/primitives/0/material", "/meshes/0/primitives/0/mode", "/meshes/0/weights"}) {
    gltf_.root[json::json_pointer(place)] = nullptr;
    expect_usable(place);
    gltf_.root = whole;
  }
  for (const json& xmag : {json(nullptr), json(0), json(1e40)}) {
    gltf_.root["cameras"][1]["orthographic"]["xmag"] = xmag;
    const CameraDescription camera = warned({"#/cameras/1/orthographic/xmag: "}).cameras.at(1);
    EXPECT_FALSE(camera.fault || camera.aspect) << xmag;
    EXPECT_EQ(camera.y_mag, 2.0);
  }
  gltf_.root = whole;
  gltf_.root["cameras"][1]["orthographic"].erase("zfar");
  const SceneDescription scene =
      warned({"#/cameras/1/orthographic: the required member \"zfar\" is missing"});
  EXPECT_FALSE(scene.cameras.at(1).fault);
  // A member that the camera needs may not be null.
  gltf_.root["cameras"][1]["orthographic"]["ymag"] = nullptr;
  EXPECT_TRUE(load_gltf(gltf_.write_glb(folder_ / "a.glb"), {}).cameras.at(1).fault);
  gltf_.root["nodes"] = nullptr;
  refused({"#/nodes: expected an array, found null"});
}

TEST_F(NeedlessFault, TextureTransforms) {
  test::add_texture(gltf_, test::small_png());
  gltf_.push("materials", {{"emissiveTexture", {{"index", 0}}}});
  gltf_.primitive()["material"] = 0;
  json& transform =
      gltf_.root["materials"][0]["emissiveTexture"]["extensions"]["KHR_texture_transform"];
  transform = {{"offset", {0.25, 0.5}}, {"scale", {2}}};
  const std::string place = "#/materials/0/emissiveTexture/extensions/KHR_texture_transform";
  SceneDescription scene = warned({place + "/scale: expected 2 numbers, found 1"});
  EXPECT_EQ(scene.materials[0].emission_texture.uv_transform,
            (std::array<float, 6>{1, 0, 0.25f, 0, 1, 0.5f}));
  require_extension("KHR_texture_transform");
  refused({place + "/scale: expected 2 numbers, found 1"});
  gltf_.root.erase("extensionsRequired");
  transform = "none";
  scene = warned({place + ": expected an object"});
  EXPECT_EQ(scene.materials[0].emission_texture.uv_transform,
            (std::array<float, 6>{1, 0, 0, 0, 1, 0}));
}

TEST_F(NeedlessFault, BrokenWebpUsesTheOtherImage) {
  const int png = gltf_.push("images", {{"bufferView", gltf_.add_view(test::small_png())}});
  const std::vector<uint8_t> noise(40, 0x5a);
  const int webp = gltf_.push("images", {{"bufferView", gltf_.add_view(noise)}});
  gltf_.push("textures",
             {{"source", png}, {"extensions", {{"EXT_texture_webp", {{"source", webp}}}}}});
  gltf_.push("materials", {{"emissiveTexture", {{"index", 0}}}});
  gltf_.primitive()["material"] = 0;
  EXPECT_EQ(warned({"#/images/1", "other image is used"}).images.at(0)->width, 2);
  require_extension("EXT_texture_webp");
  refused({"#/images/1"});
}

TEST_F(NeedlessFault, InstancesAreNeeded) {
  node()["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"TRANSLATION", 99}};
  refused({"#/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes/TRANSLATION: index 99"});
  node()["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"_ID", 99}};
  refused({"#/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes/_ID: index 99"});
  node()["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"TRANSLATION", 0}, {"_ID", 99}};
  EXPECT_EQ(warned({"EXT_mesh_gpu_instancing/attributes/_ID: index 99"}).instances.size(), 3u);
}

TEST_F(NeedlessFault, NullInstancesAreNone) {
  json& extension = node()["extensions"]["EXT_mesh_gpu_instancing"];
  for (const json& value : {json(nullptr), json{{"attributes", nullptr}}}) {
    extension = value;
    EXPECT_EQ(warned({"EXT_mesh_gpu_instancing", "found null"}).instances.size(), 1u);
  }
  require_extension("EXT_mesh_gpu_instancing");
  refused({"EXT_mesh_gpu_instancing", "found null"});
}

TEST_F(NeedlessFault, ExtensionsAsAnEmptyList) {
  node()["extensions"] = json::array();
  EXPECT_EQ(load_gltf(gltf_.write_glb(folder_ / "a.glb"), {}).instances.size(), 1u);
}

// Returns the Draco square, with its uncompressed triangles as a fallback.
GltfBuilder draco_with_fallback() {
  GltfBuilder gltf = test::draco_square(draco::MESH_EDGEBREAKER_ENCODING);
  gltf.root.erase("extensionsRequired");
  json& accessors = gltf.root["accessors"];
  accessors[0]["bufferView"] =
      gltf.add_view(std::vector<float>{0, 0, 5, 1, 0, 5, 1, 1, 5, 0, 1, 5});
  accessors[1]["bufferView"] = gltf.add_view(std::vector<float>(8, 0.5f));
  accessors[2]["bufferView"] = gltf.add_view(std::vector<uint8_t>(16, 255));
  accessors[3]["bufferView"] = gltf.add_view(std::vector<uint32_t>{0, 1, 2, 0, 2, 3});
  return gltf;
}

TEST(NeedlessFaultOfDraco, UsesTheUncompressedData) {
  const std::string place = "#/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression";
  GltfBuilder gltf = draco_with_fallback();
  ASSERT_EQ(gltf.root["accessors"][0]["count"], 4);
  {
    const TempFolder folder;
    const SceneDescription scene = load_gltf(gltf.write_glb(folder / "a.glb"), {});
    EXPECT_EQ(scene.meshes.at(0).positions.at(0).z, 0.0f);
    EXPECT_TRUE(scene.coverage.ignored.empty());
  }
  const json good = gltf.root;
  const auto& extension = [&]() -> json& {
    return gltf.primitive()["extensions"]["KHR_draco_mesh_compression"];
  };
  gltf.bin[0] = 'X';
  SceneDescription scene = expect_warning(gltf, {place + ": ", "corrupt", "it is left out"});
  EXPECT_EQ(scene.meshes.at(0).triangles.size(), 2u);
  EXPECT_EQ(scene.meshes.at(0).positions.at(0).z, 5.0f);
  extension()["bufferView"] = 99;
  scene = expect_warning(gltf, {place + "/bufferView: index 99"});
  EXPECT_EQ(scene.meshes.at(0).positions.at(0).z, 5.0f);
  // From here on, the extension is required or there is no fallback.
  gltf.root["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  expect_input_error(gltf, {place + "/bufferView: index 99"});
  gltf.root = good;
  gltf.root["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  expect_input_error(gltf, {place + ": "});
  gltf.root = good;
  gltf.root["accessors"][0].erase("bufferView");
  expect_input_error(gltf, {place + ": "});
  extension()["bufferView"] = 99;
  expect_input_error(gltf, {place + "/bufferView: index 99"});
}

TEST(NeedlessFaultOfMeshopt, APlaceholderNeedsNeitherBytesNorAMark) {
  for (const char* name : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
    GltfBuilder gltf = test::meshopt_triangle(false, name);
    gltf.root["buffers"][1] = {{"byteLength", 100000}};
    const TempFolder folder;
    const SceneDescription scene = load_gltf(gltf.write_glb(folder / "a.glb"), {});
    EXPECT_EQ(scene.meshes.at(0).positions.size(), 3u);
    EXPECT_TRUE(scene.coverage.ignored.empty());
    // Here an uncompressed view uses the placeholder.
    gltf.push("bufferViews", {{"buffer", 1}, {"byteLength", 12}});
    expect_warning(gltf, {"#/buffers/1: the buffer has neither a uri nor a GLB binary chunk"});
    gltf.push("accessors",
              {{"bufferView", 2}, {"componentType", 5123}, {"count", 3}, {"type", "SCALAR"}});
    gltf.primitive()["indices"] = 2;
    expect_input_error(gltf, {"#/buffers/1: the buffer has neither a uri nor a GLB binary chunk"});
  }
}

TEST(NeedlessFaultOfMeshopt, UsesTheFallbackBuffer) {
  GltfBuilder gltf = test::meshopt_triangle(false);
  gltf.root.erase("extensionsRequired");
  const std::string place = "#/bufferViews/0/extensions/EXT_meshopt_compression";
  gltf.bin[0] = 0;
  expect_input_error(gltf, {place + ": ", "corrupt"});  // there is no fallback
  std::vector<uint8_t> bytes(36);
  const float positions[9] = {0, 0, 7, 1, 0, 7, 0, 1, 7};
  std::memcpy(bytes.data(), positions, sizeof(positions));
  gltf.root["buffers"][1] = {{"byteLength", 36}, {"uri", "data:;base64," + test::base64(bytes)}};
  SceneDescription scene = expect_warning(gltf, {place + ": ", "corrupt", "it is left out"});
  EXPECT_EQ(scene.meshes.at(0).positions.at(0).z, 7.0f);
  gltf.root["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]["count"] = "three";
  scene = expect_warning(gltf, {place + "/count: expected a whole number"});
  EXPECT_EQ(scene.meshes.at(0).positions.at(0).z, 7.0f);
  gltf.root["extensionsRequired"] = {"EXT_meshopt_compression"};
  expect_input_error(gltf, {place + "/count: expected a whole number"});
}

// ---- how many

// There is one line for each kind of fault, no matter how many faults there are.
TEST_F(NeedlessFault, AreCounted) {
  constexpr int kCount = 100000;
  json& cameras = gltf_.root["cameras"];
  for (int i = 0; i < kCount; ++i) cameras.push_back({{"type", i}});
  gltf_.root["animations"] = std::vector<int>(kCount, 1);
  json& attributes = gltf_.primitive()["attributes"];
  for (int i = 0; i < kCount; ++i) attributes["_" + std::to_string(i)] = 99;
  const std::clock_t start = std::clock();
  const SceneDescription scene =
      warned({"#/cameras/0/type: expected a string, found 0; it is not used (and 99999 more"});
  EXPECT_LT(double(std::clock() - start) / CLOCKS_PER_SEC, 10.0 * test::kSanitizerSlowdown);
  EXPECT_EQ(scene.coverage.ignored.size(), 3u);
  EXPECT_FALSE(scene.coverage.not_played.empty());
  EXPECT_NE(test::rejection_message(gltf_, uint64_t(64) << 20).find("raise memory-limit"),
            std::string::npos);
}

}  // namespace
}  // namespace emberline
