// A tree of emitter points that finds the points within reach of a surface. Private to this folder.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "renderer/core/vector.h"

namespace emberline::scene_detail {

struct EmitterPoint {
  Vec3d position;
  float error;  // plane error of the emitter's triangle
  uint32_t emitter;
};

// A query for points in a box and near a plane. For each point, the box and the plane are widened
// by `margin` plus twice the point's error. If the normal is 0, there is no plane.
struct PointSearch {
  Vec3f lower, upper;
  Vec3d plane, normal;
  float margin;
};

// Immutable, thread-safe and deterministic.
class EmitterPoints {
 public:
  explicit EmitterPoints(std::vector<EmitterPoint> points);

  bool empty() const { return points_.empty(); }
  // Calls visit(point) for all points that match the query, and possibly others, in tree order.
  // Stops and returns false once visit() returns false.
  template <typename Visit>
  bool visit(const PointSearch& search, const Visit& visit) const;

 private:
  struct Node {
    Vec3f lower, upper;  // bounds of the points, widened by twice their errors
    uint32_t begin, end;
    uint32_t right = 0;  // 0 for a leaf; the left child is the next node
  };
  uint32_t build(uint32_t begin, uint32_t end);
  static bool may_contain(const Node& node, const PointSearch& s) {
    double distance = 0.0, half = double(s.margin);
    for (int c = 0; c < 3; ++c) {
      if (node.lower[c] > s.upper[c] + s.margin || node.upper[c] < s.lower[c] - s.margin) {
        return false;
      }
      const double lower = double(node.lower[c]), upper = double(node.upper[c]);
      distance += s.normal[c] * (0.5 * (lower + upper) - s.plane[c]);
      half += std::abs(s.normal[c]) * 0.5 * (upper - lower);
    }
    return std::abs(distance) <= half;
  }

  std::vector<EmitterPoint> points_;
  std::vector<Node> nodes_;
};

template <typename Visit>
bool EmitterPoints::visit(const PointSearch& search, const Visit& visit) const {
  if (nodes_.empty()) return true;
  uint32_t stack[64];
  int stack_size = 0;
  stack[stack_size++] = 0;
  while (stack_size > 0) {
    const uint32_t index = stack[--stack_size];
    const Node& node = nodes_[index];
    if (!may_contain(node, search)) continue;
    if (node.right != 0) {
      stack[stack_size++] = node.right;
      stack[stack_size++] = index + 1;
      continue;
    }
    for (uint32_t i = node.begin; i < node.end; ++i) {
      if (!visit(points_[i])) return false;
    }
  }
  return true;
}

}  // namespace emberline::scene_detail
