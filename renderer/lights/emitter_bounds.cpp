#include <algorithm>
#include <array>
#include <cmath>

#include "renderer/core/constants.h"
#include "renderer/lights/light_bvh.h"

namespace emberline {
namespace {

using Corners = std::array<Vec3f, 3>;

// Returns bounds with intensity 0 if the triangle is not finite or has no area.
EmitterBounds triangle_bounds(const EmissiveTriangle& t, const Corners& p) {
  EmitterBounds b;
  b.two_sided = t.two_sided;
  if (!is_finite(p[0]) || !is_finite(p[1]) || !is_finite(p[2])) return b;
  const Vec3d n = cross(Vec3d(p[1]) - Vec3d(p[0]), Vec3d(p[2]) - Vec3d(p[0]));
  const double twice_area = std::sqrt(dot(n, n));
  if (!(twice_area > 0)) return b;
  for (int i = 0; i < 3; ++i) {
    b.lower[i] = std::min({p[0][i], p[1][i], p[2][i]});
    b.upper[i] = std::max({p[0][i], p[1][i], p[2][i]});
  }
  b.axis = Vec3f(n / twice_area);
  b.intensity = double(luminance(t.mean_radiance)) * (0.5 * twice_area);
  return b;
}

double angle_between(const Vec3f& a, const Vec3f& b) {
  return std::acos(std::clamp(double(dot(a, b)), -1.0, 1.0));
}

// Returns bounds that hold at all steps and during the motion between them. Between consecutive
// steps, points move along a line or an arc of less than an eighth of a turn. Such an arc bulges
// out of the box around its ends by less than a quarter of the distance between the ends. Along the
// arc, the axis turns by no more than the angle between its directions at the ends.
EmitterBounds swept_bounds(std::span<const EmitterBounds> steps) {
  EmitterBounds all;
  Vec3f axis(0.0f);
  double turn = 0;
  const EmitterBounds* before = nullptr;
  for (const EmitterBounds& b : steps) {
    if (!(b.intensity > 0)) continue;
    Vec3f margin(0.0f);
    if (before) {
      const Vec3f low = b.lower - before->lower, high = b.upper - before->upper;
      margin = Vec3f(0.25f * std::max(max_abs_component(low), max_abs_component(high)));
      turn = std::max(turn, angle_between(b.axis, before->axis));
    } else {
      all = b;
    }
    for (int c = 0; c < 3; ++c) {
      all.lower[c] = std::min(all.lower[c], b.lower[c] - margin[c]);
      all.upper[c] = std::max(all.upper[c], b.upper[c] + margin[c]);
      if (before) {
        all.lower[c] = std::min(all.lower[c], before->lower[c] - margin[c]);
        all.upper[c] = std::max(all.upper[c], before->upper[c] + margin[c]);
      }
    }
    all.intensity = std::max(all.intensity, b.intensity);
    axis += b.axis;
    before = &b;
  }
  if (!before) return all;
  all.axis = normalize_or(axis, all.axis);
  double away = 0;
  for (const EmitterBounds& b : steps) {
    if (b.intensity > 0) away = std::max(away, angle_between(b.axis, all.axis));
  }
  const double o = std::acos(std::clamp(double(all.cos_theta_o), -1.0, 1.0));
  if (away > 0) all.cos_theta_o = float(std::cos(std::min(kPiD, o + away + turn)));
  return all;
}

// The emitter turns by less than half a turn in a segment, so by less than an eighth of a turn in a
// step.
constexpr int kStepsPerSegment = 4;

EmitterBounds moving_bounds(const EmissiveTriangle& t, const EmitterMotion& motion) {
  const int times = kStepsPerSegment * motion.segments(t);
  std::vector<EmitterBounds> steps;
  for (int i = 0; i <= times; ++i) {
    steps.push_back(triangle_bounds(t, motion.corners(t, float(i) / float(times))));
  }
  return swept_bounds(steps);
}

EmitterBounds point_bounds(const PointLight& light, const PointLightPlace& place) {
  EmitterBounds b;
  b.lower = b.upper = place.position;
  b.intensity = double(luminance(light.intensity));
  b.reach = light.range;
  if (light.type == PointLightType::kPoint) {
    b.axis = Vec3f(0, 0, 1);
    b.cos_theta_o = -1.0f;
    return b;
  }
  b.axis = place.direction;
  // If the inner and outer cone nearly coincide, the falloff formula makes the falloff between them
  // wider, but the light stays within these bounds.
  const double outer = std::acos(std::clamp(double(light.cos_outer), -1.0, 1.0));
  const double inner = std::acos(std::clamp(double(light.cos_inner), -1.0, 1.0));
  b.cos_theta_o = float(std::cos(std::min(inner, outer)));
  b.cos_theta_e = float(std::cos(std::clamp(outer - inner, 0.0, kPiD / 2)));
  return b;
}

}  // namespace

EmitterBounds bounds_of(const EmissiveTriangle& triangle, const EmitterMotion* motion) {
  if (triangle.moves) return moving_bounds(triangle, *motion);
  return triangle_bounds(triangle, {triangle.p0, triangle.p1, triangle.p2});
}

EmitterBounds bounds_of(const PointLight& light) {
  if (light.motion.empty()) return point_bounds(light, light);
  const size_t times = kStepsPerSegment * light.motion.size();
  std::vector<EmitterBounds> steps;
  for (size_t i = 0; i <= times; ++i) {
    steps.push_back(point_bounds(light, light.place_at(float(i) / float(times))));
  }
  return swept_bounds(steps);
}

}  // namespace emberline
