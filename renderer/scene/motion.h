// Transforms and vertices while the shutter is open, as Embree has them between two time steps.
// Private to this folder.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "renderer/core/vector.h"
#include "renderer/scene/embree_api.h"

namespace emberline::scene_detail {

// Transforms that Embree turns rather than shears from one to the next: each is a triangular matrix
// (sizes and skews), then a rotation, then a shift. Consecutive rotations go the shorter way.
std::vector<RTCQuaternionDecomposition> decompose(std::span<const Mat44d> steps);

// Between which time steps a time lies, `count` of them evenly over [0, 1]; the very floats that
// Embree reckons with.
struct TimeSegment {
  size_t step = 0;
  float share = 0.0f;  // of step + 1

  TimeSegment(float time, size_t count) {
    const float scaled = time * float(count - 1);
    step = std::min(size_t(std::max(scaled, 0.0f)), count - 2);
    share = scaled - float(step);
  }
};

}  // namespace emberline::scene_detail
