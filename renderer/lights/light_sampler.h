// All lights of a scene, and the choice among them for next-event estimation.
//
// World space here means the scene's internal space (rebased, see renderer/scene/scene.h). All
// sampling and density functions are const, pure and thread-safe. They make no virtual call, except
// for triangles that move or change visibility.
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

// A triangle of one instance of an emissive mesh, in world space. If the triangle moves, the
// vertices are those at shutter open.
struct EmissiveTriangle {
  Vec3f p0, p1, p2;   // counter-clockwise as seen from the emitting side
  Rgb mean_radiance;  // mean over the area, including textures; maximum over time
  bool two_sided = false;
  bool moves = false;                 // EmitterMotion provides its position
  bool has_visibility_times = false;  // EmitterMotion provides its visibility
  uint32_t instance = 0;              // tells the integrator the material and attributes
  uint32_t primitive = 0;
};

// The position and visibility of moving triangles over time. The owner of the geometry implements
// this interface, since light samples must lie on the surfaces that rays hit.
class EmitterMotion {
 public:
  virtual ~EmitterMotion() = default;
  // Returns the vertices at a time in [0, 1], counter-clockwise as seen from the emitting side.
  virtual std::array<Vec3f, 3> corners(const EmissiveTriangle& triangle, float time) const = 0;
  // Returns the number of equal segments into which the shutter time must be divided so that, in
  // each of them, the vertices move along lines or along arcs of less than half a turn.
  virtual int segments(const EmissiveTriangle& triangle) const = 0;
  // Whether the triangle is visible at this time. Its `has_visibility_times` must be set.
  virtual bool visibility(const EmissiveTriangle& triangle, float time) const = 0;
};

enum class PointLightType : uint8_t { kPoint, kSpot, kDirectional };

struct PointLightPlace {
  Vec3f position;   // point, spot
  Vec3f direction;  // spot, directional: the direction in which the light travels; unit

  bool operator==(const PointLightPlace&) const = default;
};

// A point light at one time.
struct PointLightState : PointLightPlace {
  Rgb intensity;                             // W/sr (candela), or irradiance (lux) for directional
  float cos_inner = 1.0f, cos_outer = 0.0f;  // spot: the light falls off between these, as in glTF
  float range = kInfinity;                   // point, spot: no light beyond

  bool operator==(const PointLightState&) const = default;
};

// The base class has the position and direction at shutter open, and the maxima of intensity, cone
// angles and range over time.
struct PointLight : PointLightState {
  PointLightType type = PointLightType::kPoint;
  // Later positions and directions, at equal time steps until shutter close. They are interpolated
  // linearly.
  std::vector<PointLightPlace> motion = {};
  // Curves over time; null means constant. `share` and `range_scale` are factors on intensity and
  // range. `cones` has the inner and the outer angle.
  std::shared_ptr<const TimeCurve<Rgb>> share = {};
  std::shared_ptr<const TimeCurve<Vec2f>> cones = {};
  std::shared_ptr<const TimeCurve<float>> range_scale = {};
  std::shared_ptr<const VisibilityTimes> visibility = {};

  bool is_animated() const {
    return !motion.empty() || share || cones || range_scale || visibility;
  }
  PointLightPlace place_at(float time) const;
  PointLightState at(float time) const {
    if (is_animated()) return animated_at(time);
    return *this;
  }
  bool operator==(const PointLight&) const = default;

 private:
  PointLightState animated_at(float time) const;
};

// A point at which illumination is requested.
struct LightQuery {
  Vec3f point;
  Vec3f normal;             // of the receiving hemisphere; either sign if both_sides
  bool both_sides = false;  // the surface transmits, so it also receives light from behind
  float time = 0.0f;        // as in Ray
};

struct LightRequest {
  LightQuery query;
  float u_pick = 0.0f;  // chooses the light; its remainder is reused for further choices
  Vec2f u;              // chooses the point on the light
};

enum class LightKind : uint8_t { kNone, kTriangle, kPoint, kEnvironment };

struct LightSample {
  LightKind kind = LightKind::kNone;   // kNone: no light; the contribution is 0
  uint32_t index = 0;                  // into triangles() or points()
  Vec3f direction = Vec3f(0.0f);       // unit, from the query point towards the light
  float distance = 0.0f;               // infinite for directional lights, environment
  Vec3f position = Vec3f(0.0f);        // on the light (triangle, point, spot)
  Vec3f emitter_normal = Vec3f(0.0f);  // triangle: geometric, unit
  Vec2f barycentric = Vec2f(0.0f);     // triangle: weights of p1 and p2
  // Point lights: radiant intensity / distance^2 (directional: irradiance); environment: radiance;
  // triangle: 0, since the integrator evaluates the material's emission at the point.
  Rgb radiance = Rgb(0.0f);
  float pdf = 0.0f;    // per solid angle, includes the probability of picking this light
  bool delta = false;  // no ray can hit the light; pdf is only the probability of picking it
};

// Sampling first chooses one of these kinds of light.
enum { kEnvironmentKind, kDirectionalKind, kFiniteKind, kLightKinds };

class LightSampler {
 public:
  // With at least this many finite emitters, a light BVH picks one of them; with fewer, one is
  // picked in proportion to power.
  static constexpr uint32_t kBvhThreshold = 16;

