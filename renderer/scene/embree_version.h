// Which Embree this binary runs with.
#pragma once

#include <string>

namespace emberline {

std::string embree_version();  // "3.13.5"
// The widest vectors that its kernels use on this machine: "AVX-512", "AVX", "SSE" or "Neon".
std::string embree_instruction_set();

}  // namespace emberline
