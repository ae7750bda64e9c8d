#include "unit/gltf_material_fixture.h"

#include <nlohmann/json.hpp>

#include "io/gltf/gltf_file.h"
#include "renderer/core/errors.h"

namespace emberline::test {

using nlohmann::json;

GltfMaterialTest::GltfMaterialTest() {
  gltf_.add_triangle();
  auto& attributes = gltf_.primitive()["attributes"];
  attributes["TEXCOORD_0"] = gltf_.add_accessor<float>("VEC2", {0, 1, 1, 1, 0, 0});
  attributes["TEXCOORD_1"] = gltf_.add_accessor<float>("VEC2", {5, 1, 6, 1, 5, 0});
  attributes["TEXCOORD_2"] = gltf_.add_accessor<float>("VEC2", {7, 1, 8, 1, 7, 0});
}

SceneDescription GltfMaterialTest::load(const json& material, bool lenient) {
  gltf_.root["materials"] = json::array({material});
  gltf_.primitive()["material"] = 0;
  return load_gltf(gltf_.write_glb(folder_ / "a.glb"), {lenient});
}

std::string GltfMaterialTest::message_of(const json& value) {
  try {
    load(value);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

json GltfMaterialTest::base_color_slot(const json& slot) {
  return {{"pbrMetallicRoughness", {{"baseColorTexture", slot}}}};
}

json GltfMaterialTest::with(const char* extension, const json& value) {
  return {{"extensions", {{extension, value}}}};
}

}  // namespace emberline::test
