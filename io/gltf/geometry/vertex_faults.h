// Vertices of which some attribute beside the position is NaN or infinite.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace emberline {

class VertexFaults {
 public:
  // An attribute's numbers, vertex by vertex.
  void look_at(std::span<const float> values, size_t components);
  template <class Vector>
  void look_at(const std::vector<Vector>& values) {
    constexpr size_t kComponents = sizeof(Vector) / sizeof(float);
    look_at({reinterpret_cast<const float*>(values.data()), values.size() * kComponents},
            kComponents);
  }
  // Those that triangles use.
  uint64_t count(std::span<const std::array<uint32_t, 3>> triangles) const;

 private:
  std::vector<uint8_t> is_faulty_;  // empty: none is
};

}  // namespace emberline
