// Adds animations to files that tests build.
#pragma once

#include <string>
#include <vector>

#include "io/gltf/gltf_file.h"
#include "support/gltf_builder.h"

namespace emberline::test {

// One animation of a file, built channel by channel.
class AnimationBuilder {
 public:
  using json = nlohmann::json;

  explicit AnimationBuilder(GltfBuilder& gltf, const std::string& name = "")
      : gltf_(gltf),
        index_(size_t(gltf.push(
            "animations",
            {{"name", name}, {"channels", json::array()}, {"samplers", json::array()}}))) {}

  json& object() { return gltf_.root["animations"][index_]; }
  json& channel(size_t i) { return object()["channels"][i]; }
  json& sampler(size_t i) { return object()["samplers"][i]; }
  json& input(size_t i) { return accessor(sampler(i)["input"]); }
  json& output(size_t i) { return accessor(sampler(i)["output"]); }

  // A channel of a node's property.
  template <class T = float>
  AnimationBuilder& move(int node, const std::string& path, const std::vector<float>& times,
                         const std::string& type, const std::vector<T>& values,
                         const std::string& interpolation = "LINEAR") {
    return add({{"node", node}, {"path", path}}, times, type, values, interpolation);
  }
  // A channel of KHR_animation_pointer.
  template <class T = float>
  AnimationBuilder& point(const std::string& pointer, const std::vector<float>& times,
                          const std::string& type, const std::vector<T>& values,
                          const std::string& interpolation = "LINEAR") {
    const json extensions = {{"KHR_animation_pointer", {{"pointer", pointer}}}};
    return add({{"path", "pointer"}, {"extensions", extensions}}, times, type, values,
               interpolation);
  }

 private:
  template <class T>
  AnimationBuilder& add(const json& target, const std::vector<float>& times,
                        const std::string& type, const std::vector<T>& values,
                        const std::string& interpolation) {
    const bool normalized = !std::is_same_v<T, float> && type != "BOOL";
    object()["samplers"].push_back(
        {{"input", gltf_.add_accessor<float>("SCALAR", times)},
         {"output", gltf_.add_accessor<T>(type == "BOOL" ? "SCALAR" : type, values, normalized)},
         {"interpolation", interpolation}});
    object()["channels"].push_back(
        {{"sampler", object()["samplers"].size() - 1}, {"target", target}});
    return *this;
  }
  json& accessor(const json& index) { return gltf_.root["accessors"][index.get<size_t>()]; }

  GltfBuilder& gltf_;
  size_t index_;
};

inline SceneDescription load_at(const GltfBuilder& gltf, double time,
                                const std::string& animation = "") {
  const TempFolder folder;
  GltfOptions options;
  options.time = time;
  options.animation = animation;
  return load_gltf(gltf.write_glb(folder / "a.glb"), options);
}

// With a shutter that is open between two times.
inline SceneDescription load_open(const GltfBuilder& gltf, double from, double to) {
  const TempFolder folder;
  GltfOptions options;
  options.time = from;
  options.shutter = GltfOptions::Shutter{0, to - from};
  return load_gltf(gltf.write_glb(folder / "a.glb"), options);
}

}  // namespace emberline::test
