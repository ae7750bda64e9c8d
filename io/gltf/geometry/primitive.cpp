#include "io/gltf/geometry/primitive.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>
#include <utility>

#include "io/gltf/document/accessor.h"
#include "renderer/core/errors.h"

namespace emberline {

using nlohmann::json;

constexpr const char* kDracoExtension = "KHR_draco_mesh_compression";

PrimitiveReader::PrimitiveReader(const GltfDocument& document, const json& primitive,
                                 std::string pointer)
    : document_(document), primitive_(primitive), pointer_(std::move(pointer)) {
  if (const json* extension = find_extension(primitive, kDracoExtension)) {
    try {
      read_draco(*extension);
      return;
    } catch (const InputError& error) {
      GltfFaults::rethrow_limit_error(error);
      if (document.requires_extension(kDracoExtension) || !has_fallback()) throw;
      draco_.reset();
      draco_fault_ = error;
    }
  } else if (!has_fallback()) {
    // If check_schema() removed the extension, no data are left. require() then throws the
    // extension's fault.
    document.faults->require(pointer_ + "/extensions/" + kDracoExtension);
  }
  vertex_count_ = document.accessor(accessor("POSITION")).count;
  read_corners();
  select_used_vertices();
}

void PrimitiveReader::read_draco(const json& extension) {
  const std::string place = document_.place(pointer_ + "/extensions/" + kDracoExtension);
  std::vector<DracoRequest> requests;
  for (const auto& [name, id] : extension.at("attributes").items()) {
    if (!is_intact(name)) continue;
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
  set_index_count(draco_->indices.size());
  std::ranges::copy(draco_->indices, corners());
  draco_->indices = std::vector<uint32_t>();
}

void PrimitiveReader::set_index_count(uint64_t count) {
  triangles_.resize(count / 3 + (count % 3 != 0));
  index_count_ = count;
}

std::vector<std::array<uint32_t, 3>> PrimitiveReader::take_triangles() {
  triangles_.resize(std::exchange(index_count_, 0) / 3);
  return std::move(triangles_);
}

// Whether the indices and all attributes have uncompressed data.
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

bool PrimitiveReader::is_intact(const std::string& attribute) const {
  const json* index = find_member(primitive_.at("attributes"), attribute.c_str());
  return index && !index->is_null() && document_.accessors[index->get<size_t>()].components > 0;
}

int PrimitiveReader::components(const std::string& attribute) const {
  return document_.accessor(accessor(attribute)).components;
}

std::string PrimitiveReader::place_of(const std::string& attribute) const {
  return document_.place(pointer_ + "/attributes/" + attribute);
}

// Returns the attribute's values from the Draco stream, or null.
const std::vector<float>* PrimitiveReader::draco_floats(const std::string& attribute) const {
  if (!draco_) return nullptr;
  const auto found = draco_->attributes.find(attribute);
  return found == draco_->attributes.end() ? nullptr : &found->second;
}

// Checks the attribute before memory is allocated for it.
void PrimitiveReader::check(const std::string& attribute, int components) const {
  if (const std::vector<float>* decoded = draco_floats(attribute)) {
    if (decoded->size() == vertex_count_ * uint64_t(components)) return;
    throw InputError(place_of(attribute), "expected {} components", components);
  }
  const int index = accessor(attribute);
  check_count(index, place_of(attribute));
  check_floats(document_, index, components, place_of(attribute));
}

void PrimitiveReader::copy(const std::string& attribute, int components, float* out) const {
  if (const std::vector<float>* decoded = draco_floats(attribute)) {
    std::copy_n(decoded->data(), vertex_count_ * uint64_t(components), out);
  } else {
    copy_floats(document_, accessor(attribute), place_of(attribute), selected_vertices(), out);
  }
}

std::vector<float> PrimitiveReader::floats(const std::string& attribute, int components) const {
  check(attribute, components);
  std::vector<float> values(vertex_count() * uint64_t(components));
  copy(attribute, components, values.data());
  return values;
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

void PrimitiveReader::check_count(int index, const std::string& place) const {
  const uint64_t count = document_.accessor(index).count;
  if (count == vertex_count_) return;
  throw InputError(place, "found {} elements for {} vertices", count, vertex_count_);
}

std::vector<float> PrimitiveReader::read(int index, int components,
                                         const std::string& place) const {
  check_count(index, place);
  return read_floats(document_, index, components, place, selected_vertices());
}

// If the indices use few vertices, keeps only these. This speeds up files in which thousands of
// primitives each use a few triangles of one huge accessor.
void PrimitiveReader::select_used_vertices() {
  // If there is at most one index for every four vertices, sorting the indices costs less than
  // reading all vertices.
  constexpr uint64_t kFew = 4;
  if (index_count_ == 0 || index_count_ > vertex_count_ / kFew) return;
  used_vertices_.assign(corners(), corners() + index_count_);
  std::ranges::sort(used_vertices_);
  used_vertices_.erase(std::unique(used_vertices_.begin(), used_vertices_.end()),
                       used_vertices_.end());
  for (uint32_t& index : std::span(corners(), index_count_)) {
    index = uint32_t(std::ranges::lower_bound(used_vertices_, index) - used_vertices_.begin());
  }
}

void PrimitiveReader::read_corners() {
  const json* member = find_member(primitive_, "indices");
  if (!member) {
    check_zero_count(document_, accessor("POSITION"), place_of("POSITION"));
    set_index_count(vertex_count_);
    std::iota(corners(), corners() + index_count_, 0u);
    return;
  }
  const std::string place = document_.place(pointer_ + "/indices");
  set_index_count(check_indices(document_, member->get<int>(), place));
  copy_indices(document_, member->get<int>(), place, corners());
  const std::span<const uint32_t> values = indices();
  if (values.empty() || std::ranges::max(values) < vertex_count_) return;
  const auto beyond = std::ranges::find_if(values, [&](uint32_t v) { return v >= vertex_count_; });
  throw InputError(place, "index {} of its accessor is {}, but there are only {} vertices",
                   beyond - values.begin(), *beyond, vertex_count_);
}

}  // namespace emberline
