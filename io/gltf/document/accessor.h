// Reads the elements of a checked accessor as floats or integers.
#pragma once

#include "io/gltf/document/document.h"
#include "renderer/core/vector.h"

namespace emberline {

// Throws InputError at `place` if an accessor without data declares too many zeros for the size of
// the file.
void check_zero_count(const GltfDocument& document, int accessor, const std::string& place);

// Reads all elements, or only `elements` (ascending, below the accessor's count). The result has
// the components of each element together. Integers are normalised if the accessor says so
// (specification section 3.11: signed c / (2^(n-1) - 1), at least -1); otherwise they are converted
// to floats. Sparse values are applied. Throws InputError at `place` if the accessor does not have
// `components` components or fails check_zero_count().
std::vector<float> read_floats(const GltfDocument& document, int accessor, int components,
                               const std::string& place,
                               const std::vector<uint32_t>* elements = nullptr);

// These two functions split read_floats() into two steps, for callers with their own storage.
// check_floats() throws the errors before anything is allocated. copy_floats() then reads the
// floats. It reads directly into `out` if the file stores them as floats without gaps.
void check_floats(const GltfDocument& document, int accessor, int components,
                  const std::string& place);
void copy_floats(const GltfDocument& document, int accessor, const std::string& place,
                 const std::vector<uint32_t>* elements, float* out);

// These read vertex indices (scalars of an unsigned integer type) in the same two steps.
// check_indices() returns the number of indices, and copy_indices() reads them.
uint64_t check_indices(const GltfDocument& document, int accessor, const std::string& place);
void copy_indices(const GltfDocument& document, int accessor, const std::string& place,
                  uint32_t* out);

// Reads one component. The Draco reader uses this function too.
float read_component(const uint8_t* bytes, int component_type, bool normalized);

}  // namespace emberline
