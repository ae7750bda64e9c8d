// Builds the light BVH from the top down, with 12 buckets along each axis and the surface area
// orientation heuristic of Conty Estevez & Kulla 2018, section 4.1.
#include <Imath/ImathBox.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

#include "renderer/core/constants.h"
#include "renderer/lights/light_bvh.h"

namespace emberline {
namespace {

constexpr int kBuckets = 12;  // as in pbrt-v4
// This angle (in rad) is added to theta_o to cover the rounding of the 16-bit axis (5e-5 rad) and
// of the cosines in bound().
constexpr double kAxisMargin = 2e-4;
// This fraction of a box's squared diagonal is added to the box's area. Without it, all splits of
// emitters on a line along an axis would cost the same, since their boxes have no area.
constexpr float kDiagonalShare = 0.01f;
// If the relative difference between two costs is smaller than this, the more balanced split wins.
// A symmetric arrangement of lights therefore gets a symmetric tree in spite of rounding.
constexpr float kTieTolerance = 1e-4f;

float measure_of(const Imath::Box3f& box) {
  const Vec3f e = box.max - box.min;
  return 2 * (e.x * e.y + e.y * e.z + e.z * e.x) + kDiagonalShare * dot(e, e);
}

struct BuildEmitter {
  Vec3f lower, upper, axis;
  float intensity;
  float cos_o, cos_e;
  uint32_t index;
  bool two_sided;
  float reach;
  Vec3f center() const { return (lower + upper) * 0.5f; }
};

// Returns one of the two directions of a two-sided emitter. It is the same direction for all
// parallel emitters.
Vec3f canonical(const Vec3f& axis) {
  const float side = axis.x * 0.267f + axis.y * 0.535f + axis.z * 0.802f;
  return side < 0 ? -axis : axis;
}

// The paper's M_Omega as a function of cos theta_o. It assumes theta_e = pi / 2, which is true of
// all emitters except spots.
class OrientationMeasure {
 public:
  OrientationMeasure() {
    for (int i = 0; i <= kSteps; ++i) {
      const double o = std::acos(std::clamp(2.0 * i / kSteps - 1.0, -1.0, 1.0));
      const double w = std::min(o + kPiD / 2, kPiD);
      table_[size_t(i)] =
          float(2 * kPiD * (1 - std::cos(o)) + kPiD / 2 *
                                                   (2 * w * std::sin(o) - std::cos(o - 2 * w) -
                                                    2 * o * std::sin(o) + std::cos(o)));
    }
  }
  float operator()(float cos_o) const {
    return table_[size_t(std::clamp((cos_o + 1) * (0.5f * kSteps) + 0.5f, 0.0f, float(kSteps)))];
  }

 private:
  static constexpr int kSteps = 256;
  std::array<float, kSteps + 1> table_;
};

struct Bucket {
  Imath::Box3f box;
  Vec3f axis_sum = Vec3f(0.0f);
  float intensity = 0;
  uint32_t count = 0;

  void add(const BuildEmitter& e) {
    box.extendBy({e.lower, e.upper});
    if (e.cos_o > -1) axis_sum += e.two_sided ? canonical(e.axis) : e.axis;
    intensity += e.intensity;
    ++count;
  }
  void add(const Bucket& b) {
    box.extendBy(b.box);
    axis_sum += b.axis_sum;
    intensity += b.intensity;
    count += b.count;
  }
  // The heuristic needs only an estimate of cos theta_o, not a bound. If directions are spread
  // evenly over a cap, their mean has the length (1 + cos theta_o) / 2. The code solves this for
  // cos theta_o.
  float cost(const OrientationMeasure& measure) const {
    const float resultant = std::sqrt(dot(axis_sum, axis_sum)) / float(count);
    return intensity * measure(2 * resultant - 1) * measure_of(box);
  }
};

struct Split {
  int axis = -1;
  int bucket = 0;  // last bucket of the left side
  float cost = 0;
  uint32_t imbalance = 0;
};

struct Builder {
  std::vector<BuildEmitter> emitters;
  std::vector<LightBvhPair>& pairs;
  std::vector<std::array<float, 2>>* reaches2;  // null if no emitter has a finite reach
  std::vector<uint64_t>& paths;
  int& depth;
  OrientationMeasure measure;

