// Traversal of the light BVH. Its construction is in light_bvh_build.cpp.
#include "renderer/lights/light_bvh.h"

#ifdef __SSE__
#include <xmmintrin.h>
#endif

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "renderer/core/color4.h"

namespace emberline {
namespace {

// The code adds this slack to cosines before it tests whether any light arrives. The slack is ten
// times the rounding error of the code below. As a result, directions slightly outside a cone also
// get a small probability.
constexpr float kCosineSlack = 1e-5f;
// Lower limit on the squared distance, in the tree's scaled coordinates, which keeps importances
// finite at a point light.
constexpr float kMinSquaredDistance = 1e-30f;

struct ScaledQuery {
  Vec3f point, normal;
  bool both_sides;
};

// One value for each of two sibling nodes, in the lower two of four lanes.
using Lanes = Color4;
using LaneMask = int32_t __attribute__((vector_size(16)));

Lanes all(float x) { return splat4(x); }
template <class T>
Lanes load(const T* two) {
  return Lanes{float(two[0]), float(two[1]), 1.0f, 1.0f};
}
Lanes max(Lanes a, Lanes b) { return a > b ? a : b; }
Lanes sqrt(Lanes x) {
#ifdef __SSE__
  return _mm_sqrt_ps(x);
#else
  return Lanes{std::sqrt(x[0]), std::sqrt(x[1]), 1.0f, 1.0f};
#endif
}

Lanes dot(Lanes ax, Lanes ay, Lanes az, Lanes bx, Lanes by, Lanes bz) {
  return fma(az, bz, fma(ay, by, ax * bx));
}

// Returns cos(max(0, a - b)) for angles a and b in [0, pi], whose cosines and sines are given.
Lanes cos_difference(Lanes cos_a, Lanes sin_a, Lanes cos_b, Lanes sin_b) {
  return cos_a > cos_b ? all(1.0f) : fma(cos_a, cos_b, sin_a * sin_b);
}

// Returns bounds on the irradiance from the emitters below each child, up to a common factor. It is
// forced inline, because a call would cost 1.2 % of the rendering time of caustics.glb.
[[gnu::always_inline]] inline Lanes importances(const LightBvhPair& pair,
                                                const ScaledQuery& query) {
  const Lanes x = query.point.x - load(pair.center[0]), y = query.point.y - load(pair.center[1]),
              z = query.point.z - load(pair.center[2]);
  const Lanes d2 = dot(x, y, z, x, y, z);
  const Lanes radius{std::bit_cast<float>(uint32_t(pair.radius[0]) << 16),
                     std::bit_cast<float>(uint32_t(pair.radius[1]) << 16), 1.0f, 1.0f};
  const Lanes radius2 = radius * radius, zero = all(0.0f);
  const Lanes reach = load(pair.intensity) / max(max(d2, radius2), all(kMinSquaredDistance));
  // Compute sines from differences of squares rather than from cosines, so that all square roots,
  // which dominate the latency of a step, can start once d2 is known.
  const Lanes inverse_d = 1.0f / sqrt(max(d2, all(kMinSquaredDistance)));
  // The bounding sphere subtends the half angle u.
  const Lanes sin_u = radius * inverse_d;
  const Lanes cos_u = sqrt(max(zero, d2 - radius2)) * inverse_d;

  // Find the smallest angle between a direction from an emitter to the query and the cone of full
  // intensity.
  const Lanes axis_x = load(pair.axis[0]), axis_y = load(pair.axis[1]), axis_z = load(pair.axis[2]);
  const Lanes length2 = dot(axis_x, axis_y, axis_z, axis_x, axis_y, axis_z);
  const Lanes scale = 1.0f / sqrt(length2) * inverse_d;
  const Lanes along = dot(axis_x, axis_y, axis_z, x, y, z);
  const LaneMask two_sided{pair.link[0] & LightBvhChild::kTwoSided ? -1 : 0,
                           pair.link[1] & LightBvhChild::kTwoSided ? -1 : 0, 0, 0};
  const Lanes cos_w = (two_sided ? max(along, -along) : along) * scale;
  const Lanes sin_w = sqrt(max(zero, fma(d2, length2, -(along * along)))) * scale;
  const Lanes cos_o = load(pair.cos_theta_o) * (1.0f / 32767.0f);
  const Lanes sin_o = sqrt(max(zero, fma(-cos_o, cos_o, all(1.0f))));
  const Lanes cos_x = cos_w < cos_o ? fma(cos_w, cos_o, sin_w * sin_o) : all(1.0f);
  const Lanes sin_x = cos_w < cos_o ? fma(sin_w, cos_o, -(cos_w * sin_o)) : zero;
  const Lanes cos_emitted = cos_difference(cos_x, sin_x, cos_u, sin_u) + kCosineSlack;
  const Lanes cos_e = load(pair.cos_theta_e) * (1.0f / 32767.0f);

  // Find the smallest angle between the query's normal and a direction to the bounding sphere.
  const Lanes below = dot(all(query.normal.x), all(query.normal.y), all(query.normal.z), x, y, z);
  const Lanes cos_i = (query.both_sides ? max(below, -below) : -below) * inverse_d;
  const Lanes sin_i = sqrt(max(zero, fma(-below, below, d2))) * inverse_d;
  const Lanes cos_received = cos_difference(cos_i, sin_i, cos_u, sin_u) + kCosineSlack;

  const Lanes cosines =
      max(cos_emitted, all(kCosineSlack)) * max(cos_received, all(kMinReceiverCosine));
  const Lanes emitted = cos_emitted > cos_e ? cosines : zero;
  const Lanes received = cos_received > zero ? emitted : zero;
  // Inside the bounding sphere, the angles are unknown, so assume full intensity. A positive
  // importance must not underflow to 0.
  const Lanes value = reach * (d2 <= radius2 ? all(1.0f) : received);
  const Lanes tiny = all(std::numeric_limits<float>::min());
  return d2 <= radius2 ? max(value, tiny) : (received > zero ? max(value, tiny) : zero);
}

// Like importances(), but returns 0 for a child whose light does not reach the query.
Lanes importances_in_reach(const LightBvhPair& pair, const std::array<float, 2>& reach2,
                           const ScaledQuery& query) {
  const Lanes x = query.point.x - load(pair.center[0]), y = query.point.y - load(pair.center[1]),
              z = query.point.z - load(pair.center[2]);
  return dot(x, y, z, x, y, z) > load(reach2.data()) ? all(0.0f) : importances(pair, query);
}

}  // namespace

template <bool kRanged>
LightBvh::Pick LightBvh::pick_among(const LightQuery& query, double u) const {
  const ScaledQuery scaled{query.point * scale_, query.normal, query.both_sides};
  double probability = 1.0;
  uint32_t link = root_;
  while (!(link & LightBvhChild::kLeaf)) {
    const uint32_t index = link & LightBvhChild::kIndex;
    const LightBvhPair& pair = pairs_[index];
    const Lanes bounds =
        kRanged ? importances_in_reach(pair, reaches2_[index], scaled) : importances(pair, scaled);
    const double first = double(bounds[0]), second = double(bounds[1]);
    const double total = first + second;
    if (!(total > 0)) return {};
    const double share = u * total;
    if (share < first) {
      u = share / first;
      probability *= first / total;
      link = pair.link[0];
    } else {
      u = (share - first) / second;
      probability *= second / total;
      link = pair.link[1];
    }
    u = std::min(u, 1.0 - 0x1p-53);
  }
  return {link & LightBvhChild::kIndex, float(probability)};
}

template <bool kRanged>
float LightBvh::probability_among(const LightQuery& query, uint32_t emitter) const {
  const ScaledQuery scaled{query.point * scale_, query.normal, query.both_sides};
  uint64_t path = paths_[emitter];
  double probability = 1.0;
  uint32_t link = root_;
  while (!(link & LightBvhChild::kLeaf)) {
    const uint32_t index = link & LightBvhChild::kIndex;
    const LightBvhPair& pair = pairs_[index];
    const Lanes bounds =
        kRanged ? importances_in_reach(pair, reaches2_[index], scaled) : importances(pair, scaled);
    const double first = double(bounds[0]), second = double(bounds[1]);
    const double taken = path & 1 ? second : first;
    if (!(taken > 0)) return 0.0f;
    probability *= taken / (first + second);
    link = pair.link[path & 1];
    path >>= 1;
  }
  return float(probability);
}

LightBvh::Pick LightBvh::pick(const LightQuery& query, double u) const {
  return reaches2_.empty() ? pick_among<false>(query, u) : pick_among<true>(query, u);
}

float LightBvh::probability(const LightQuery& query, uint32_t emitter) const {
  return reaches2_.empty() ? probability_among<false>(query, emitter)
                           : probability_among<true>(query, emitter);
}

uint64_t LightBvh::bytes() const {
  return pairs_.size() * sizeof(LightBvhPair) + reaches2_.size() * sizeof(reaches2_[0]) +
         paths_.size() * sizeof(uint64_t);
}

}  // namespace emberline
