// Which Embree this binary runs with, and which of its kernels trace the rays. Embree has them for
// each instruction set; hits differ between some by rounding (AVX2 fuses products and sums), so a
// frame's bits depend on which it is.
#pragma once

#include <span>
#include <string>

#include "renderer/core/names.h"

namespace emberline {

enum class EmbreeIsa { kSse42, kAvx2, kAvx512, kNeon };

std::string embree_version();  // "3.13.5"

// Those of this kind of processor, the narrowest first. A machine has the narrower ones, too.
std::span<const NamedValue<EmbreeIsa>> embree_isa_table();
// That this machine and its Embree have.
EmbreeIsa widest_isa();

}  // namespace emberline
