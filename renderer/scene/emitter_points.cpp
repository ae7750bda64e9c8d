#include "renderer/scene/emitter_points.h"

#include <algorithm>

namespace emberline::scene_detail {

constexpr uint32_t kMaxLeafPoints = 8;  // maximum number of points in a leaf; chosen by us

EmitterPoints::EmitterPoints(std::vector<EmitterPoint> points) : points_(std::move(points)) {
  nodes_.reserve(points_.size() / kMaxLeafPoints * 4 + 1);
  if (!points_.empty()) build(0, uint32_t(points_.size()));
}

// Splits at the median along the widest axis, so the depth is log2 of the number of points.
uint32_t EmitterPoints::build(uint32_t begin, uint32_t end) {
  const auto index = uint32_t(nodes_.size());
  Node node;
  node.begin = begin;
  node.end = end;
  node.lower = node.upper = to_float(points_[begin].position);
  for (uint32_t i = begin; i < end; ++i) {
    const EmitterPoint& p = points_[i];
    const Vec3f at = to_float(p.position);  // rounding changes it by far less than p.error
    for (int c = 0; c < 3; ++c) {
      node.lower[c] = std::min(node.lower[c], at[c] - 2.0f * p.error);
      node.upper[c] = std::max(node.upper[c], at[c] + 2.0f * p.error);
    }
  }
  nodes_.push_back(node);
  if (end - begin <= kMaxLeafPoints) return index;
  const Vec3f extent = node.upper - node.lower;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const uint32_t middle = begin + (end - begin) / 2;
  const auto at = [&](uint32_t i) { return points_.begin() + std::ptrdiff_t(i); };
  std::nth_element(at(begin), at(middle), at(end),
                   [axis](const EmitterPoint& a, const EmitterPoint& b) {
                     const double x = a.position[axis], y = b.position[axis];
                     return x != y ? x < y : a.emitter < b.emitter;
                   });
  build(begin, middle);
  nodes_[index].right = build(middle, end);
  return index;
}

}  // namespace emberline::scene_detail
