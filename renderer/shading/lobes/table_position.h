// A position between two neighbouring nodes of a table.
#pragma once

#include <algorithm>
#include <cstddef>

namespace emberline {

struct TablePosition {
  size_t index;    // of the first node
  float fraction;  // towards the second node
  TablePosition() = default;
  // Converts `at`, clamped to [0, 1], to a position among `size` nodes.
  TablePosition(float at, int size) {
    const float clamped = std::clamp(at, 0.0f, 1.0f) * float(size - 1);
    const int i = std::min(int(clamped), size - 2);
    index = size_t(i);
    fraction = clamped - float(i);
  }
};

}  // namespace emberline
