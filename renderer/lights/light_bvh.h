// A bounding hierarchy over finite emitters that picks one in proportion to a bound of its
// contribution: Conty Estevez & Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree
// Splitting", in the one-light-per-vertex form of pbrt-v4 (BVHLightSampler), with three changes:
// - power is the peak radiant intensity, so that triangles, points and spots are compared by
//   irradiance;
// - the distance is clamped to the radius of the node's bounding sphere (pbrt compares a squared
//   distance with a length, which depends on the unit of length);
// - an importance is 0 only if no emitter of the node can reach the query or its hemisphere, with a
//   margin for rounding: every contributing emitter has a positive probability.
//
// Immutable after construction; pick and probability are pure and thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "renderer/core/vector.h"
#include "renderer/lights/light_sampler.h"

namespace emberline {

// Lights above the horizon of the query's normal are weighted as if they were at most 87 degrees
// from it, because the BSDF may use another normal (geometric, interpolated or mapped). Chosen by
// us.
constexpr float kMinReceiverCosine = 0.05f;

// Position and directions of an emitter: within theta_o of the axis it may emit its full intensity,
// and at more than theta_o + theta_e from the axis it emits nothing (figure 2 of the paper).
struct EmitterBounds {
  Vec3f lower, upper;
  Vec3f axis;                // unit
  float cos_theta_o = 1.0f;  // theta_o in [0, pi]
  float cos_theta_e = 0.0f;  // theta_e in [0, pi / 2]
  bool two_sided = false;    // emits equally along -axis
  double intensity = 0.0;    // > 0; in the same unit for all emitters
  float reach = kInfinity;   // no light arrives farther than this from the box
};

// Bounds over the whole shutter. The intensity is 0 if the emitter is black or has no area that
// floats can represent. `motion` is only used for a moving triangle.
EmitterBounds bounds_of(const EmissiveTriangle& triangle, const EmitterMotion* motion);
EmitterBounds bounds_of(const PointLight& light);

// Bounds of the emitters below one child of a pair. Coordinates are scaled by a power of two to
// about unit size, so that squares neither overflow nor underflow at any scene scale. Every value
// is rounded towards the larger bound.
struct LightBvhChild {
  float center[3];
  float intensity;      // fraction of the total
  int16_t axis[3];      // any length
  int16_t cos_theta_o;  // scaled by 32767
  int16_t cos_theta_e;
  uint16_t radius;  // of the bounding sphere: upper 16 bits of a float
  uint32_t link;    // kLeaf, kTwoSided, and the index of a pair or of an emitter

  static constexpr uint32_t kLeaf = 1u << 31, kTwoSided = 1u << 30, kIndex = kTwoSided - 1;
};

// Two children in one cache line, interleaved by member, so that both importances are computed in
// lanes of the same vector.
struct alignas(64) LightBvhPair {
  float center[3][2];
  float intensity[2];
  int16_t axis[3][2];
  int16_t cos_theta_o[2];
  int16_t cos_theta_e[2];
  uint16_t radius[2];
  uint32_t link[2];

  void set(int lane, const LightBvhChild& child);
};
static_assert(sizeof(LightBvhPair) == 64);

class LightBvh {
 public:
  // Requires at least one emitter and fewer than 2^30. Deterministic. O(n log n): 1e6 emitters take
  // about a second.
  explicit LightBvh(std::span<const EmitterBounds> emitters);

  struct Pick {
    uint32_t emitter = 0;
    float probability = 0.0f;  // 0: no emitter on the path chosen by u reaches the query
  };
  // u in [0, 1), in double because every level of the tree consumes some of its digits.
  Pick pick(const LightQuery& query, double u) const;
  // Probability that pick() returns `emitter`; the same bits as Pick::probability.
  float probability(const LightQuery& query, uint32_t emitter) const;

  int depth() const { return depth_; }
  uint64_t bytes() const;

 private:
  template <bool kRanged>
  Pick pick_among(const LightQuery& query, double u) const;
  template <bool kRanged>
  float probability_among(const LightQuery& query, uint32_t emitter) const;

  std::vector<LightBvhPair> pairs_;
  // Per pair and child: the squared distance from the child's centre beyond which none of its light
  // arrives. Empty if no emitter has a finite reach.
  std::vector<std::array<float, 2>> reaches2_;
  std::vector<uint64_t> paths_;  // per emitter: bit k is the child taken at depth k
  uint32_t root_ = 0;            // a link
  float scale_ = 1.0f;
  int depth_ = 0;
};

// Ranges are split by cost down to this depth and by count below it, which adds at most 30 levels
// for 2^30 emitters, so that no path is longer than 64 bits.
inline constexpr int kLightBvhCostDepth = 32;

}  // namespace emberline
