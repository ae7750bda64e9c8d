// Traversal; the construction is in light_bvh_build.cpp.
#include "renderer/lights/light_bvh.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace emberline {
namespace {

// Added to cosines before they decide that nothing arrives: ten times the rounding of what
// follows. Directions that much beyond the edge of a cone keep a little probability.
constexpr float kCosineSlack = 1e-5f;
// A query's normal need not be the one its BSDF uses (geometric, interpolated, mapped), so an
// emitter above its horizon is not thought fainter than at 87 degrees. Chosen by us.
constexpr float kLeastReceiverCosine = 0.05f;
// Keeps importances finite at a point light, relative to the tree's size.
constexpr float kLeastSquaredDistance = 1e-30f;

struct ScaledQuery {
  Vec3f point, normal;
  bool both_sides;
};

float root_of_complement(float cosine) { return std::sqrt(std::max(0.0f, 1.0f - cosine * cosine)); }

// cos(max(0, a - b)) from cosines and sines of angles in [0, pi].
float cos_difference(float cos_a, float sin_a, float cos_b, float sin_b) {
  return cos_a > cos_b ? 1.0f : cos_a * cos_b + sin_a * sin_b;
}

// Bound of the irradiance from the emitters below a child, up to a factor common to all.
float importance(const LightBvhChild& child, const ScaledQuery& query) {
  const Vec3f v = query.point - Vec3f(child.center[0], child.center[1], child.center[2]);
  const float d2 = dot(v, v);
  const float radius = std::bit_cast<float>(uint32_t(child.radius) << 16);
  const float radius2 = radius * radius;
  const float reach = child.intensity / std::max(std::max(d2, radius2), kLeastSquaredDistance);
  if (d2 <= radius2) return std::max(reach, std::numeric_limits<float>::min());

  const float inverse_d = 1.0f / std::sqrt(d2);
  const float sin_u = radius * inverse_d;  // the sphere fills the cone of this half angle
  const float cos_u = root_of_complement(sin_u);

  // How far the query is outside the cone of full intensity, at best.
  const Vec3f axis(child.axis[0], child.axis[1], child.axis[2]);
  float cos_w = std::clamp(dot(axis, v) / std::sqrt(dot(axis, axis) * d2), -1.0f, 1.0f);
  if (child.link & LightBvhChild::kTwoSided) cos_w = std::abs(cos_w);
  const float cos_o = float(child.cos_theta_o) * (1.0f / 32767.0f);
  float cos_x = 1.0f, sin_x = 0.0f;
  if (cos_w < cos_o) {
    const float sin_w = root_of_complement(cos_w), sin_o = root_of_complement(cos_o);
    cos_x = cos_w * cos_o + sin_w * sin_o;
    sin_x = sin_w * cos_o - cos_w * sin_o;
  }
  const float cos_emitted = cos_difference(cos_x, sin_x, cos_u, sin_u) + kCosineSlack;
  if (cos_emitted <= float(child.cos_theta_e) * (1.0f / 32767.0f)) return 0.0f;

  // How far the sphere is from the query's normal, at best.
  float cos_i = -dot(query.normal, v) * inverse_d;
  if (query.both_sides) cos_i = std::abs(cos_i);
  const float cos_received =
      cos_difference(cos_i, root_of_complement(cos_i), cos_u, sin_u) + kCosineSlack;
  if (cos_received <= 0.0f) return 0.0f;

  return std::max(
      reach * std::max(cos_emitted, kCosineSlack) * std::max(cos_received, kLeastReceiverCosine),
      std::numeric_limits<float>::min());
}

}  // namespace

LightBvh::Pick LightBvh::pick(const LightQuery& query, double u) const {
  const ScaledQuery scaled{query.point * scale_, query.normal, query.both_sides};
  double probability = 1.0;
  uint32_t link = root_;
  while (!(link & LightBvhChild::kLeaf)) {
    const LightBvhPair& pair = pairs_[link & LightBvhChild::kIndex];
    const double first = importance(pair.child[0], scaled);
    const double second = importance(pair.child[1], scaled);
    const double total = first + second;
    if (!(total > 0)) return {};
    const double share = u * total;
    if (share < first) {
      u = share / first;
      probability *= first / total;
      link = pair.child[0].link;
    } else {
      u = (share - first) / second;
      probability *= second / total;
      link = pair.child[1].link;
    }
    u = std::min(u, 1.0 - 0x1p-53);
  }
  return {link & LightBvhChild::kIndex, float(probability)};
}

float LightBvh::probability(const LightQuery& query, uint32_t emitter) const {
  const ScaledQuery scaled{query.point * scale_, query.normal, query.both_sides};
  uint64_t path = paths_[emitter];
  double probability = 1.0;
  uint32_t link = root_;
  while (!(link & LightBvhChild::kLeaf)) {
    const LightBvhPair& pair = pairs_[link & LightBvhChild::kIndex];
    const double first = importance(pair.child[0], scaled);
    const double second = importance(pair.child[1], scaled);
    const double taken = path & 1 ? second : first;
    if (!(taken > 0)) return 0.0f;
    probability *= taken / (first + second);
    link = pair.child[path & 1].link;
    path >>= 1;
  }
  return float(probability);
}

uint64_t LightBvh::bytes() const {
  return pairs_.size() * sizeof(LightBvhPair) + paths_.size() * sizeof(uint64_t);
}

}  // namespace emberline
