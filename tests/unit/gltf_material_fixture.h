// A triangle with three UV sets, and materials for it.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "renderer/description/scene_description.h"
#include "support/embedded_images.h"

namespace emberline::test {

class GltfMaterialTest : public testing::Test {
 protected:
  using json = nlohmann::json;

  GltfMaterialTest();
  SceneDescription load(const json& material, bool lenient = false);
  MaterialDescription material(const json& value) { return load(value).materials.at(0); }
  std::string message_of(const json& value);
  static json base_color_slot(const json& slot);
  static json with(const char* extension, const json& value);

  TempFolder folder_;
  GltfBuilder gltf_;
};

}  // namespace emberline::test
