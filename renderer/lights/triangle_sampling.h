// Samples points on a triangle uniformly in solid angle as seen from a point.
//
// For solid angles between kMinSphericalAngle and kMaxSphericalAngle, sampling follows Arvo 1995,
// "Stratified Sampling of Spherical Triangles". Outside this range, samples are uniform in area,
// with density d^2 / (A |cos|). Below the range, the spherical triangle is flat to float accuracy
// and both methods agree; above it, the point is almost on the triangle. The choice of method
// depends only on the triangle and the point, so a ray that hits the triangle by chance gets the
// same density as a sample of the same position.
//
// The geometry is computed in double, since differences of positions cancel, and a spherical excess
// of 3e-4 sr would have no significant digits in float. The code works at any scale at which
// coordinates are between 1e-30 and 1e30.
#pragma once

#include <array>

#include "renderer/core/constants.h"
#include "renderer/core/ray.h"
#include "renderer/core/vector.h"

namespace emberline {

// pbrt-v4's limits are 3e-4 and 6.22 (Triangle::MinSphericalSampleArea, MaxSphericalSampleArea). As
// we use double, our upper limit can be almost a hemisphere. Sampling by area is bad at such large
// solid angles: for a point whose height above a triangle is a thousandth of an edge, 1e5 samples
// find only a sixth of the triangle's light (triangle_sampling_test, "a thousandth").
inline constexpr double kMinSphericalAngle = 3e-4;
inline constexpr double kMaxSphericalAngle = 2 * kPiD - 1e-4;

struct ProjectedTriangle {
  Vec3d to_p0 = Vec3d(0.0);                              // from the point to vertex 0
  Vec3d edge1 = Vec3d(0.0), edge2 = Vec3d(0.0);          // from vertex 0 to 1 and 2
  Vec3d a = Vec3d(0.0), b = Vec3d(0.0), c = Vec3d(0.0);  // unit, from the point to the vertices
  Vec3d normal = Vec3d(0.0);                             // unit, along edge1 x edge2
  double area = 0.0;         // 0: degenerate, or the point is in its plane; cannot be sampled
  double height = 0.0;       // signed distance of the point from the plane; > 0 in front
  double solid_angle = 0.0;  // Van Oosterom & Strackee 1983, "The Solid Angle of a Plane Triangle"

  bool spherical() const {
    return solid_angle > kMinSphericalAngle && solid_angle < kMaxSphericalAngle;
  }
};

ProjectedTriangle project_triangle(const Vec3f& p0, const Vec3f& p1, const Vec3f& p2,
                                   const Vec3f& point);

struct TriangleSample {
  Vec2f barycentric = Vec2f(0.0f);  // weights of p1 and p2
  Vec3f position = Vec3f(0.0f);
  Vec3f direction = Vec3f(0.0f);  // unit, from the point
  float distance = 0.0f;
  float pdf = 0.0f;  // per solid angle; 0 if nothing was sampled
};

// Computes up to kRayBatch samples at once with vector instructions. This takes a third of the time
// of computing them one by one, and the results are bit-identical. Call add() for each sample, then
// sample(), then read the samples by index.
class TriangleBatch {
 public:
  int size() const { return count_; }
  void add(const std::array<Vec3f, 3>& corners, const Vec3f& point, const Vec2f& u);
  void sample();

  bool in_front(int i) const { return height_[i] > 0; }  // whether the query's point is in front
  Vec3f normal(int i) const { return {normal_[0][i], normal_[1][i], normal_[2][i]}; }
  TriangleSample operator[](int i) const {
    return {{barycentric_[0][i], barycentric_[1][i]},
            {position_[0][i], position_[1][i], position_[2][i]},
            {direction_[0][i], direction_[1][i], direction_[2][i]},
            distance_[i],
            pdf_[i]};
  }

 private:
  using Lanes = float[kRayBatch];
  void evaluate(int i);
  void evaluate_single(int i);

  int count_ = 0;
  Lanes corners_[3][3], point_[3], u_[2];
  Lanes barycentric_[2], position_[3], direction_[3], normal_[3], distance_, pdf_;
  double height_[kRayBatch];
};

// Returns the density of a sample on the triangle that is `distance` away from the point.
float triangle_pdf(const ProjectedTriangle& triangle, float distance);

}  // namespace emberline
