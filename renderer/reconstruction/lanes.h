// Sixteen pixels of a row in registers. The compiler keeps a Lanes in registers, while it would
// write an array back to memory in each iteration of a loop.
#pragma once

#include <cstddef>

namespace emberline {

inline constexpr int kLanes = 16;

// Two GCC or Clang vectors of AVX register size; each lane is rounded like a float. If the
// processor has no registers for sixteen floats, a single vector of sixteen floats would go through
// memory at each load, and the filter would take 1.6 times as long.
struct Lanes {
  using Part [[gnu::vector_size(32)]] = float;

  Part low, high;

  float& operator[](int lane) { return reinterpret_cast<float*>(this)[lane]; }
  float operator[](int lane) const { return reinterpret_cast<const float*>(this)[lane]; }

  [[gnu::always_inline]] friend Lanes operator+(const Lanes& a, const Lanes& b) {
    return {a.low + b.low, a.high + b.high};
  }
  [[gnu::always_inline]] friend Lanes operator-(const Lanes& a, const Lanes& b) {
    return {a.low - b.low, a.high - b.high};
  }
  [[gnu::always_inline]] friend Lanes operator*(const Lanes& a, const Lanes& b) {
    return {a.low * b.low, a.high * b.high};
  }
  [[gnu::always_inline]] friend Lanes operator*(float a, const Lanes& b) {
    return {a * b.low, a * b.high};
  }
  [[gnu::always_inline]] Lanes& operator+=(const Lanes& b) { return *this = *this + b; }
  [[gnu::always_inline]] Lanes& operator-=(const Lanes& b) { return *this = *this - b; }
  [[gnu::always_inline]] Lanes& operator*=(const Lanes& b) { return *this = *this * b; }
};

[[gnu::always_inline]] inline Lanes all_lanes(float value) {
  const Lanes::Part part = Lanes::Part{} + value;
  return {part, part};
}
[[gnu::always_inline]] inline Lanes min_lanes(const Lanes& a, const Lanes& b) {
  return {a.low < b.low ? a.low : b.low, a.high < b.high ? a.high : b.high};
}
[[gnu::always_inline]] inline Lanes max_lanes(const Lanes& a, const Lanes& b) {
  return {a.low > b.low ? a.low : b.low, a.high > b.high ? a.high : b.high};
}

// Unaligned loads and stores of sixteen or eight floats.
using UnalignedPart [[gnu::vector_size(32), gnu::aligned(4), gnu::may_alias]] = float;
[[gnu::always_inline]] inline void load(const float* from, Lanes::Part& to) {
  to = *reinterpret_cast<const UnalignedPart*>(from);
}
[[gnu::always_inline]] inline void load(const float* from, Lanes& to) {
  load(from, to.low);
  load(from + kLanes / 2, to.high);
}
[[gnu::always_inline]] inline void store(const Lanes::Part& from, float* to) {
  *reinterpret_cast<UnalignedPart*>(to) = from;
}
[[gnu::always_inline]] inline void store(const Lanes& from, float* to) {
  store(from.low, to);
  store(from.high, to + kLanes / 2);
}

}  // namespace emberline
