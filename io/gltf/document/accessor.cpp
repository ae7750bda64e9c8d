#include "io/gltf/document/accessor.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "renderer/core/errors.h"

namespace emberline {
namespace {

constexpr int kUint32Type = 5125, kFloatType = 5126;

template <class T>
T load(const uint8_t* bytes) {
  T value;  // copied, since the data may be misaligned
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

template <class Integer, class Real>
float read_integer(const uint8_t* bytes, bool normalized) {
  const Real value = load<Integer>(bytes);
  if (!normalized) return float(value);
  return float(std::max(value / Real(std::numeric_limits<Integer>::max()), Real(-1)));
}

uint32_t read_unsigned(const uint8_t* bytes, int component_type) {
  switch (component_type) {
    case 5121:
      return load<uint8_t>(bytes);
    case 5123:
      return load<uint16_t>(bytes);
    default:
      return load<uint32_t>(bytes);
  }
}

// Returns the first element, or null if none. The elements are `accessor.stride` bytes apart.
const uint8_t* accessor_bytes(const GltfDocument& document, const GltfAccessor& accessor) {
  if (accessor.count == 0) return nullptr;
  const uint64_t element_size = uint64_t(accessor.component_size) * uint64_t(accessor.components);
  return document
      .bytes(accessor.view, accessor.offset, (accessor.count - 1) * accessor.stride + element_size)
      .data();
}

// Calls visit(element, bytes) for each sparse replacement, in file order.
template <class Visit>
void for_each_sparse(const GltfDocument& document, const GltfAccessor& accessor,
                     const std::string& place, const Visit& visit) {
  const GltfAccessor::Sparse& sparse = accessor.sparse;
  if (sparse.count == 0) return;
  const size_t index_size = sparse.index_type == 5121 ? 1 : sparse.index_type == 5123 ? 2 : 4;
  const size_t element_size = size_t(accessor.component_size * accessor.components);
  const uint8_t* indices =
      document.bytes(sparse.index_view, sparse.index_offset, sparse.count * index_size).data();
  const uint8_t* values =
      document.bytes(sparse.value_view, sparse.value_offset, sparse.count * element_size).data();
  for (size_t i = 0; i < sparse.count; ++i) {
    const uint32_t element = read_unsigned(indices + i * index_size, sparse.index_type);
    if (element >= accessor.count) {
      throw InputError(place, "its accessor has a sparse index {}, but only {} elements", element,
                       accessor.count);
    }
    visit(element, values + i * element_size);
  }
}

}  // namespace

void check_zero_count(const GltfDocument& document, int index, const std::string& place) {
  const GltfAccessor& accessor = document.accessor(index);
  if (accessor.view >= 0 || accessor.count <= document.max_zeros) return;
  throw InputError(place, "its accessor declares " + std::to_string(accessor.count) +
                              " elements without data, too many for a file of this size");
}

float read_component(const uint8_t* bytes, int component_type, bool normalized) {
  switch (component_type) {
    case 5120:
      return read_integer<int8_t, float>(bytes, normalized);
    case 5121:
      return read_integer<uint8_t, float>(bytes, normalized);
    case 5122:
      return read_integer<int16_t, float>(bytes, normalized);
    case 5123:
      return read_integer<uint16_t, float>(bytes, normalized);
    case 5125:
      return read_integer<uint32_t, double>(bytes, normalized);
    default:
      return load<float>(bytes);
  }
}

void check_floats(const GltfDocument& document, int index, int components,
                  const std::string& place) {
  const GltfAccessor& accessor = document.accessor(index);
  if (accessor.components != components) {
    throw InputError(place, "accessor {} has {} components, expected {}", index,
                     accessor.components, components);
  }
  check_zero_count(document, index, place);
}

void copy_floats(const GltfDocument& document, int index, const std::string& place,
                 const std::vector<uint32_t>* elements, float* out) {
  const GltfAccessor& accessor = document.accessor(index);
  const int type = accessor.component_type;
  const auto components = size_t(accessor.components);
  const size_t count = elements ? elements->size() : accessor.count;
  const size_t element_size = components * sizeof(float);
  const auto convert = [&](size_t element, const uint8_t* bytes) {
    for (size_t c = 0; c < components; ++c) {
      out[element * components + c] =
          read_component(bytes + c * size_t(accessor.component_size), type, accessor.normalized);
    }
  };
  if (accessor.view < 0) {
    std::fill_n(out, count * components, 0.0f);
  } else if (!elements && type == kFloatType && accessor.stride == element_size) {
    document.copy_bytes(accessor.view, accessor.offset, count * element_size, out);
  } else {
    const uint8_t* bytes = accessor_bytes(document, accessor);
    for (size_t i = 0; i < count; ++i) {
      convert(i, bytes + (elements ? (*elements)[i] : i) * accessor.stride);
    }
  }
  for_each_sparse(document, accessor, place, [&](uint32_t element, const uint8_t* bytes) {
    if (!elements) return convert(element, bytes);
    const auto found = std::ranges::lower_bound(*elements, element);
    if (found != elements->end() && *found == element) {
      convert(size_t(found - elements->begin()), bytes);
    }
  });
}

std::vector<float> read_floats(const GltfDocument& document, int index, int components,
                               const std::string& place, const std::vector<uint32_t>* elements) {
  check_floats(document, index, components, place);
  const size_t count = elements ? elements->size() : document.accessor(index).count;
  std::vector<float> values(count * size_t(components));
  copy_floats(document, index, place, elements, values.data());
  return values;
}

uint64_t check_indices(const GltfDocument& document, int index, const std::string& place) {
  const GltfAccessor& accessor = document.accessor(index);
  const int type = accessor.component_type;
  if (accessor.components != 1 || (type != 5121 && type != 5123 && type != kUint32Type)) {
    throw InputError(place, "accessor {} does not hold unsigned integer scalars", index);
  }
  check_zero_count(document, index, place);
  return accessor.count;
}

void copy_indices(const GltfDocument& document, int index, const std::string& place,
                  uint32_t* out) {
  const GltfAccessor& accessor = document.accessor(index);
  const int type = accessor.component_type;
  if (accessor.view < 0) {
    std::fill_n(out, accessor.count, 0u);
  } else if (type == kUint32Type && accessor.stride == sizeof(uint32_t)) {
    document.copy_bytes(accessor.view, accessor.offset, accessor.count * sizeof(uint32_t), out);
  } else {
    const uint8_t* bytes = accessor_bytes(document, accessor);
    for (size_t i = 0; i < accessor.count; ++i) {
      out[i] = read_unsigned(bytes + i * accessor.stride, type);
    }
  }
  for_each_sparse(document, accessor, place, [&](size_t element, const uint8_t* bytes) {
    out[element] = read_unsigned(bytes, type);
  });
}

}  // namespace emberline
