#include "support/animated_stage.h"

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "support/animated_gltf.h"

namespace emberline::test {
namespace {

class StageBuilder {
 public:
  using json = nlohmann::json;

  explicit StageBuilder(GltfBuilder& file) : gltf(file) {
    add_materials();
    floor_ = node(quad(2, kFloor), {0, 0, 0});
    node(quad(0.5f, kLamp), {1.2, 0, 1.2});  // this lamp is flush with the floor
    const int box_mesh = box(kRed);
    turning_ = node(box_mesh, {-1, 0.4, 0});
    const int pair = box(kVeil);
    node(pair, {0.2, 0.4, -0.8});
    rising_ = node(pair, {1, 0.4, 0});
    blinking_ = node(box(kGreen), {0, 1.2, -0.5});
    glowing_ = node(quad(0.3f, kGlow), {-0.5, 1.8, 0.3});
    add_flag();
    add_sail();
    add_lights_and_camera();
    animate();
  }

 private:
  enum Material { kFloor, kLamp, kRed, kVeil, kGreen, kGlow };

  void add_materials() {
    const auto add_material = [&](double r, double g, double b) -> json& {
      gltf.push("materials", {{"pbrMetallicRoughness",
                               {{"baseColorFactor", {r, g, b, 1.0}}, {"roughnessFactor", 0.6}}}});
      return gltf.root["materials"].back();
    };
    add_material(0.7, 0.7, 0.7);
    add_material(0.1, 0.1, 0.1)["emissiveFactor"] = {1.0, 0.9, 0.5};
    add_material(0.8, 0.1, 0.1);
    json& veil = add_material(0.2, 0.3, 0.9);
    veil["alphaMode"] = "BLEND";
    veil["pbrMetallicRoughness"]["baseColorFactor"][3] = 0.5;
    add_material(0.1, 0.7, 0.2)["doubleSided"] = true;
    json& glow = add_material(0.2, 0.2, 0.2);
    glow["emissiveFactor"] = {0.2, 0.6, 1.0};
    glow["doubleSided"] = true;
  }

  int mesh(const std::vector<float>& positions, const std::vector<uint16_t>& indices,
           int material) {
    const int accessor = gltf.add_accessor<float>("VEC3", positions);
    std::vector<float> minimum(3, 1e9f), maximum(3, -1e9f);
    for (size_t i = 0; i < positions.size(); ++i) {
      minimum[i % 3] = std::min(minimum[i % 3], positions[i]);
      maximum[i % 3] = std::max(maximum[i % 3], positions[i]);
    }
    gltf.root["accessors"][size_t(accessor)]["min"] = minimum;
    gltf.root["accessors"][size_t(accessor)]["max"] = maximum;
    return gltf.add_mesh({{"attributes", {{"POSITION", accessor}}},
                          {"indices", gltf.add_accessor<uint16_t>("SCALAR", indices)},
                          {"material", material}});
  }
  // Adds a horizontal square that faces up, with sides of 2 * half. Returns its mesh.
  int quad(float half, int material) {
    return mesh({-half, 0, -half, half, 0, -half, half, 0, half, -half, 0, half},
                {0, 2, 1, 0, 3, 2}, material);
  }
  int box(int material) {
    std::vector<float> positions;
    for (int corner = 0; corner < 8; ++corner) {
      for (int c = 0; c < 3; ++c) positions.push_back(corner >> c & 1 ? 0.3f : -0.3f);
    }
    return mesh(positions, {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                            2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5},
                material);
  }
  int node(int mesh_index, const std::vector<double>& at) {
    const int index = gltf.add_mesh_node(mesh_index);
    gltf.root["nodes"][size_t(index)]["translation"] = at;
    return index;
  }

