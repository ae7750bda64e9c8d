#include "io/gltf_primitive.h"

#include <numeric>

#include "io/gltf_accessor.h"
#include "renderer/core/errors.h"

namespace emberline {

using nlohmann::json;

PrimitiveReader::PrimitiveReader(const GltfDocument& document, const json& primitive,
                                 std::string pointer)
    : document_(document), primitive_(primitive), pointer_(std::move(pointer)) {
  const uint64_t announced = document.accessors[size_t(accessor("POSITION"))].count;
  const json* extension = find_extension(primitive, "KHR_draco_mesh_compression");
  if (!extension) {
    vertex_count_ = announced;
    return;
  }
  const std::string place = document.place(pointer_ + "/extensions/KHR_draco_mesh_compression");
  std::vector<DracoRequest> requests;
  for (const auto& [name, id] : extension->at("attributes").items()) {
    if (!has(name)) continue;
    const GltfAccessor& described = document.accessors[size_t(accessor(name))];
    requests.push_back({name, id.get<uint32_t>(), described.components, described.normalized});
  }
  const json* index_accessor = find_member(primitive, "indices");
  if (!index_accessor) throw InputError(place, "a Draco primitive needs an indices accessor");
  const uint64_t index_count = document.accessors[index_accessor->get<size_t>()].count;
  draco_ = decode_draco(document.bytes(extension->at("bufferView").get<int>()), requests,
                        index_count, place);
  vertex_count_ = draco_->vertex_count;
  if (!draco_->attributes.contains("POSITION")) {
    throw InputError(place, "the Draco data has no positions");
  }
}

int PrimitiveReader::accessor(const std::string& attribute) const {
  return primitive_.at("attributes").at(attribute).get<int>();
}

bool PrimitiveReader::has(const std::string& attribute) const {
  return primitive_.at("attributes").contains(attribute);
}

int PrimitiveReader::components(const std::string& attribute) const {
  return document_.accessors[size_t(accessor(attribute))].components;
}

std::vector<float> PrimitiveReader::floats(const std::string& attribute, int components) const {
  const std::string place = document_.place(pointer_ + "/attributes/" + attribute);
  if (draco_) {
    const auto found = draco_->attributes.find(attribute);
    if (found != draco_->attributes.end()) {
      if (found->second.size() != vertex_count_ * uint64_t(components)) {
        throw InputError(place, "expected " + std::to_string(components) + " components");
      }
      return found->second;
    }
  }
  std::vector<float> values = read_floats(document_, accessor(attribute), components, place);
  if (values.size() != vertex_count_ * uint64_t(components)) {
    throw InputError(place, std::to_string(values.size() / size_t(components)) + " elements for " +
                                std::to_string(vertex_count_) + " vertices");
  }
  return values;
}

std::vector<float> PrimitiveReader::target_floats(size_t target, const std::string& attribute,
                                                  int components) const {
  const json& attributes = primitive_.at("targets")[target];
  const json* member = find_member(attributes, attribute.c_str());
  if (!member) return {};
  const std::string place =
      document_.place(pointer_ + "/targets/" + std::to_string(target) + "/" + attribute);
  std::vector<float> values = read_floats(document_, member->get<int>(), components, place);
  if (values.size() != vertex_count_ * uint64_t(components)) {
    throw InputError(place, std::to_string(values.size() / size_t(components)) + " elements for " +
                                std::to_string(vertex_count_) + " vertices");
  }
  return values;
}

std::vector<uint32_t> PrimitiveReader::indices() const {
  if (draco_) return draco_->indices;
  const json* member = find_member(primitive_, "indices");
  if (!member) {
    std::vector<uint32_t> all(vertex_count_);
    std::iota(all.begin(), all.end(), 0u);
    return all;
  }
  const std::string place = document_.place(pointer_ + "/indices");
  std::vector<uint32_t> values = read_indices(document_, member->get<int>(), place);
  for (size_t i = 0; i < values.size(); ++i) {
    if (values[i] >= vertex_count_) {
      throw InputError(place, "index " + std::to_string(i) + " of its accessor is " +
                                  std::to_string(values[i]) + ", but there are only " +
                                  std::to_string(vertex_count_) + " vertices");
    }
  }
  return values;
}

}  // namespace emberline
