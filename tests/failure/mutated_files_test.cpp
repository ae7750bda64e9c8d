// Files cut short and files with flipped bytes: an InputError or a scene, never anything else.
#include <random>

#include "failure/bad_input.h"
#include "io/gltf_material.h"
#include "renderer/core/log.h"
#include "support/encoded_images.h"

namespace emberline {
namespace {

using test::GltfBuilder;
using test::TempFolder;

// One of most things, small: a textured, normal-mapped quad with sparse positions, a skin, morph
// targets, instances, a camera and a light.
GltfBuilder busy_scene() {
  GltfBuilder gltf;
  const int p = gltf.add_accessor<float>("VEC3", {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});
  gltf.root["accessors"][size_t(p)]["sparse"] = {
      {"count", 1},
      {"indices",
       {{"bufferView", gltf.add_view(std::vector<uint8_t>{1})}, {"componentType", 5121}}},
      {"values", {{"bufferView", gltf.add_view(std::vector<float>{2, 0, 0})}}}};
  const int n = gltf.add_accessor<int8_t>(
      "VEC4", {0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0}, true);
  gltf.root["accessors"][size_t(n)]["type"] = "VEC3";
  gltf.root["bufferViews"][gltf.root["accessors"][size_t(n)]["bufferView"].get<size_t>()]
           ["byteStride"] = 4;
  const int uv =
      gltf.add_accessor<uint16_t>("VEC2", {0, 65535, 65535, 65535, 65535, 0, 0, 0}, true);
  const int joints = gltf.add_accessor<uint8_t>("VEC4", std::vector<uint8_t>(16, 0));
  const int weights = gltf.add_accessor<float>("VEC4", std::vector<float>(16, 0.25f));
  const int morph = gltf.add_accessor<float>("VEC3", std::vector<float>(12, 0.5f));
  const int indices = gltf.add_accessor<uint16_t>("SCALAR", {0, 1, 2, 0, 2, 3});
  const int texture = test::add_texture(gltf, test::small_png());
  gltf.push("materials",
            {{"normalTexture", {{"index", texture}}},
             {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", texture}}}}},
             {"extensions",
              {{"KHR_materials_transmission",
                {{"transmissionFactor", 0.5}, {"transmissionTexture", {{"index", texture}}}}},
               {"KHR_materials_volume",
                {{"thicknessFactor", 1},
                 {"attenuationDistance", 2},
                 {"attenuationColor", {0.5, 0.5, 1}}}},
               {"KHR_materials_ior", {{"ior", 1.4}}}}}});
  const int mesh = gltf.add_mesh({{"attributes",
                                   {{"POSITION", p},
                                    {"NORMAL", n},
                                    {"TEXCOORD_0", uv},
                                    {"JOINTS_0", joints},
                                    {"WEIGHTS_0", weights}}},
                                  {"targets", {{{"POSITION", morph}}}},
                                  {"indices", indices},
                                  {"material", 0}});
  gltf.root["meshes"][0]["weights"] = {0.5};
  gltf.add_mesh_node(mesh);
  gltf.root["nodes"][0]["skin"] = 0;
  const int joint = gltf.push("nodes", {{"rotation", {0, 0, 0, 1}}});
  gltf.add_to_scene(joint);
  gltf.push("skins",
            {{"joints", {joint}},
             {"inverseBindMatrices",
              gltf.add_accessor<float>("MAT4", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1})}});
  const int moves = gltf.add_accessor<float>("VEC3", {1, 0, 0, 2, 0, 0});
  gltf.add_mesh_node(mesh);
  gltf.root["nodes"][2]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] =
      moves;
  gltf.push("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 0.7}, {"znear", 0.1}}}});
  gltf.root["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "spot"}, {"spot", {{"outerConeAngle", 0.5}}}}};
  gltf.add_to_scene(gltf.push(
      "nodes", {{"camera", 0}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}}));
  return gltf;
}

// Valid indices, finite vertices: what load_gltf promises of a scene that it returns.
void expect_sound(const SceneDescription& scene) {
  ASSERT_FALSE(scene.instances.empty());
  for (const InstanceDescription& instance : scene.instances) {
    ASSERT_LT(size_t(instance.mesh), scene.meshes.size());
  }
  for (const MeshDescription& mesh : scene.meshes) {
    const size_t count = mesh.positions.size();
    ASSERT_LT(mesh.material, int(scene.materials.size()));
    ASSERT_TRUE(mesh.normals.empty() || mesh.normals.size() == count);
    ASSERT_TRUE(mesh.tangents.empty() || mesh.tangents.size() == count);
    ASSERT_TRUE(mesh.colors.empty() || mesh.colors.size() == count);
    for (const auto& uv : mesh.uv_sets) ASSERT_TRUE(uv.empty() || uv.size() == count);
    for (const Vec3f& p : mesh.positions) ASSERT_TRUE(is_finite(p));
    for (const Vec3f& n : mesh.normals) ASSERT_TRUE(is_finite(n));
    for (const Vec4f& t : mesh.tangents) ASSERT_TRUE(is_finite(Vec3f(t.x, t.y, t.z)));
    for (const auto& triangle : mesh.triangles) {
      for (const uint32_t v : triangle) ASSERT_LT(v, count);
    }
  }
  for (const MaterialDescription& material : scene.materials) {
    for (const TextureRef* slot : texture_slots(material)) {
      ASSERT_LT(slot->image, int(scene.images.size()));
    }
  }
}

// True when it loads. Anything but InputError escapes and fails the test.
bool survives(const std::string& path, bool lenient) {
  try {
    expect_sound(load_gltf(path, {lenient}));
    return true;
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    return false;
  }
}

class Mutated : public testing::Test {
 protected:
  Mutated() { set_log_level(LogLevel::kQuiet); }
  ~Mutated() override { set_log_level(LogLevel::kNormal); }
  TempFolder folder_;
};

TEST_F(Mutated, TheSceneItselfIsSound) {
  EXPECT_TRUE(survives(busy_scene().write_glb(folder_ / "a.glb"), false));
  EXPECT_TRUE(survives(busy_scene().write_embedded(folder_ / "a.gltf"), false));
}

TEST_F(Mutated, EveryPrefixOfAGlb) {
  const std::vector<uint8_t> whole = busy_scene().glb();
  for (size_t size = 0; size < whole.size(); ++size) {
    test::write_bytes(folder_ / "a.glb", whole.data(), size);
    EXPECT_FALSE(survives(folder_ / "a.glb", false)) << size << " bytes of " << whole.size();
  }
}

// Cut short, but with a header that admits it: the framing is whole, what it frames is not.
TEST_F(Mutated, EveryPrefixOfAGlbWithAnHonestHeader) {
  const std::vector<uint8_t> whole = busy_scene().glb();
  for (size_t size = 20; size < whole.size(); ++size) {
    std::vector<uint8_t> bytes(whole.begin(), whole.begin() + std::ptrdiff_t(size));
    for (int i = 0; i < 4; ++i) bytes[8 + size_t(i)] = uint8_t(size >> (8 * i));
    test::write_bytes(folder_ / "a.glb", bytes);
    survives(folder_ / "a.glb", true);
  }
}

// Replay one failure with its round: the generator is seeded by it.
void mutate(std::vector<uint8_t>& bytes, uint32_t round) {
  std::mt19937 random(round);
  const uint32_t changes = 1 + random() % 4;
  for (uint32_t i = 0; i < changes && !bytes.empty(); ++i) {
    const size_t at = random() % bytes.size();
    switch (random() % 5) {
      case 0:
        bytes[at] = uint8_t(random());
        break;
      case 1:
        bytes[at] ^= uint8_t(1u << random() % 8);
        break;
      case 2:
        bytes[at] = uint8_t("0123456789-.,:[]{}\"e"[random() % 20]);
        break;
      case 3:
        bytes.erase(bytes.begin() + std::ptrdiff_t(at));
        break;
      default:
        bytes.insert(bytes.begin() + std::ptrdiff_t(at), uint8_t(random()));
        break;
    }
  }
}

TEST_F(Mutated, SeededMutationsOfAGlb) {
  const std::vector<uint8_t> whole = busy_scene().glb();
  for (uint32_t round = 0; round < 4000; ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    std::vector<uint8_t> bytes = whole;
    mutate(bytes, round);
    test::write_bytes(folder_ / "a.glb", bytes);
    survives(folder_ / "a.glb", round % 2 == 0);
    if (HasFatalFailure()) return;
  }
}

TEST_F(Mutated, SeededMutationsOfAGltf) {
  const GltfBuilder gltf = busy_scene();
  const std::string text = gltf.document("data.bin").dump();
  gltf.write_gltf(folder_ / "whole.gltf");
  for (uint32_t round = 0; round < 4000; ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    std::vector<uint8_t> bytes(text.begin(), text.end());
    mutate(bytes, round + 1000000);
    test::write_bytes(folder_ / "a.gltf", bytes);
    survives(folder_ / "a.gltf", round % 2 == 0);
    if (HasFatalFailure()) return;
  }
}

// Every number in the JSON replaced by others, one at a time.
void collect_numbers(const nlohmann::json& value, const std::string& pointer,
                     std::vector<std::string>& found) {
  if (value.is_number()) found.push_back(pointer);
  if (!value.is_structured()) return;
  for (const auto& [key, member] : value.items()) {
    collect_numbers(member, pointer + "/" + key, found);
  }
}

TEST_F(Mutated, EveryNumberReplaced) {
  const GltfBuilder gltf = busy_scene();
  const nlohmann::json whole = gltf.document("data.bin");
  gltf.write_gltf(folder_ / "whole.gltf");
  std::vector<std::string> pointers;
  collect_numbers(whole, "", pointers);
  ASSERT_GT(pointers.size(), 100u);
  for (const std::string& pointer : pointers) {
    for (const double value :
         {-1.0, 0.0, 1.0, 2.0, 5.0, 255.0, 1e9, 4294967295.0, 1e18, 1e38, 0.5}) {
      SCOPED_TRACE(pointer + " = " + std::to_string(value));
      nlohmann::json document = whole;
      nlohmann::json& number = document[nlohmann::json::json_pointer(pointer)];
      if (value == std::floor(value) && std::abs(value) < 1e19) {
        number = int64_t(value);
      } else {
        number = value;
      }
      test::write_text(folder_ / "a.gltf", document.dump());
      survives(folder_ / "a.gltf", true);
      if (HasFatalFailure()) return;
    }
  }
}

}  // namespace
}  // namespace emberline
