// Every light of a scene and the choice among them for next-event estimation.
//
// World space here is the scene's internal space (rebased, see renderer/scene/scene.h). All
// sampling and density functions are const, pure and thread-safe. No virtual call per ray.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "renderer/core/ray.h"
#include "renderer/core/time_curve.h"
#include "renderer/core/vector.h"

namespace emberline {

class EnvironmentGuide;  // environment_guide.h
class EnvironmentLight;  // environment_light.h
class LightBvh;          // light_bvh.h
struct EmitterBounds;    // light_bvh.h
struct GuidedRequest;    // environment_guide.h
struct LightGuide;       // light_guide.h
class TriangleBatch;     // triangle_sampling.h

// A triangle of an emissive mesh, as placed by one instance; at the shutter's opening, if it moves.
struct EmissiveTriangle {
  Vec3f p0, p1, p2;   // CCW seen from the emitting side
  Rgb mean_radiance;  // averaged over its area (texture included), at its brightest; > 0 somewhere
  bool two_sided = false;
  bool moves = false;     // EmitterMotion knows where it is
  bool appears = false;   // EmitterMotion knows when it is there
  uint32_t instance = 0;  // for the integrator to find its material and attributes
  uint32_t primitive = 0;
};

// Where the triangles that move are, and when: whoever has the geometry says so, since light
// samples have to lie on what rays hit.
class EmitterMotion {
 public:
  virtual ~EmitterMotion() = default;
  // At a time in [0, 1], counter-clockwise seen from the emitting side.
  virtual std::array<Vec3f, 3> corners(const EmissiveTriangle& triangle, float time) const = 0;
  // Into how many equal times the shutter is cut for it to go along lines or arcs of less than half
  // a turn in each.
  virtual int segments(const EmissiveTriangle& triangle) const = 0;
  // Whether one that appears is there.
  virtual bool shown(const EmissiveTriangle& triangle, float time) const = 0;
};

enum class PointLightType : uint8_t { kPoint, kSpot, kDirectional };

struct PointLightPlace {
  Vec3f position;   // point, spot
  Vec3f direction;  // spot, directional: the way the light travels; unit

  bool operator==(const PointLightPlace&) const = default;
};

// A point light at one time.
struct PointLightState : PointLightPlace {
  Rgb intensity;                             // W/sr (candela), or irradiance (lux) for directional
  float cos_inner = 1.0f, cos_outer = 0.0f;  // spot: glTF's angular falloff between them
  float range = kInfinity;                   // point, spot: no light beyond

  bool operator==(const PointLightState&) const = default;
};

// Where it is at the shutter's opening, and at its brightest, widest and farthest.
struct PointLight : PointLightState {
  PointLightType type = PointLightType::kPoint;
  // Later places, evenly spaced up to the shutter's closing, and straight lines between them.
  std::vector<PointLightPlace> motion = {};
  // What there is of the intensity, the angles of the cones, what there is of the range, and when
  // there is any light; null: no change.
  std::shared_ptr<const TimeCurve<Rgb>> share = {};
  std::shared_ptr<const TimeCurve<Vec2f>> cones = {};
  std::shared_ptr<const TimeCurve<float>> range_share = {};
  std::shared_ptr<const ShownTimes> shown = {};

  bool changes() const { return !motion.empty() || share || cones || range_share || shown; }
  PointLightPlace place_at(float time) const;
  PointLightState at(float time) const {
    if (changes()) return changed_at(time);
    return *this;
  }
  bool operator==(const PointLight&) const = default;

 private:
  PointLightState changed_at(float time) const;
};

// Where the illumination is asked for.
struct LightQuery {
  Vec3f point;
  Vec3f normal;             // the hemisphere that can receive light; ignored if `both_sides`
  bool both_sides = false;  // the surface transmits
  float time = 0.0f;        // as of a ray
};

struct LightRequest {
  LightQuery query;
  float u_pick = 0.0f;  // chooses the light (reused by remapping inside)
  Vec2f u;              // the point on it
};

enum class LightKind : uint8_t { kNone, kTriangle, kPoint, kEnvironment };

struct LightSample {
  LightKind kind = LightKind::kNone;   // kNone: nothing could be sampled, contribution 0
  uint32_t index = 0;                  // into triangles() or points()
  Vec3f direction = Vec3f(0.0f);       // unit, from the query point towards the light
  float distance = 0.0f;               // infinity for directional and environment
  Vec3f position = Vec3f(0.0f);        // on the light (triangle, point, spot)
  Vec3f emitter_normal = Vec3f(0.0f);  // triangle: geometric, unit
  Vec2f barycentric = Vec2f(0.0f);     // triangle: weights of p1 and p2
  // Point lights: radiant intensity / distance^2 (or irradiance); environment: radiance;
  // triangle: left 0, the integrator evaluates the material's emission at the point.
  Rgb radiance = Rgb(0.0f);
  float pdf = 0.0f;    // per solid angle, probability of picking this light included
  bool delta = false;  // point-like: cannot be hit by a ray, pdf is the pick probability alone
};

// Kinds among which light is chosen first.
enum { kEnvironmentKind, kDirectionalKind, kFiniteKind, kLightKinds };

class LightSampler {
 public:
  // From this many finite emitters on, a light BVH chooses; below, power does.
  static constexpr uint32_t kBvhThreshold = 16;

