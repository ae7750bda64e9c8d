#include "support/animated_gltf.h"

#include <nlohmann/json.hpp>

namespace emberline::test {

using nlohmann::json;

AnimationBuilder::AnimationBuilder(GltfBuilder& gltf, const std::string& name)
    : gltf_(gltf),
      index_(size_t(
          gltf.push("animations",
                    {{"name", name}, {"channels", json::array()}, {"samplers", json::array()}}))) {}

json& AnimationBuilder::object() { return gltf_.root["animations"][index_]; }
json& AnimationBuilder::channel(size_t i) { return object()["channels"][i]; }
json& AnimationBuilder::sampler(size_t i) { return object()["samplers"][i]; }
json& AnimationBuilder::input(size_t i) { return accessor(sampler(i)["input"]); }
json& AnimationBuilder::output(size_t i) { return accessor(sampler(i)["output"]); }

AnimationBuilder& AnimationBuilder::add_move(int node, const std::string& path,
                                             const Sampler& sampler) {
  return add({{"node", node}, {"path", path}}, sampler);
}

AnimationBuilder& AnimationBuilder::add_pointer(const std::string& pointer,
                                                const Sampler& sampler) {
  const json extensions = {{"KHR_animation_pointer", {{"pointer", pointer}}}};
  return add({{"path", "pointer"}, {"extensions", extensions}}, sampler);
}

AnimationBuilder& AnimationBuilder::add(const json& target, const Sampler& sampler) {
  object()["samplers"].push_back({{"input", sampler.input},
                                  {"output", sampler.output},
                                  {"interpolation", sampler.interpolation}});
  object()["channels"].push_back(
      {{"sampler", object()["samplers"].size() - 1}, {"target", target}});
  return *this;
}

json& AnimationBuilder::accessor(const json& index) {
  return gltf_.root["accessors"][index.get<size_t>()];
}

}  // namespace emberline::test
