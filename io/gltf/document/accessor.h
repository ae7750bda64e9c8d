// Reads the elements of a checked accessor as floats or integers.
#pragma once

#include "io/gltf/document/document.h"
#include "renderer/core/vector.h"

namespace emberline {

// An accessor without a buffer view consists of zeros. Throws InputError at `place` if it declares
// more elements than GltfDocument::max_zeros.
void check_zero_count(const GltfDocument& document, int accessor, const std::string& place);

// Reads all elements, or only `elements` (ascending, below the accessor's count). In the result,
// the components of each element are adjacent. Integers are normalised if the accessor says so
// (specification section 3.11: signed c / (2^(n-1) - 1), at least -1); otherwise they are converted
// to floats. Sparse values are applied. Throws InputError at `place` if the accessor does not have
// `components` components or fails check_zero_count().
std::vector<float> read_floats(const GltfDocument& document, int accessor, int components,
                               const std::string& place,
                               const std::vector<uint32_t>* elements = nullptr);

// These two functions split read_floats() into two steps, for callers with their own storage.
// check_floats() checks the accessor before the caller allocates memory. copy_floats() then reads
// the elements. If the file stores them as floats without gaps, they are read directly into `out`.
void check_floats(const GltfDocument& document, int accessor, int components,
                  const std::string& place);
void copy_floats(const GltfDocument& document, int accessor, const std::string& place,
                 const std::vector<uint32_t>* elements, float* out);

// These read vertex indices (scalars of an unsigned integer type) in the same two steps.
// check_indices() returns the number of indices, and copy_indices() reads them.
uint64_t check_indices(const GltfDocument& document, int accessor, const std::string& place);
void copy_indices(const GltfDocument& document, int accessor, const std::string& place,
                  uint32_t* out);

// Reads one component, also for the Draco reader.
float read_component(const uint8_t* bytes, int component_type, bool normalized);

}  // namespace emberline
