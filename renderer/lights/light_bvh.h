// A bounding volume hierarchy over finite emitters, which picks an emitter in proportion to a bound
// on the emitter's contribution. The method is that of Conty Estevez & Kulla 2018, "Importance
// Sampling of Many Lights with Adaptive Tree Splitting", in the form of pbrt-v4 (BVHLightSampler),
// which picks one light per vertex. There are three changes:
// - the power of an emitter is its peak radiant intensity, so that triangles, points and spots are
//   compared by irradiance;
// - the distance is clamped to at least the radius of the node's bounding sphere (pbrt clamps a
//   squared distance to a length, so its result depends on the unit of length);
// - the importance of a node is 0 only if none of its emitters can light the query's hemisphere,
//   with a margin for rounding. So every contributing emitter has a positive probability.
//
// The tree is immutable after construction; pick() and probability() are pure and thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "renderer/core/vector.h"
#include "renderer/lights/light_sampler.h"

namespace emberline {

// A light above the query's horizon is weighted as if it were at most 87 degrees from the query's
// normal, because the BSDF may use another normal (geometric, interpolated or mapped). We chose the
// value.
constexpr float kMinReceiverCosine = 0.05f;

// Bounds on the position and directions of an emitter. Within an angle of theta_o from the axis,
// the emitter may emit its full intensity; beyond theta_o + theta_e, it emits nothing (figure 2 of
// the paper).
struct EmitterBounds {
  Vec3f lower, upper;
  Vec3f axis;                // unit
  float cos_theta_o = 1.0f;  // theta_o in [0, pi]
  float cos_theta_e = 0.0f;  // theta_e in [0, pi / 2]
  bool two_sided = false;    // emits equally along -axis
  double intensity = 0.0;    // > 0; in the same unit for all emitters
  float reach = kInfinity;   // no light arrives farther than this from the box
};

// Return bounds over the whole shutter time. The intensity of the bounds is 0 if the emitter is
// black or has no area that floats can represent. `motion` is used only for moving triangles.
EmitterBounds bounds_of(const EmissiveTriangle& triangle, const EmitterMotion* motion);
EmitterBounds bounds_of(const PointLight& light);

// Bounds of the emitters below one child of a pair. Coordinates are scaled by a power of two to
// about unit size, so that squares neither overflow nor underflow at any scene scale. Every value
// is rounded in the direction that makes the bounds larger.
struct LightBvhChild {
  float center[3];
  float intensity;      // fraction of the total
  int16_t axis[3];      // any length
  int16_t cos_theta_o;  // scaled by 32767
  int16_t cos_theta_e;
  uint16_t radius;  // of the bounding sphere: upper 16 bits of a float
  uint32_t link;    // flags kLeaf and kTwoSided; index of a pair, or of a leaf's emitter

  static constexpr uint32_t kLeaf = 1u << 31, kTwoSided = 1u << 30, kIndex = kTwoSided - 1;
};

// Two children in one cache line. Their members are interleaved, so that both importances are
// computed in lanes of the same vector.
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
  // Requires at least one emitter and fewer than 2^30. The build is deterministic and takes
  // O(n log n) time, about a second for 1e6 emitters.
  explicit LightBvh(std::span<const EmitterBounds> emitters);

  struct Pick {
    uint32_t emitter = 0;
    float probability = 0.0f;  // 0 if nothing was picked: no light reaches the query
  };
  // Picks an emitter for u in [0, 1), which is a double because every level of the tree uses up
  // some of its digits.
  Pick pick(const LightQuery& query, double u) const;
  // Returns the probability that pick() picks `emitter`; bit-identical to Pick::probability.
  float probability(const LightQuery& query, uint32_t emitter) const;

  int depth() const { return depth_; }
  uint64_t bytes() const;

 private:
  template <bool kRanged>
  Pick pick_among(const LightQuery& query, double u) const;
  template <bool kRanged>
  float probability_among(const LightQuery& query, uint32_t emitter) const;

  std::vector<LightBvhPair> pairs_;
  // For each pair, the squared distance from each child's centre beyond which none of the child's
  // light arrives. Empty if no emitter has a finite reach.
  std::vector<std::array<float, 2>> reaches2_;
  std::vector<uint64_t> paths_;  // per emitter: bit k is the child to take at depth k
  uint32_t root_ = 0;            // as LightBvhChild::link
  float scale_ = 1.0f;
  int depth_ = 0;
};

// The builder splits ranges of emitters by cost down to this depth, and into halves below it. As
// halving adds at most 30 levels for 2^30 emitters, no path is longer than 64 bits.
inline constexpr int kLightBvhCostDepth = 32;

}  // namespace emberline
