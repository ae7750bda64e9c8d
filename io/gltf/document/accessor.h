// Elements of a checked accessor as floats or integers.
#pragma once

#include "io/gltf/document/document.h"
#include "renderer/core/vector.h"

namespace emberline {

// Throws InputError naming `place` if the accessor stands for more zeros than the size of the file
// bears out.
void check_zeros(const GltfDocument& document, int accessor, const std::string& place);

// All elements, components interleaved. Integers are normalised if the accessor says so
// (specification section 3.11: signed c / (2^(n-1) - 1), at least -1), else kept as numbers.
// Sparse values are applied. Throws InputError naming `place` if the accessor does not have
// `components` components or its count is not borne out by data.
// `elements`: these alone, growing numbers below the accessor's count.
std::vector<float> read_floats(const GltfDocument& document, int accessor, int components,
                               const std::string& place,
                               const std::vector<uint32_t>* elements = nullptr);

// The two halves of it, for whoever has a place for the floats: what it throws of the accessor,
// before anything is allocated for it; and the floats, read there without a detour where the file
// has them so.
void check_floats(const GltfDocument& document, int accessor, int components,
                  const std::string& place);
void copy_floats(const GltfDocument& document, int accessor, const std::string& place,
                 const std::vector<uint32_t>* elements, float* out);

// Scalars of an unsigned integer type, vertex indices, in the same two halves: how many there are,
// after the checks; and they.
uint64_t check_indices(const GltfDocument& document, int accessor, const std::string& place);
void copy_indices(const GltfDocument& document, int accessor, const std::string& place,
                  uint32_t* out);

// One component at `bytes`; shared with the Draco reader.
float read_component(const uint8_t* bytes, int component_type, bool normalized);

}  // namespace emberline
