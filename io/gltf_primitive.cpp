#include "io/gltf_primitive.h"

#include <algorithm>
#include <numeric>

#include "io/gltf_accessor.h"
#include "renderer/core/errors.h"

namespace emberline {

using nlohmann::json;

namespace {

constexpr const char* kDracoExtension = "KHR_draco_mesh_compression";

}  // namespace

PrimitiveReader::PrimitiveReader(const GltfDocument& document, const json& primitive,
                                 std::string pointer)
    : document_(document), primitive_(primitive), pointer_(std::move(pointer)) {
  if (const json* extension = find_extension(primitive, kDracoExtension)) {
    try {
      read_draco(*extension);
      return;
    } catch (const InputError& error) {
      GltfFaults::let_limits_pass(error);
      if (document.requires_extension(kDracoExtension) || !has_fallback()) throw;
      draco_.reset();
      draco_fault_ = error;
    }
  } else if (!has_fallback()) {
    // Of an extension that check_schema has left out: what it is the compressed form of is nothing.
    document.faults->require(pointer_ + "/extensions/" + kDracoExtension);
  }
  vertex_count_ = document.accessor(accessor("POSITION")).count;
  indices_ = read_corners();
  choose_vertices();
}

void PrimitiveReader::read_draco(const json& extension) {
  const std::string place = document_.place(pointer_ + "/extensions/" + kDracoExtension);
  std::vector<DracoRequest> requests;
  for (const auto& [name, id] : extension.at("attributes").items()) {
    if (!usable(name)) continue;
    const GltfAccessor& described = document_.accessor(accessor(name));
    requests.push_back({name, id.get<uint32_t>(), described.components, described.normalized});
  }
  const json* index_accessor = find_member(primitive_, "indices");
  if (!index_accessor) throw InputError(place, "a Draco primitive needs an indices accessor");
  const uint64_t index_count = document_.accessor(index_accessor->get<int>()).count;
  draco_ = decode_draco(document_.bytes(extension.at("bufferView").get<int>()), requests,
                        index_count, place, *document_.progress);
  if (!draco_->attributes.contains("POSITION")) {
    document_.accessor(accessor("POSITION"));
    throw InputError(place, "the Draco data has no positions");
  }
  vertex_count_ = draco_->vertex_count;
  indices_ = std::move(draco_->indices);
}

// Whether indices and all that the Draco stream holds have bytes of their own.
bool PrimitiveReader::has_fallback() const {
  const auto has_bytes = [&](const json& index) {
    return !index.is_null() && document_.accessors[index.get<size_t>()].view >= 0;
  };
  const json* indices = find_member(primitive_, "indices");
  const json& attributes = primitive_.at("attributes");
  return indices && has_bytes(*indices) && std::ranges::all_of(attributes, has_bytes);
}

int PrimitiveReader::accessor(const std::string& attribute) const {
  const json& index = primitive_.at("attributes").at(attribute);
  if (index.is_null()) document_.faults->require(pointer_ + "/attributes/" + attribute);
  return index.get<int>();
}

bool PrimitiveReader::has(const std::string& attribute) const {
  return primitive_.at("attributes").contains(attribute);
}

bool PrimitiveReader::usable(const std::string& attribute) const {
  const json* index = find_member(primitive_.at("attributes"), attribute.c_str());
  return index && !index->is_null() && document_.accessors[index->get<size_t>()].components > 0;
}

int PrimitiveReader::components(const std::string& attribute) const {
  return document_.accessor(accessor(attribute)).components;
}

std::vector<float> PrimitiveReader::floats(const std::string& attribute, int components) const {
  const std::string place = document_.place(pointer_ + "/attributes/" + attribute);
  if (draco_) {
    const auto found = draco_->attributes.find(attribute);
    if (found != draco_->attributes.end()) {
      if (found->second.size() != vertex_count_ * uint64_t(components)) {
        throw InputError(place, "expected {} components", components);
      }
      return found->second;
    }
  }
  return read(accessor(attribute), components, place);
}

std::vector<float> PrimitiveReader::target_floats(size_t target, const std::string& attribute,
                                                  int components) const {
  const json& attributes = primitive_.at("targets")[target];
  const json* member = find_member(attributes, attribute.c_str());
  if (!member) return {};
  const std::string pointer = pointer_ + "/targets/" + std::to_string(target) + "/" + attribute;
  const std::string place = document_.place(pointer);
  if (member->is_null()) document_.faults->require(pointer);
  return read(member->get<int>(), components, place);
}

std::vector<float> PrimitiveReader::read(int index, int components,
                                         const std::string& place) const {
  const uint64_t count = document_.accessor(index).count;
  if (count != vertex_count_) {
    throw InputError(place, "{} elements for {} vertices", count, vertex_count_);
  }
  return read_floats(document_, index, components, place, used_.empty() ? nullptr : &used_);
}

// A few triangles each of thousands of primitives may name one accessor of a million vertices.
void PrimitiveReader::choose_vertices() {
  constexpr uint64_t kFew = 4;  // a quarter: below, sorting costs less than reading all
  if (indices_.empty() || indices_.size() > vertex_count_ / kFew) return;
  used_ = indices_;
  std::ranges::sort(used_);
  used_.erase(std::unique(used_.begin(), used_.end()), used_.end());
  for (uint32_t& index : indices_) {
    index = uint32_t(std::ranges::lower_bound(used_, index) - used_.begin());
  }
}

std::vector<uint32_t> PrimitiveReader::read_corners() const {
  const json* member = find_member(primitive_, "indices");
  if (!member) {
    check_zeros(document_, accessor("POSITION"),
                document_.place(pointer_ + "/attributes/POSITION"));
    std::vector<uint32_t> all(vertex_count_);
    std::iota(all.begin(), all.end(), 0u);
    return all;
  }
  const std::string place = document_.place(pointer_ + "/indices");
  std::vector<uint32_t> values = read_indices(document_, member->get<int>(), place);
  for (size_t i = 0; i < values.size(); ++i) {
    if (values[i] >= vertex_count_) {
      throw InputError(place, "index {} of its accessor is {}, but there are only {} vertices", i,
                       values[i], vertex_count_);
    }
  }
  return values;
}

}  // namespace emberline
