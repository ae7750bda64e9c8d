// The version of Embree and the kernels that trace the rays. Embree has kernels for each
// instruction set. With some of them, hits differ by rounding (AVX2 fuses products and sums), so a
// frame's bits depend on the kernels.
#pragma once

#include <span>
#include <string>

#include "renderer/core/names.h"

namespace emberline {

enum class EmbreeIsa { kSse42, kAvx2, kAvx512, kNeon };

std::string embree_version();  // "3.13.5"

// The kernels for this processor architecture, narrowest first. A machine that supports one of them
// supports all narrower ones.
std::span<const NamedValue<EmbreeIsa>> embree_isa_table();
// The widest kernels that this machine and its Embree support.
EmbreeIsa widest_isa();

}  // namespace emberline
