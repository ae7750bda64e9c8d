// A white receiver under emitters, and the irradiance that the receiver must show.
#pragma once

#include <string>
#include <vector>

#include "closed_form.h"
#include "support/closed_forms.h"
#include "support/scenes.h"

namespace emberline::test {

// Convex polygons, each with its radiance. Their corners are in counter-clockwise order, as seen
// from the side that emits.
struct Emitters {
  struct Polygon {
    std::vector<Vec3d> corners;
    double radiance = 1;
  };
  std::vector<Polygon> polygons;

  void add(std::vector<Vec3d> corners, double radiance = 1) {
    // Rounds the corners to float, as the mesh does.
    for (Vec3d& c : corners) c = Vec3d(Vec3f(c));
    polygons.push_back({std::move(corners), radiance});
  }
  // Adds each triangle of `mesh`, moved to `center`.
  void add_mesh(const MeshDescription& mesh, const Vec3d& center, double radiance = 1) {
    for (const std::array<uint32_t, 3>& t : mesh.triangles) {
      std::vector<Vec3d> corners;
      for (const uint32_t v : t) corners.push_back(Vec3d(mesh.positions[v]) + center);
      add(std::move(corners), radiance);
    }
  }
  // Adds a regular polygon in the plane y = height that faces down.
  void add_disk(double radius, double height, int sides, double radiance = 1) {
    std::vector<Vec3d> corners;
    for (int i = 0; i < sides; ++i) {
      const double phi = 2 * kPiD * i / sides;
      corners.emplace_back(radius * std::cos(phi), height, radius * std::sin(phi));
    }
    add(std::move(corners), radiance);
  }
};

// Assumes that nothing is occluded: the emitters form one convex body, or do not overlap as seen
// from the point.
inline double exact_irradiance(const Emitters& emitters, const Vec3d& point, const Vec3d& n) {
  double sum = 0;
  for (const Emitters::Polygon& p : emitters.polygons) {
    const Vec3d face = cross(p.corners[1] - p.corners[0], p.corners[2] - p.corners[0]);
    if (dot(face, point - p.corners[0]) <= 0) continue;
    sum += p.radiance * polygon_irradiance(p.corners, point, n);
  }
  return sum;
}

struct Receiver {
  Vec3d point = Vec3d(0.0);
  Vec3d normal = Vec3d(0, 1, 0);
  double half_size = 0.2;        // of the receiver's square
  double camera_height = 0.2;    // distance along the normal, on the near side of all lamps
  double view_half_size = 1e-5;  // of the camera's view, within which E is constant
};

inline void add_receiver(SceneBuilderForTests& b, const Receiver& r, float albedo = 1) {
  const Vec3d side = std::abs(r.normal.y) < .9 ? Vec3d(0, 1, 0) : Vec3d(1, 0, 0);
  const Vec3d u = unit(cross(side, r.normal)) * r.half_size, v = cross(r.normal, u);
  // The square is off centre, so that its diagonal does not cross the view.
  const Vec3d c = r.point + u * 0.3 - v * 0.1;
  b.add_quad(Vec3f(c - u - v), Vec3f(c + u - v), Vec3f(c + u + v), Vec3f(c - u + v),
             b.add_material(lambert(Rgb(albedo))));
}

inline CameraDescription view_of(const Receiver& r) {
  return orthographic(r.point + r.normal * r.camera_height, r.point, r.view_half_size);
}

// Adds one mesh for each radiance, with all polygons of that radiance.
inline void add_emitters(SceneBuilderForTests& b, const Emitters& emitters) {
  std::vector<double> radiances;
  for (const Emitters::Polygon& p : emitters.polygons)
    if (std::find(radiances.begin(), radiances.end(), p.radiance) == radiances.end())
      radiances.push_back(p.radiance);
  for (const double radiance : radiances) {
    MeshDescription mesh;
    mesh.name = "lamp";
    mesh.material = b.add_material(emitter(Rgb(float(radiance))));
    for (const Emitters::Polygon& p : emitters.polygons) {
      if (p.radiance != radiance) continue;
      const uint32_t first = uint32_t(mesh.positions.size());
      for (const Vec3d& c : p.corners) mesh.positions.push_back(Vec3f(c));
      for (uint32_t i = 1; i + 1 < p.corners.size(); ++i)
        mesh.triangles.push_back({first, first + i, first + i + 1});
    }
    b.place(b.add_mesh(std::move(mesh)));
  }
}

// Compares the irradiance E with `exact`. The picture shows E / pi, which the receiver reflects.
inline Comparison measured_irradiance(const RenderedImage& image, double exact, double tolerance) {
  EXPECT_EQ(image.counters.non_finite_samples, 0u);
  return {exact, image.mean * kPiD, image.standard_error * kPiD, tolerance};
}

inline RenderSettings direct_light_settings(uint32_t spp = 1024) {
  RenderSettings s;
  s.width = s.height = 8;
  s.spp = spp;
  s.max_depth = 1;
  return s;
}

// Compares the irradiance with its exact value: by light and BSDF sampling together and, if
// `bsdf_alone`, also by BSDF sampling alone.
inline void expect_irradiance_of(const Emitters& emitters, const Receiver& receiver,
                                 const CaseName& name, bool bsdf_alone) {
  const double tolerance = 1e-5;  // float arithmetic
  const double exact = exact_irradiance(emitters, receiver.point, receiver.normal);
  SceneBuilderForTests b;
  add_receiver(b, receiver);
  add_emitters(b, emitters);
  const auto scene = b.build();
  RenderSettings s = direct_light_settings();
  s.seed = seed_of(name);
  expect_case(name,
              measured_irradiance(render(*scene, view_of(receiver), s), exact, tolerance * exact),
              replay(s));
  if (!bsdf_alone) return;
  s.light_samples = 0;
  ++s.seed;
  s.spp = long_or_short(2048u, 512u);
  expect_case({name.number, name.what + ", BSDF sampling alone"},
              measured_irradiance(render(*scene, view_of(receiver), s), exact, tolerance * exact),
              replay(s));
}

}  // namespace emberline::test
