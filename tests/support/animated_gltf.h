// Adds animations to the glTF files that tests build.
#pragma once

#include <cstddef>
#include <string>
#include <type_traits>
#include <vector>

#include "io/gltf/gltf_file.h"
#include "support/gltf_builder.h"

namespace emberline::test {

// Builds one animation of a file, channel by channel.
class AnimationBuilder {
 public:
  using json = nlohmann::json;

  explicit AnimationBuilder(GltfBuilder& gltf, const std::string& name = "");

  json& object();
  json& channel(size_t i);
  json& sampler(size_t i);
  json& input(size_t i);
  json& output(size_t i);

  // Adds a channel for a node's property.
  template <class T = float>
  AnimationBuilder& move(int node, const std::string& path, const std::vector<float>& times,
                         const std::string& type, const std::vector<T>& values,
                         const std::string& interpolation = "LINEAR") {
    return add_move(node, path, make_sampler(times, type, values, interpolation));
  }
  // Adds a channel of KHR_animation_pointer.
  template <class T = float>
  AnimationBuilder& point(const std::string& pointer, const std::vector<float>& times,
                          const std::string& type, const std::vector<T>& values,
                          const std::string& interpolation = "LINEAR") {
    return add_pointer(pointer, make_sampler(times, type, values, interpolation));
  }

 private:
  struct Sampler {
    int input, output;  // indices of accessors
    const std::string& interpolation;
  };
  template <class T>
  Sampler make_sampler(const std::vector<float>& times, const std::string& type,
                       const std::vector<T>& values, const std::string& interpolation) {
    const bool normalized = !std::is_same_v<T, float> && type != "BOOL";
    const int input = gltf_.add_accessor<float>("SCALAR", times);
    return {input, gltf_.add_accessor<T>(type == "BOOL" ? "SCALAR" : type, values, normalized),
            interpolation};
  }
  AnimationBuilder& add_move(int node, const std::string& path, const Sampler& sampler);
  AnimationBuilder& add_pointer(const std::string& pointer, const Sampler& sampler);
  AnimationBuilder& add(const json& target, const Sampler& sampler);
  json& accessor(const json& index);

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

// Loads the file with a shutter that is open from `from` to `to`.
inline SceneDescription load_open(const GltfBuilder& gltf, double from, double to) {
  const TempFolder folder;
  GltfOptions options;
  options.time = from;
  options.shutter = GltfOptions::Shutter{0, to - from};
  return load_gltf(gltf.write_glb(folder / "a.glb"), options);
}

}  // namespace emberline::test
