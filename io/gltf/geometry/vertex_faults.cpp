#include "io/gltf/geometry/vertex_faults.h"

#include <algorithm>
#include <cmath>

namespace emberline {

void VertexFaults::look_at(std::span<const float> values, size_t components) {
  // Most attributes have no fault. 0 times a number is 0, else NaN.
  constexpr size_t kAtOnce = 16;
  float sums[kAtOnce] = {};
  size_t next = 0;
  for (; next + kAtOnce <= values.size(); next += kAtOnce) {
    for (size_t k = 0; k < kAtOnce; ++k) sums[k] += values[next + k] * 0.0f;
  }
  for (; next < values.size(); ++next) sums[0] += values[next] * 0.0f;
  if (std::ranges::all_of(sums, [](float sum) { return sum == 0.0f; })) return;
  is_faulty_.resize(std::max(is_faulty_.size(), values.size() / components));
  for (size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) is_faulty_[i / components] = 1;
  }
}

uint64_t VertexFaults::count(std::span<const std::array<uint32_t, 3>> triangles) const {
  if (is_faulty_.empty()) return 0;
  std::vector<uint8_t> left = is_faulty_;
  uint64_t count = 0;
  for (const std::array<uint32_t, 3>& triangle : triangles) {
    for (const uint32_t v : triangle) {
      count += left[v];
      left[v] = 0;
    }
  }
  return count;
}

}  // namespace emberline
