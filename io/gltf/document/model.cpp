#include <limits>
#include <nlohmann/json.hpp>

#include "io/gltf/document/document.h"
#include "io/gltf/document/tiny_gltf_renamed.h"
#include "renderer/core/errors.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

using nlohmann::json;

// Copies only the members `keys` of each object in the array `name`.
json copy_members(const GltfDocument& document, const char* name,
                  std::initializer_list<const char*> keys) {
  json result = json::array();
  for (const json& object : document.array(name)) {
    json copy = json::object();
    for (const char* key : keys) {
      if (const json* member = find_member(object, key)) copy[key] = *member;
    }
    result.push_back(std::move(copy));
  }
  return result;
}

// Replaces broken objects by a placeholder, because tinygltf requires a type. The placeholder is
// never used.
void replace_broken(json& list, const json& placeholder) {
  for (json& object : list) {
    if (object.empty()) object = placeholder;
  }
}

// Removes extensions and extras. Extensions of texture slots are read from the document itself.
void drop_extensions(json& value) {
  if (!value.is_structured()) return;
  if (value.is_object()) {
    value.erase("extensions");
    value.erase("extras");
  }
  for (json& member : value) drop_extensions(member);
}

// Returns the approximate memory that the model and its construction take.
uint64_t model_bytes(const GltfDocument& document) {
  constexpr std::pair<const char*, size_t> kArrays[] = {
      {"scenes", sizeof(tinygltf::Scene)},       {"nodes", sizeof(tinygltf::Node)},
      {"materials", sizeof(tinygltf::Material)}, {"textures", sizeof(tinygltf::Texture)},
      {"samplers", sizeof(tinygltf::Sampler)},   {"cameras", sizeof(tinygltf::Camera)},
      {"skins", sizeof(tinygltf::Skin)}};
  uint64_t objects = 0;
  for (const auto& [name, size] : kArrays) objects += bytes_of(document.array(name).size(), size);
  if (const json* lights = find_extension(*document.json, "KHR_lights_punctual")) {
    objects += bytes_of(lights->at("lights").size(), sizeof(tinygltf::Light));
  }
  // The factor 2 is for vectors, which grow by doubling. The second term is for the reduced JSON,
  // tinygltf's copy of that JSON, and its text.
  return 2 * objects + document.json_memory.bytes() / 4 * 9;
}

}  // namespace

void parse_gltf_model(GltfDocument& document) {
  document.model.reset();
  document.model_memory = MemoryReservation(document.progress->budget(), MemoryPart::kFile,
                                            model_bytes(document), document.file);
  json reduced = json::object();
  const json& asset = document.json->at("asset");
  reduced["asset"]["version"] = asset.at("version");
  if (asset.contains("generator")) reduced["asset"]["generator"] = asset.at("generator");
  if (document.json->contains("scene")) reduced["scene"] = document.json->at("scene");
  reduced["scenes"] = copy_members(document, "scenes", {"name", "nodes"});
  reduced["nodes"] = copy_members(document, "nodes",
                                  {"name", "children", "mesh", "camera", "skin", "matrix",
                                   "translation", "rotation", "scale", "weights"});
  reduced["materials"] =
      copy_members(document, "materials", {"name", "alphaMode", "alphaCutoff", "doubleSided"});
  reduced["textures"] = copy_members(document, "textures", {"sampler", "source"});
  reduced["samplers"] =
      copy_members(document, "samplers", {"magFilter", "minFilter", "wrapS", "wrapT"});
  reduced["cameras"] =
      copy_members(document, "cameras", {"name", "type", "perspective", "orthographic"});
  const json lens = {{"yfov", 1.0}, {"znear", 1.0}};
  replace_broken(reduced["cameras"], {{"type", "perspective"}, {"perspective", lens}});
  reduced["skins"] = copy_members(document, "skins", {"inverseBindMatrices", "skeleton", "joints"});
  replace_broken(reduced["skins"], {{"joints", json::array({0})}});
  drop_extensions(reduced);
  if (const json* lights = find_extension(*document.json, "KHR_lights_punctual")) {
    json copy = lights->at("lights");
    replace_broken(copy, {{"type", "point"}});
    drop_extensions(copy);
    reduced["extensions"]["KHR_lights_punctual"]["lights"] = std::move(copy);
  }

  const std::string text = reduced.dump();
  if (text.size() > std::numeric_limits<int>::max()) {
    throw InputError(document.file, "more than 2 GiB of nodes and materials");
  }
  auto model = std::make_shared<tinygltf::Model>();
  tinygltf::TinyGLTF loader;
  std::string error, warning;
  if (!loader.LoadASCIIFromString(model.get(), &error, &warning, text.data(), unsigned(text.size()),
                                  std::string())) {
    for (char& c : error) c = c == '\n' ? ' ' : c;
    throw InputError(document.file, "tinygltf cannot read it: " + shortened(error));
  }
  document.model = std::move(model);
}

}  // namespace emberline
