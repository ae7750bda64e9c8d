// The version of Embree and the kernels that trace the rays. Embree has kernels for each
// instruction set. Some kernels round hits differently (AVX2 fuses products and sums), so a frame's
// bits depend on the kernels.
#pragma once

#include <span>
#include <string>

#include "renderer/core/names.h"

namespace emberline {

enum class EmbreeIsa { kSse42, kAvx2, kAvx512, kNeon };

std::string embree_version();  // such as "3.13.5"

// Returns the kernels for this processor architecture, narrowest first. A machine that supports
// some kernels also supports all narrower ones.
std::span<const NamedValue<EmbreeIsa>> embree_isa_table();
// Returns the widest kernels that this machine and its Embree support.
EmbreeIsa widest_isa();

}  // namespace emberline