  LightBvhChild build(size_t begin, size_t end, int level, uint64_t path);
  LightBvhChild bound(size_t begin, size_t end) const;
  float reach2(size_t begin, size_t end, const LightBvhChild& bounds) const;
  size_t split(size_t begin, size_t end, int level);
  Split best_split(size_t begin, size_t end, const Imath::Box3f& centers) const;
};

int bucket_of(float x, float low, float inverse_extent) {
  return std::clamp(int((x - low) * inverse_extent), 0, kBuckets - 1);
}

Split Builder::best_split(size_t begin, size_t end, const Imath::Box3f& centers) const {
  const Vec3f extent = centers.max - centers.min;
  const float largest = max_component(extent);
  Split best;
  for (int axis = 0; axis < 3; ++axis) {
    if (!(extent[axis] > 0)) continue;
    const float inverse = float(kBuckets) / extent[axis];
    if (!std::isfinite(inverse)) continue;
    std::array<Bucket, kBuckets> buckets;
    for (size_t i = begin; i < end; ++i)
      buckets[size_t(bucket_of(emitters[i].center()[axis], centers.min[axis], inverse))].add(
          emitters[i]);
    std::array<float, kBuckets> right_cost;
    std::array<uint32_t, kBuckets> right_count;
    Bucket right;
    for (int b = kBuckets - 1; b > 0; --b) {
      if (buckets[size_t(b)].count > 0) right.add(buckets[size_t(b)]);
      right_count[size_t(b)] = right.count;
      right_cost[size_t(b)] = right.count > 0 ? right.cost(measure) : 0;
    }
    const float regularity = largest / extent[axis];  // K_r of the paper: thin slabs cost more
    Bucket left;
    for (int b = 0; b + 1 < kBuckets; ++b) {
      if (buckets[size_t(b)].count == 0) continue;
      left.add(buckets[size_t(b)]);
      if (right_count[size_t(b) + 1] == 0) continue;
      const float cost = regularity * (left.cost(measure) + right_cost[size_t(b) + 1]);
      if (!std::isfinite(cost)) continue;
      const uint32_t other = right_count[size_t(b) + 1];
      const uint32_t imbalance = left.count > other ? left.count - other : other - left.count;
      const float margin = kTieTolerance * best.cost;
      if (best.axis < 0 || cost < best.cost - margin ||
          (cost <= best.cost + margin && imbalance < best.imbalance))
        best = {axis, b, cost, imbalance};
    }
  }
  return best;
}

// Splits the range into two parts: reorders its emitters and returns the beginning of the second
// part.
size_t Builder::split(size_t begin, size_t end, int level) {
  if (end - begin == 2) return begin + 1;
  Imath::Box3f centers;
  for (size_t i = begin; i < end; ++i) {
    centers.extendBy(emitters[i].center());
  }
  const auto first = emitters.begin() + std::ptrdiff_t(begin);
  const auto last = emitters.begin() + std::ptrdiff_t(end);
  if (level < kLightBvhCostDepth) {
    const Split best = best_split(begin, end, centers);
    if (best.axis >= 0) {
      const float low = centers.min[best.axis];
      const float inverse = float(kBuckets) / (centers.max[best.axis] - low);
      const auto middle = std::partition(first, last, [&](const BuildEmitter& e) {
        return bucket_of(e.center()[best.axis], low, inverse) <= best.bucket;
      });
      return size_t(middle - emitters.begin());
    }
  }
  // If all emitters are at the same position or the range is too deep in the tree, halve the range
  // along its widest axis. Emitters at the same position are ordered by index.
  const Vec3f extent = centers.max - centers.min;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const size_t middle = begin + (end - begin) / 2;
  std::nth_element(first, emitters.begin() + std::ptrdiff_t(middle), last,
                   [axis](const BuildEmitter& a, const BuildEmitter& b) {
                     const float x = a.center()[axis], y = b.center()[axis];
                     return x != y ? x < y : a.index < b.index;
                   });
  return middle;
}

// Returns the bounds of a range of emitters, for importances(). Rounding makes the bounds larger,
// never smaller.
LightBvhChild Builder::bound(size_t begin, size_t end) const {
  Imath::Box3f box;
  Vec3d sum(0.0), canonical_sum(0.0);
  double intensity = 0;
  float cos_e = 1;
  bool two_sided = false;
  for (size_t i = begin; i < end; ++i) {
    const BuildEmitter& e = emitters[i];
    box.extendBy({e.lower, e.upper});
    sum += Vec3d(e.axis);
    canonical_sum += Vec3d(canonical(e.axis));
    intensity += e.intensity;
    cos_e = std::min(cos_e, e.cos_e);
    two_sided |= e.two_sided;
  }
  if (two_sided) sum = canonical_sum;  // the cone represents both directions

  LightBvhChild child{};
  double radius2 = 0;
  for (int i = 0; i < 3; ++i) {
    child.center[i] = float((double(box.min[i]) + box.max[i]) / 2);
    const double half =
        std::max(double(box.max[i]) - child.center[i], double(child.center[i]) - box.min[i]);
    radius2 += half * half;
  }
  const float radius = float(std::sqrt(radius2) * (1 + 1e-6));
  // Store the upper 16 bits of the float, rounded up.
  child.radius = uint16_t((std::bit_cast<uint32_t>(radius) + 0xffffu) >> 16);
  child.intensity = std::max(float(intensity), std::numeric_limits<float>::min());

  const double largest = max_abs_component(sum);
  if (!(largest > 1e-30)) {
    sum = Vec3d(0, 0, 1);
  } else {
    sum /= largest;
  }
  for (int i = 0; i < 3; ++i) child.axis[i] = int16_t(std::lround(sum[i] * 32767));
  Vec3d axis(child.axis[0], child.axis[1], child.axis[2]);
  axis /= std::sqrt(dot(axis, axis));
  double cos_o = 1;
  for (size_t i = begin; i < end && cos_o > -1; ++i) {
    const BuildEmitter& e = emitters[i];
    double cosine = std::clamp(dot(axis, Vec3d(e.axis)), -1.0, 1.0);
    if (two_sided) cosine = std::abs(cosine);
    if (e.cos_o < 1) {
      const double c = e.cos_o;
      cosine = cosine <= -c ? -1
                            : cosine * c - std::sqrt(std::max(0.0, 1 - cosine * cosine)) *
                                               std::sqrt(std::max(0.0, 1 - c * c));
    }
    cos_o = std::min(cos_o, cosine);
  }
  const double theta_o = std::acos(std::clamp(cos_o, -1.0, 1.0)) + kAxisMargin;
  child.cos_theta_o = int16_t(std::floor(std::cos(std::min(theta_o, kPiD)) * 32767));
  child.cos_theta_e = int16_t(std::floor(double(cos_e) * 32767));
  child.link = two_sided ? LightBvhChild::kTwoSided : 0;
  return child;
}

// Returns how far from the centre of `bounds` the light of a range of emitters can reach, as a
// squared distance that is rounded up.
float Builder::reach2(size_t begin, size_t end, const LightBvhChild& bounds) const {
  double farthest = 0;
  for (size_t i = begin; i < end; ++i) {
    double away2 = 0;
    for (int c = 0; c < 3; ++c) {
      const double center = bounds.center[c];
      away2 += square(std::max(emitters[i].upper[c] - center, center - emitters[i].lower[c]));
    }
    farthest = std::max(farthest, std::sqrt(away2) + double(emitters[i].reach));
  }
  return float(square(farthest) * 1.00001);
}

LightBvhChild Builder::build(size_t begin, size_t end, int level, uint64_t path) {
  LightBvhChild child = bound(begin, end);
  depth = std::max(depth, level);
  if (end - begin == 1) {
    paths[emitters[begin].index] = path;
    child.link |= LightBvhChild::kLeaf | emitters[begin].index;
    return child;
  }
  assert(level < 64);
  const size_t middle = split(begin, end, level);
  const size_t index = pairs.size();
  pairs.emplace_back();
  if (reaches2) reaches2->emplace_back();
  const LightBvhChild left = build(begin, middle, level + 1, path);
  const LightBvhChild right = build(middle, end, level + 1, path | uint64_t(1) << level);
  pairs[index].set(0, left);
  pairs[index].set(1, right);
  if (reaches2) (*reaches2)[index] = {reach2(begin, middle, left), reach2(middle, end, right)};
  child.link |= uint32_t(index);
  return child;
}

}  // namespace

void LightBvhPair::set(int lane, const LightBvhChild& child) {
  for (int i = 0; i < 3; ++i) {
    center[i][lane] = child.center[i];
    axis[i][lane] = child.axis[i];
  }
  intensity[lane] = child.intensity;
  cos_theta_o[lane] = child.cos_theta_o;
  cos_theta_e[lane] = child.cos_theta_e;
  radius[lane] = child.radius;
  link[lane] = child.link;
}

LightBvh::LightBvh(std::span<const EmitterBounds> emitters) {
  assert(!emitters.empty() && emitters.size() < LightBvhChild::kIndex);
  float extent = 0;
  double intensity = 0;
  for (const EmitterBounds& e : emitters) {
    extent = std::max({extent, max_abs_component(e.lower), max_abs_component(e.upper)});
    intensity += e.intensity;
  }
  // Scaling by a power of two is exact.
  scale_ = extent > 0 ? std::ldexp(1.0f, std::clamp(-std::ilogb(extent), -120, 120)) : 1.0f;

  const auto is_ranged = [](const EmitterBounds& e) { return e.reach < kInfinity; };
  const bool ranged = std::ranges::any_of(emitters, is_ranged);
  if (ranged) reaches2_.reserve(emitters.size() - 1);
  Builder builder{{}, pairs_, ranged ? &reaches2_ : nullptr, paths_, depth_, {}};
  builder.emitters.reserve(emitters.size());
  for (size_t i = 0; i < emitters.size(); ++i) {
    const EmitterBounds& e = emitters[i];
    builder.emitters.push_back({e.lower * scale_, e.upper * scale_, e.axis,
                                float(e.intensity / intensity), e.cos_theta_o, e.cos_theta_e,
                                uint32_t(i), e.two_sided, e.reach * scale_});
  }
  pairs_.reserve(emitters.size() - 1);
  paths_.resize(emitters.size());
  root_ = builder.build(0, emitters.size(), 0, 0).link;
}

}  // namespace emberline
