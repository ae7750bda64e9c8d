// A textbook path tracer in double precision. It uses brute-force intersection (Moeller & Trumbore
// 1997), uniform directions over the hemisphere and std::mt19937_64, but no light sampling and no
// roulette. It shares only the scene description with the renderer, so agreement cannot come from a
// shared mistake. It supports only Lambertian surfaces and a constant sky.
#pragma once

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "renderer/core/constants.h"
#include "renderer/core/vector.h"
#include "renderer/description/scene_description.h"

namespace emberline::test {

class NaivePathTracer {
 public:
  NaivePathTracer(const SceneDescription& scene, const CameraDescription& camera, double aspect)
      : camera_(camera), aspect_(aspect) {
    for (const InstanceDescription& instance : scene.instances) {
      const MeshDescription& mesh = scene.meshes[size_t(instance.mesh)];
      const MaterialDescription& m = scene.materials[size_t(mesh.material)];
      for (const std::array<uint32_t, 3>& t : mesh.triangles) {
        const auto corner = [&](size_t i) {
          return transformed(Vec3d(mesh.positions[t[i]]), 1, instance.to_world);
        };
        Triangle triangle;
        triangle.a = corner(0);
        triangle.ab = corner(1) - triangle.a;
        triangle.ac = corner(2) - triangle.a;
        const Vec3d n = triangle.ab.cross(triangle.ac);
        triangle.n = n / std::sqrt(n.dot(n));
        triangle.albedo = Vec3d(m.base_color);
        triangle.emission = Vec3d(m.emission);
        triangle.double_sided = m.double_sided;
        triangles_.push_back(triangle);
      }
    }
    if (scene.environment) sky_ = Vec3d(scene.environment->constant);
  }

  // Returns the radiance through the point (x, y) of the frame, from paths of at most `max_depth`
  // scattering events. x and y are in [0, 1], and y grows downwards.
  Vec3d radiance(double x, double y, int max_depth, std::mt19937_64& random) const {
    std::uniform_real_distribution<double> uniform(0, 1);
    const double half = std::tan(camera_.fov_y / 2);
    Vec3d origin = transformed(Vec3d(0.0), 1, camera_.to_world);
    Vec3d d =
        transformed({(2 * x - 1) * half * aspect_, (1 - 2 * y) * half, -1}, 0, camera_.to_world);
    d /= std::sqrt(d.dot(d));
    Vec3d sum(0.0), throughput(1.0);
    const Triangle* from = nullptr;
    for (int depth = 0;; ++depth) {
      double distance = 1e300;
      const Triangle* hit = nullptr;
      for (const Triangle& t : triangles_)
        if (&t != from && (t.double_sided || t.n.dot(d) < 0) && intersects(t, origin, d, &distance))
          hit = &t;
      if (!hit) return sum + throughput * sky_;
      sum += throughput * hit->emission;
      if (depth == max_depth) return sum;
      origin += d * distance;
      const Vec3d n = hit->n.dot(d) < 0 ? hit->n : -hit->n;
      const Vec3d aside = std::abs(n.x) < 0.5 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0);
      Vec3d u = n.cross(aside);
      u /= std::sqrt(u.dot(u));
      const Vec3d v = n.cross(u);
      // The direction is uniform over the hemisphere, with a pdf of 1 / 2 pi. So the weight is
      // albedo / pi cos, divided by that pdf.
      const double z = uniform(random), r = std::sqrt(1 - z * z);
      const double phi = 2 * kPiD * uniform(random);
      d = u * (r * std::cos(phi)) + v * (r * std::sin(phi)) + n * z;
      throughput *= hit->albedo * (2 * z);
      from = hit;
    }
  }

 private:
  struct Triangle {
    Vec3d a, ab, ac, n, albedo, emission;
    bool double_sided = false;
  };

  // Transforms a point (w = 1) or a direction (w = 0), as a row vector.
  static Vec3d transformed(const Vec3d& p, double w, const Mat44d& m) {
    Vec3d result;
    for (int c = 0; c < 3; ++c)
      result[c] = p.x * m[0][c] + p.y * m[1][c] + p.z * m[2][c] + w * m[3][c];
    return result;
  }

  static bool intersects(const Triangle& t, const Vec3d& origin, const Vec3d& d, double* distance) {
    const Vec3d p = d.cross(t.ac);
    const double determinant = t.ab.dot(p);
    if (determinant == 0) return false;
    const Vec3d s = origin - t.a;
    const double u = s.dot(p) / determinant;
    if (u < 0 || u > 1) return false;
    const Vec3d q = s.cross(t.ab);
    const double v = d.dot(q) / determinant;
    if (v < 0 || u + v > 1) return false;
    const double along = t.ac.dot(q) / determinant;
    if (!(along > 0) || along >= *distance) return false;
    *distance = along;
    return true;
  }

  std::vector<Triangle> triangles_;
  Vec3d sky_ = Vec3d(0.0);
  CameraDescription camera_;
  double aspect_;
};

}  // namespace emberline::test
