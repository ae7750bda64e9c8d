// The only file that distinguishes Embree 3.13 from 4. In the renderer, only this folder includes
// it.
#pragma once

#ifndef EMBERLINE_EMBREE_MAJOR
#error "link emberline_embree, which defines the Embree version"
#endif

#if EMBERLINE_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "samplers/coverage_key.h"

namespace emberline::embree {

#if EMBERLINE_EMBREE_MAJOR >= 4
using QueryContext = RTCRayQueryContext;
#else
using QueryContext = RTCIntersectContext;
#endif

// The bytes per object that Embree takes from malloc without telling the memory monitor. They
// include the object's entries in the tables of its scene. We measured them with Embree 3.13.5 and
// 4.4.1 as the growth of mallinfo2()'s figure over 200,000 objects of each kind. These bytes matter
// only in scenes with very many small meshes or instances.
#if EMBERLINE_EMBREE_MAJOR >= 4
inline constexpr uint64_t kTriangleObjectBytes = 502;
inline constexpr uint64_t kInstanceObjectBytes = 54;  // the transform is monitored
inline constexpr uint64_t kSceneObjectBytes = 2630;
#else
inline constexpr uint64_t kTriangleObjectBytes = 470;
inline constexpr uint64_t kInstanceObjectBytes = 294;
inline constexpr uint64_t kSceneObjectBytes = 2700;
#endif

// Optical thickness of partial coverage: the sum of -log2(1 - coverage) along a ray. It is an
// integer, so it does not depend on the order in which Embree visits the surfaces.
//
// Below a transmittance of 1/16, Russian roulette decides, so that a ray need not visit a hundred
// nearly transparent surfaces. The ray ends at a thickness chosen in advance: 4 plus a random
// number with an exponential distribution of base 2. So the ray passes a thickness S > 4 with
// probability 2^(4-S). Its transmittance is then 1/16, so the expected transmittance is 2^-S.
class Thickness {
 public:
  explicit Thickness(CoverageKey key) : key_(key) {}
  // Returns false if the ray ends here.
  bool add(float coverage) {
    if (coverage <= 0.0f) return true;
    if (!(coverage < 1.0f)) return false;
    sum_ += to_fixed_point(1.0f - coverage);
    return sum_ <= kRouletteThickness || sum_ < end_thickness();
  }
  // Call this only for a ray that has not ended.
  float transmittance() const {
    return sum_ == 0 ? 1.0f : std::exp2(float(std::min(sum_, kRouletteThickness)) / -kUnit);
  }

 private:
  static int64_t to_fixed_point(float fraction) { return int64_t(-std::log2(fraction) * kUnit); }
  int64_t end_thickness() const {
    const float u = CoverageNumbers(key_, 0xffffffffu, 0xffffffffu).decision();
    return kRouletteThickness + to_fixed_point(1.0f - u);
  }

  static constexpr float kUnit = 0x1p32f;
  static constexpr int64_t kRouletteThickness = int64_t(4) << 32;
  CoverageKey key_;
  int64_t sum_ = 0;
};

// Ray data that filter callbacks need in addition to Embree's own.
struct RayContext {
  QueryContext base;               // must be first, so that the callback can cast back
  CoverageKey coverage_key;        // decides stochastic coverage; see Scene::intersect
  Thickness* thickness = nullptr;  // set for shadow rays, which accumulate coverage here
};

inline void init_context(RayContext& context, CoverageKey coverage_key) {
#if EMBERLINE_EMBREE_MAJOR >= 4
  rtcInitRayQueryContext(&context.base);
#else
  rtcInitIntersectContext(&context.base);
#endif
  context.coverage_key = coverage_key;
}

// Enables intersect() with a filter for this scene and its instances. Call it before the build.
inline void enable_query_filters(RTCScene scene) {
#if EMBERLINE_EMBREE_MAJOR >= 4
  constexpr auto kFlag = RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;
#else
  constexpr auto kFlag = RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;
#endif
  rtcSetSceneFlags(scene, RTCSceneFlags(rtcGetSceneFlags(scene) | kFlag));
}

// `filter` is called after the geometry's own filter.
inline void intersect(RTCScene scene, RayContext& context, RTCRayHit& ray_hit,
                      RTCFilterFunctionN filter = nullptr) {
#if EMBERLINE_EMBREE_MAJOR >= 4
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = &context.base;
  if (filter) {
    arguments.filter = filter;
    arguments.flags = RTCRayQueryFlags(arguments.flags | RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER);
  }
  rtcIntersect1(scene, &ray_hit, &arguments);
#else
  context.base.filter = filter;
  rtcIntersect1(scene, &context.base, &ray_hit);
  context.base.filter = nullptr;
#endif
}

// Sets ray.tfar to -infinity if the ray is occluded.
inline void occluded(RTCScene scene, RayContext& context, RTCRay& ray) {
#if EMBERLINE_EMBREE_MAJOR >= 4
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.context = &context.base;
  rtcOccluded1(scene, &ray, &arguments);
#else
  rtcOccluded1(scene, &context.base, &ray);
#endif
}

}  // namespace emberline::embree
