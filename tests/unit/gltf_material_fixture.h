// A triangle with three UV sets, and materials for it.
#pragma once

#include <gtest/gtest.h>

#include "io/gltf/gltf_file.h"
#include "renderer/core/errors.h"
#include "support/embedded_images.h"

namespace emberline::test {

class GltfMaterialTest : public testing::Test {
 protected:
  using json = nlohmann::json;

  GltfMaterialTest() {
    gltf_.add_triangle();
    auto& attributes = gltf_.primitive()["attributes"];
    attributes["TEXCOORD_0"] = gltf_.add_accessor<float>("VEC2", {0, 1, 1, 1, 0, 0});
    attributes["TEXCOORD_1"] = gltf_.add_accessor<float>("VEC2", {5, 1, 6, 1, 5, 0});
    attributes["TEXCOORD_2"] = gltf_.add_accessor<float>("VEC2", {7, 1, 8, 1, 7, 0});
  }
  SceneDescription load(const json& material, bool lenient = false) {
    gltf_.root["materials"] = json::array({material});
    gltf_.primitive()["material"] = 0;
    return load_gltf(gltf_.write_glb(folder_ / "a.glb"), {lenient});
  }
  MaterialDescription material(const json& value) { return load(value).materials.at(0); }
  std::string message_of(const json& value) {
    try {
      load(value);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }
  static json base_color_slot(const json& slot) {
    return {{"pbrMetallicRoughness", {{"baseColorTexture", slot}}}};
  }
  static json with(const char* extension, const json& value) {
    return {{"extensions", {{extension, value}}}};
  }

  TempFolder folder_;
  GltfBuilder gltf_;
};

}  // namespace emberline::test
