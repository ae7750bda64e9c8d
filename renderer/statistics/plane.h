// A plane of numbers, one for each pixel of a frame, and statistics of these numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace emberline {

// Rows start at the top. A non-finite number means that the pixel has no value. Statistics count
// such pixels but otherwise ignore them.
struct Plane {
  int width = 0, height = 0;
  std::vector<float> values;

  float at(int x, int y) const { return values[size_t(y) * size_t(width) + size_t(x)]; }
};

struct PlaneStatistics {
  uint64_t values = 0;                                 // pixels with a value
  uint64_t no_value = 0;                               // pixels without a value
  uint64_t nonzero = 0;                                // pixels with a value that is not 0
  double minimum = 0, mean = 0, maximum = 0, rms = 0;  // 0 without values

  bool constant() const { return values > 0 && minimum == maximum; }
};
PlaneStatistics plane_statistics(const Plane& plane);

}  // namespace emberline
