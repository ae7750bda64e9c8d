// Sixteen pixels of a row side by side, in registers: the compiler keeps them there, where it would
// write an array back in each turn of a loop.
#pragma once

#include <cstddef>
#include <cstring>

namespace emberline {

inline constexpr int kLanes = 16;
// GCC's and Clang's vectors; as many registers as the processor needs, each lane rounded as a float
// is.
using Lanes [[gnu::vector_size(kLanes * sizeof(float))]] = float;

[[gnu::always_inline]] inline void load(const float* from, Lanes& to) {
  std::memcpy(&to, from, sizeof(to));
}
[[gnu::always_inline]] inline void store(const Lanes& from, float* to) {
  std::memcpy(to, &from, sizeof(from));
}

}  // namespace emberline