  void add_flag() {
    const int flag = mesh({0, 0, 0, .5f, 0, 0, 0, .8f, 0, .5f, .8f, 0}, {0, 1, 3, 0, 3, 2}, kGreen);
    json& attributes = gltf.primitive(flag)["attributes"];
    attributes["JOINTS_0"] =
        gltf.add_accessor<uint8_t>("VEC4", {0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
    attributes["WEIGHTS_0"] =
        gltf.add_accessor<float>("VEC4", {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
    upper_ = gltf.push("nodes", json::object());
    const int lower = gltf.push("nodes", {{"children", {upper_}}, {"translation", {0, .5, .8}}});
    gltf.add_to_scene(lower);
    gltf.push("skins", {{"joints", {lower, upper_}}});
    gltf.root["nodes"][size_t(gltf.add_mesh_node(flag))]["skin"] = 0;
  }

  void add_sail() {
    const int sail = mesh({0, 0, 0, .6f, 0, 0, 0, .9f, 0}, {0, 1, 2}, kGreen);
    gltf.primitive(sail)["targets"] = {
        {{"POSITION", gltf.add_accessor<float>("VEC3", {0, 0, 0, .4f, 0, .5f, 0, .2f, 0})}}};
    gltf.root["meshes"][size_t(sail)]["weights"] = {0.0};
    sail_ = node(sail, {-1.6, 0.2, -1});
  }

  void add_lights_and_camera() {
    gltf.root["extensionsUsed"] = {"KHR_lights_punctual", "KHR_animation_pointer",
                                   "KHR_node_visibility"};
    gltf.root["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "point"}, {"intensity", 30.0}, {"color", {1.0, 0.8, 0.6}}}};
    light_ = gltf.push("nodes", {{"translation", {1.5, 3, 2}}});
    gltf.root["nodes"][size_t(light_)]["extensions"]["KHR_lights_punctual"]["light"] = 0;
    gltf.root["cameras"] = {
        {{"type", "perspective"}, {"perspective", {{"yfov", 0.9}, {"znear", 0.1}}}}};
    camera_ = gltf.push(
        "nodes",
        {{"camera", 0}, {"translation", {0, 1.6, 5}}, {"rotation", {-0.15, 0.0, 0.0, 0.9887}}});
    gltf.add_to_scene(light_);
    gltf.add_to_scene(camera_);
  }

  void animate() {
    const std::string floor = "/materials/0/pbrMetallicRoughness/baseColorFactor";
    AnimationBuilder(gltf, "all that moves")
        .move(turning_, "rotation", {0, 2}, "VEC4", {0, 0, 0, 1, 0, 1, 0, 0})
        .move(rising_, "translation", {0, 2}, "VEC3", {1, .4f, 0, 1, 1.8f, .4f})
        .move(glowing_, "translation", {0, 2}, "VEC3", {-.5f, 1.8f, .3f, .9f, 1.5f, .3f})
        .move(upper_, "rotation", {0, 2}, "VEC4", {0, 0, 0, 1, .5f, 0, 0, .866f})
        .move(sail_, "weights", {0, 2}, "SCALAR", {0, 1})
        .move(light_, "translation", {0, 2}, "VEC3", {1.5f, 3, 2, -1.5f, 3, 2})
        .move(camera_, "translation", {0, 2}, "VEC3", {0, 1.6f, 5, .5f, 1.8f, 5})
        .point<uint8_t>(
            "/nodes/" + std::to_string(blinking_) + "/extensions/KHR_node_visibility/visible",
            {0, .5f, 1.5f}, "BOOL", {0, 1, 0}, "STEP")
        .point(floor, {0, 2}, "VEC4", {.7f, .7f, .7f, 1, .2f, .5f, .7f, 1})
        .point("/materials/1/emissiveFactor", {0, 2}, "VEC3", {1, .9f, .5f, .2f, .2f, .9f})
        .point("/extensions/KHR_lights_punctual/lights/0/intensity", {0, 2}, "SCALAR", {30, 10});
    gltf.root["nodes"][size_t(blinking_)]["extensions"]["KHR_node_visibility"]["visible"] = true;
    AnimationBuilder(gltf, "camera")
        .move(camera_, "translation", {0, 2}, "VEC3", {0, 1.6f, 5, -1, 1, 4});
    AnimationBuilder(gltf, "light")
        .point("/extensions/KHR_lights_punctual/lights/0/intensity", {0, 2}, "SCALAR", {10, 50});
    AnimationBuilder(gltf, "box")
        .move(turning_, "rotation", {0, 2}, "VEC4", {0, 0, 0, 1, 0, 1, 0, 0});
    AnimationBuilder(gltf, "vanishing")
        .move(turning_, "scale", {0, 1, 2}, "VEC3", {1, 1, 1, 0, 0, 0, 1, 1, 1})
        .move(floor_, "translation", {0, 2}, "VEC3", {0, 0, 0, 0, -.5f, 0});
  }

  GltfBuilder& gltf;
  int floor_ = 0, turning_ = 0, rising_ = 0, blinking_ = 0, glowing_ = 0, upper_ = 0, sail_ = 0,
      light_ = 0, camera_ = 0;
};

}  // namespace

AnimatedStage::AnimatedStage() { StageBuilder{gltf}; }

}  // namespace emberline::test