  // `environment` may be null, and a black one is treated as null. `motion` must outlive the
  // sampler, and may be null if no triangle moves or has visibility times. Only tests set
  // `bvh_threshold`.
  LightSampler(std::vector<EmissiveTriangle> triangles, std::vector<PointLight> points,
               std::shared_ptr<const EnvironmentLight> environment,
               const EmitterMotion* motion = nullptr, uint32_t bvh_threshold = kBvhThreshold);
  ~LightSampler();
  LightSampler(LightSampler&&) noexcept;
  LightSampler& operator=(LightSampler&&) noexcept;

  bool empty() const;  // nothing to sample

  // Picks a light and a point on it for each of up to kRayBatch requests; the results do not depend
  // on how requests are grouped. `out` must point to constructed samples. `guide` may be null. If
  // it is not null, it must come from a survey of these lights, and samples and densities must use
  // the same guide.
  void sample(std::span<const LightRequest> requests, LightSample* const* out,
              const LightGuide* guide = nullptr) const;

  // Returns the density, per solid angle at query.point, with which sample() returns a point on
  // triangle `index` that is `distance` away. The density is 0 if query.point is behind a one-sided
  // triangle. The function takes O(depth of the light BVH) time.
  float pdf_triangle(const LightQuery& query, uint32_t index, float distance,
                     const LightGuide* guide = nullptr) const;
  // Returns the probability of picking the environment. The density of a direction is this
  // probability times the pdf from radiance_and_pdf() of EnvironmentLight (or of EnvironmentGuide,
  // with a guide).
  float environment_probability(const LightQuery& query, const LightGuide* guide = nullptr) const;
  // Returns the probability of picking each kind of light. The sum is at most 1.
  std::array<float, kLightKinds> kind_probabilities(const LightQuery& query,
                                                    const LightGuide* guide = nullptr) const;
  int kinds() const { return (environment_ ? 1 : 0) + !directional_.empty() + !emitters_.empty(); }

  const EnvironmentLight* environment() const { return environment_.get(); }
  const std::vector<EmissiveTriangle>& triangles() const { return triangles_; }
  const std::vector<PointLight>& points() const { return points_; }

  // For the report. describe() says how lights are picked, such as "light BVH (1204 emitters)" or
  // "power (3 emitters), environment". bytes() returns the memory used, not counting the
  // environment.
  std::string describe() const;
  uint64_t bytes() const;

 private:
  std::vector<EmissiveTriangle> triangles_;
  std::vector<PointLight> points_;
  std::shared_ptr<const EnvironmentLight> environment_;
  const EmitterMotion* motion_ = nullptr;
  std::unique_ptr<const LightBvh> bvh_;

  // An emitter is a finite light that can emit: an index into triangles_ or, if kPointEmitter is
  // set, into points_. Degenerate, black and non-finite lights are excluded.
  static constexpr uint32_t kPointEmitter = 1u << 31;
  static constexpr uint32_t kNoEmitter = ~0u;
  std::vector<uint32_t> emitters_;
  std::vector<uint32_t> triangle_emitter_;  // per triangle: its emitter, or kNoEmitter
  Vec3f finite_centre_ = Vec3f(0.0f);       // of the emitters' bounds
  float finite_radius2_ = 0.0f;             // squared half diagonal of the bounds
  float finite_intensity_ = 0.0f;           // luminance of all emitters together
  float finite_reach2_ = kInfinity;         // squared distance from the centre that light can reach
  bool ranged_ = false;                     // some emitters have a range
  std::vector<uint32_t> directional_;       // indices into points_
  std::vector<double> power_sums_;          // without a BVH: running sums of relative power

  // The choice between infinite lights (directional, environment) and finite lights. It is made in
  // proportion to irradiance times the factors in KindFactors, and keeps the minimum shares in
  // KindFactors. The irradiance of the finite lights is estimated as if a single lamp with their
  // total intensity were at their centre. The irradiance of the infinite lights is exact, except
  // that the environment is assumed to be uniform.
  struct InfiniteChoice {
    float probability = 0.0f;  // of choosing any infinite light
    float environment = 0.0f;  // weight of the environment
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
  // These functions are used if there is no BVH and some emitters have a range. An emitter is then
  // picked by power among the emitters that reach the query.
  bool reaches(const LightQuery& query, uint32_t emitter) const;
  double share_in_reach(const LightQuery& query) const;
  FinitePick pick_in_reach(const LightQuery& query, double u) const;
  // Chooses a directional light by u_weight, which must be in [0, sum of the lights' weights).
  LightSample sample_directional(const LightQuery& query, const InfiniteChoice& choice,
                                 double u_weight) const;
  LightSample sample_point(const LightQuery& query, uint32_t index, float probability) const;
  // In each sample of `out`, the caller must have set `pdf` to the probability of picking the
  // light. sample_triangles() also requires that `index` is that of the triangle.
  void sample_triangles(TriangleBatch& batch, LightSample* const* out) const;
  void sample_environment(std::span<const GuidedRequest> requests, const EnvironmentGuide* guide,
                          LightSample* const* out) const;
  void measure_finite_lights(std::span<const EmitterBounds> bounds);
  void sum_powers(std::span<const double> powers);
};

}  // namespace emberline