  // `environment` may be null. An environment with no radiance at all is treated as null. `motion`
  // outlives the sampler; null if no triangle moves. `bvh_threshold`: another for tests.
  LightSampler(std::vector<EmissiveTriangle> triangles, std::vector<PointLight> points,
               std::shared_ptr<const EnvironmentLight> environment,
               const EmitterMotion* motion = nullptr, uint32_t bvh_threshold = kBvhThreshold);
  ~LightSampler();
  LightSampler(LightSampler&&) noexcept;
  LightSampler& operator=(LightSampler&&) noexcept;

  bool empty() const;  // nothing to sample

  // Picks a light and a point on it, for each of up to kRayBatch requests as if it were alone; out
  // is constructed.
  // `guide`, of these lights, is to be the same for samples and densities; null: none.
  void sample(std::span<const LightRequest> requests, LightSample* const* out,
              const LightGuide* guide = nullptr) const;

  // Density, per solid angle at query.point, with which sample() returns a point of triangle
  // `index` at `distance`, if nothing else is in the way: 0 on the back of a one-sided one. Cost
  // O(depth of the light BVH).
  float pdf_triangle(const LightQuery& query, uint32_t index, float distance,
                     const LightGuide* guide = nullptr) const;
  // The probability of picking the environment at all: the factor of its density that does not
  // depend on the direction. EnvironmentLight::radiance_and_pdf has the other.
  float environment_probability(const LightQuery& query, const LightGuide* guide = nullptr) const;
  // With which probability which kind of light is picked: the environment, directional lights,
  // finite ones. At most 1 in all.
  std::array<float, kLightKinds> kind_probabilities(const LightQuery& query,
                                                    const LightGuide* guide = nullptr) const;
  int kinds() const { return (environment_ ? 1 : 0) + !directional_.empty() + !emitters_.empty(); }

  const EnvironmentLight* environment() const { return environment_.get(); }
  const std::vector<EmissiveTriangle>& triangles() const { return triangles_; }
  const std::vector<PointLight>& points() const { return points_; }

  // For the report: "light BVH (1204 emitters)", "power (3 emitters), environment", and bytes held
  // (the environment's own are its own).
  std::string describe() const;
  uint64_t bytes() const;

 private:
  std::vector<EmissiveTriangle> triangles_;
  std::vector<PointLight> points_;
  std::shared_ptr<const EnvironmentLight> environment_;
  const EmitterMotion* motion_ = nullptr;
  std::unique_ptr<const LightBvh> bvh_;

  // An emitter is a finite light that emits: an index into triangles_, or with kPointEmitter into
  // points_. Degenerate, black and non-finite ones are none.
  static constexpr uint32_t kPointEmitter = 1u << 31;
  static constexpr uint32_t kNoEmitter = ~0u;
  std::vector<uint32_t> emitters_;
  std::vector<uint32_t> triangle_emitter_;  // per triangle: its emitter, or kNoEmitter
  Vec3f finite_centre_ = Vec3f(0.0f);       // of the emitters' bounds
  float finite_radius2_ = 0.0f;             // and half their diagonal, squared
  float finite_intensity_ = 0.0f;           // luminance, all emitters together
  float finite_reach2_ = kInfinity;         // no emitter gives light beyond, squared
  bool ranged_ = false;                     // some emitters have a range
  std::vector<uint32_t> directional_;       // indices into points_
  std::vector<double> power_sums_;          // without a BVH: running shares of the power

  // The choice between infinite lights (directional, environment) and finite ones: by irradiance,
  // within limits, times KindFactors. That of the finite ones is taken as what a lamp of all their
  // intensity in the middle of them would give. Among infinite ones by irradiance, which is known
  // exactly but for the environment's distribution.
  struct InfiniteChoice {
    float probability = 0.0f;  // of choosing any infinite light
    float environment = 0.0f;  // weights
    float directional_factor = 1.0f;
    float total = 0.0f;
  };
  struct FinitePick {
    uint32_t emitter = 0;
    float probability = 0.0f;
  };
  std::array<Vec3f, 3> corners(const EmissiveTriangle& triangle, float time) const;
  float directional_weight(const LightQuery& query, const PointLight& light, float factor) const;
  bool has_infinite() const { return environment_ || !directional_.empty(); }
  InfiniteChoice weigh_infinite(const LightQuery& query, const LightGuide* guide) const;
  FinitePick pick_finite(const LightQuery& query, double u) const;
  float finite_probability(const LightQuery& query, uint32_t emitter) const;
  // The choice without a BVH where emitters have ranges: by power, among those that reach the
  // query.
  bool reaches(const LightQuery& query, uint32_t emitter) const;
  double share_in_reach(const LightQuery& query) const;
  FinitePick pick_in_reach(const LightQuery& query, double u) const;
  // Among the directional ones; u_weight in [0, their weights' sum).
  LightSample sample_directional(const LightQuery& query, const InfiniteChoice& choice,
                                 double u_weight) const;
  LightSample sample_point(const LightQuery& query, uint32_t index, float probability) const;
  // Each result comes in with the probability that it was picked with as its pdf; a triangle's with
  // its index, too.
  void sample_triangles(TriangleBatch& batch, LightSample* const* out) const;
  void sample_environment(std::span<const GuidedRequest> requests, const EnvironmentGuide* guide,
                          LightSample* const* out) const;
  void measure_finite_lights(std::span<const EmitterBounds> bounds);
  void sum_powers(std::span<const double> powers);
};

}  // namespace emberline
