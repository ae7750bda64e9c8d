#include "support/dense_gltf.h"

#include <nlohmann/json.hpp>

#include "support/embedded_images.h"

namespace emberline::test {

GltfBuilder dense_gltf() {
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
  const int texture = add_texture(gltf, small_png());
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
               {"KHR_materials_ior", {{"ior", 1.4}}},
               {"KHR_materials_dispersion", {{"dispersion", 0.5}}},
               {"KHR_materials_anisotropy",
                {{"anisotropyStrength", 0.5}, {"anisotropyTexture", {{"index", texture}}}}},
               {"KHR_materials_iridescence", {{"iridescenceFactor", 0.5}, {"iridescenceIor", 1.2}}},
               {"KHR_materials_clearcoat",
                {{"clearcoatFactor", 0.5}, {"clearcoatNormalTexture", {{"index", texture}}}}}}}});
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

}  // namespace emberline::test
