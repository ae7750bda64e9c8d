// Extreme cases: flattened and sheared instances, lamps in the receiver's plane, triangles far
// smaller than a pixel, radiances at the ends of float's range, a thousand layers in one plane.
#include "closed_form.h"

#include "support/closed_forms.h"
#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

RenderSettings extreme_settings() {
  RenderSettings s;
  s.spp = 64;
  s.max_depth = 1000;
  return s;
}

Mat44d linear(const Vec3d& x, const Vec3d& y, const Vec3d& z) {
  Mat44d m;
  for (int c = 0; c < 3; ++c) m[0][c] = x[c], m[1][c] = y[c], m[2][c] = z[c];
  return m;
}

// A closed cavity of any shape shows Le / (1 - rho) = 1. Rays start off a surface by d = 4.8e-7
// max, which is 4 ulp of the largest coordinate `max`. So they escape where the cavity is thinner
// than d, which is at its rim or everywhere. An ellipsoid of thickness 2 a is thinner than d over
// the share (d / 2a)^2 of its outline.
TEST(Extremes, FlattenedCavity) {
  struct Shape {
    const char* name;
    Mat44d to_world;
    double thickness, largest;
  };
  const Shape shapes[] = {
      {"1e-2 x 1 x 1e2", linear({1e-2, 0, 0}, {0, 1, 0}, {0, 0, 1e2}), 2e-2, 1e2},
      {"1e2 x 1 x 1e-2, mirrored", linear({-1e2, 0, 0}, {0, 1, 0}, {0, 0, 1e-2}), 2e-2, 1e2},
      // The largest singular value is 10 sqrt 2 and the determinant is 1, so the smallest singular
      // value is 1 / (10 sqrt 2).
      {"sheared by 10", linear({1, 10, 0}, {0, 1, 0}, {0, 10, 1}), .14, 14},
      {"1e-4 x 1 x 1e4", linear({1e-4, 0, 0}, {0, 1, 0}, {0, 0, 1e4}), 2e-4, 1e4}};
  for (const Shape& shape : shapes) {
    for (const bool instanced : {false, true}) {
      SceneBuilderForTests b;
      MaterialDescription m = lambert(Rgb(.8f));
      m.emission = Rgb(.2f);
      const int mesh = b.add_mesh(SceneBuilderForTests::sphere(1, 24, b.add_material(m), true));
      b.place(mesh, shape.to_world);
      if (instanced) b.place(mesh, shape.to_world * translation(3 * shape.largest, 0, 0));
      const RenderSettings s = extreme_settings();
      const RenderedImage image = render(*b.build(), perspective({0, 0, 0}, {.1, .3, -1}, 90), s);
      // The error bound of an instance adds up the terms of its transform. Here it is up to 6 times
      // the bound of a baked mesh.
      const double offset = (instanced ? 6 : 1) * 0x1p-21 * shape.largest;
      // A path has 1 / (1 - rho) = 5 segments, and each of them may hit the rim.
      const double lost = 5 * square(offset / shape.thickness);
      const CaseName name{"E28",
                          std::string("cavity ") + shape.name + (instanced ? ", instanced" : "")};
      if (lost < 1) {
        expect_exact(image, 1.0, 1e-5 + lost, s, name);
      } else {
        expect_known_failure(name, {1, image.mean, image.standard_error, 1e-5}, .81,
                             "thinner than the distance at which rays leave its surface, 4 ulp of "
                             "the largest coordinate whatever its direction",
                             replay(s));
      }
    }
  }
}

// Normals transform by the inverse transpose. The tolerance is 1e-6, since they are rounded to
// float about five times.
TEST(Extremes, NormalsUnderShear) {
  const Vec3f object = normalize(Vec3f(.3f, .9f, -.2f));
  const std::pair<const char*, Mat44d> shapes[] = {
      {"stretched", linear({1e-3, 0, 0}, {0, 1e3, 0}, {0, 0, 2})},
      {"sheared", linear({1, .5, 0}, {.2, 1, -.7}, {0, .3, 3})},
      {"mirrored", linear({-1, .5, 0}, {.2, 1, -.7}, {0, .3, 3})}};
  for (const auto& [name, shape] : shapes) {
    for (const bool instanced : {false, true}) {
      SceneBuilderForTests b;
      MeshDescription mesh;
      mesh.name = "leaf";
      mesh.material = b.add_material(lambert(Rgb(1.0f)));
      for (const float x : {-1.0f, 1.0f}) mesh.positions.emplace_back(x, 0.0f, 1.0f);
      for (const float x : {1.0f, -1.0f}) mesh.positions.emplace_back(x, 0.0f, -1.0f);
      mesh.normals.assign(4, object);
      mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
      const int index = b.add_mesh(mesh);
      b.place(index, shape);
      if (instanced) b.place(index, shape * translation(1e3, 0, 0));
      b.set_environment(Rgb(1.0f));
      const auto scene = b.build();
      const Mat44d inverse = shape.inverse();
      Vec3d shading, face;
      const Vec3d n(object);
      for (int i = 0; i < 3; ++i) {
        shading[i] = inverse[i][0] * n.x + inverse[i][1] * n.y + inverse[i][2] * n.z;
        face[i] = inverse[i][1];
      }
      Vec3d target;
      shape.multVecMatrix(Vec3d(.1, 0, .2), target);
      const Vec3d away = face.normalized();
      const Vec3d from = (target + away * .5 - scene->origin()) * scene->scale();
      SurfaceHit hit;
      ASSERT_TRUE(scene->intersect({Vec3f(from), Vec3f(-away)}, {}, &hit)) << name;
      SurfaceInteraction s;
      scene->interaction(hit, 0, &s);
      const std::string what = std::string(name) + (instanced ? ", instanced" : "");
      expect_case({"E29", "angle of the face normal, " + what},
                  {0, (Vec3d(s.geometric_normal) - away).length(), 0, 1e-6}, "one ray");
      expect_case({"E29", "angle of the vertex normal, " + what},
                  {0, (Vec3d(s.shading_normal) - shading.normalized()).length(), 0, 1e-6},
                  "one ray");
    }
  }
}

// A lamp that stands on the receiver, with its lower edge in the floor, gives Lambert's formula for
// a rectangle that the horizon cuts. A lamp that lies beside the receiver, in the receiver's plane,
// gives no light.
TEST(Extremes, LampInTheReceiversPlane) {
  RenderSettings s = extreme_settings();
  s.spp = 1024;
  s.max_depth = 1;
  for (const bool standing : {true, false}) {
    SceneBuilderForTests b;
    MaterialDescription lamp = emitter(Rgb(1.0f));
    lamp.double_sided = true;
    const int material = b.add_material(lamp);
    if (standing) {
      b.add_quad({.5f, 0, -1}, {.5f, 0, 1}, {.5f, 1, 1}, {.5f, 1, -1}, material);
    } else {
      b.add_quad({.5f, 0, 1}, {2, 0, 1}, {2, 0, -1}, {.5f, 0, -1}, material);
    }
    b.add_quad({-3, 0, 3}, {.5f, 0, 3}, {.5f, 0, -3}, {-3, 0, -3},
               b.add_material(lambert(Rgb(1.0f))));
    const double exact =
        standing ? polygon_irradiance({{.5, 0, -1}, {.5, 0, 1}, {.5, 1, 1}, {.5, 1, -1}},
                                      Vec3d(0.0), Vec3d(0, 1, 0)) /
                       kPiD
                 : 0;
    expect_exact(render(*b.build(), orthographic({0, .4, 0}, {0, 0, 0}, 1e-4), s), exact, 1e-5, s,
                 {"E30", standing ? "lamp standing on the receiver" : "lamp in the same plane"});
  }
}

// A ball has a radius of .07 pixel and two million triangles of 1e-4 pixel. It covers pi .07^2 of
// each pixel. Its outline is a polygon of 2828 sides, whose area is 2e-6 short of a circle's.
TEST(Extremes, TrianglesFarBelowAPixel) {
  SceneBuilderForTests b;
  MaterialDescription bright;  // visible, but not sampled as one of 128 million lamps
  bright.unlit = true;
  const int mesh = b.add_mesh(SceneBuilderForTests::sphere(.07f, 707, b.add_material(bright)));
  constexpr int kSide = 8;
  // Every pixel holds one ball, at (.3, .6) of the pixel.
  for (int i = 0; i < kSide * kSide; ++i) {
    b.place(mesh, translation(i % kSide - kSide / 2 + .3, 0, i / kSide - kSide / 2 + .6));
  }
  RenderSettings s = extreme_settings();
  s.width = s.height = kSide;
  s.spp = 4096;
  s.max_depth = 0;
  expect_exact(render(*b.build(), orthographic({0, 1, 0}, {0, 0, 0}, kSide / 2), s),
               kPiD * square(.07), 1e-5, s, {"E31", "64 balls of 2e6 triangles, .07 px"});
}

// One lamp or 64 lamps illuminate a floor, with radiances at the ends of float's range. 1e-40 is
// denormal. It may become 0, but not infinity or NaN, and the irradiance is below 1.2e-38 in either
// case.
TEST(Extremes, RadianceAtTheEndsOfFloat) {
  for (const float radiance : {1e-40f, 1e-30f, 1e30f, 1e38f}) {
    for (const int lamps : {1, 64}) {
      SceneBuilderForTests b;
      const int material = b.add_material(emitter(Rgb(radiance)));
      const int n = lamps == 1 ? 1 : 8;
      for (int i = 0; i < lamps; ++i) {
        const float size = 2.0f / float(n), x = -1 + size * float(i % n),
                    z = -1 + size * float(i / n);
        b.add_quad({x, 1, z}, {x + size, 1, z}, {x + size, 1, z + size}, {x, 1, z + size},
                   material);
      }
      b.add_floor(10, 0, b.add_material(lambert(Rgb(1.0f))));
      RenderSettings s = extreme_settings();
      s.spp = long_or_short(1024u, 256u);
      s.max_depth = 1;
      const RenderedImage image = render(*b.build(), orthographic({0, .4, 0}, {0, 0, 0}, 1e-4), s);
      const double share = polygon_irradiance({{-1, 1, -1}, {1, 1, -1}, {1, 1, 1}, {-1, 1, 1}},
                                              Vec3d(0.0), Vec3d(0, 1, 0)) /
                           kPiD;
      const double tiny = radiance < 1e-38f ? 1 : 1e-5;
      char what[64];
      std::snprintf(what, sizeof what, "radiance %g, %d lamps, over it", double(radiance), lamps);
      expect_case({"E32", what},
                  {share, image.mean / double(radiance), image.standard_error / double(radiance),
                   tiny * share},
                  replay(s));
      EXPECT_EQ(image.counters.non_finite_samples, 0u) << what;
    }
  }
}

// A thousand layers of alpha .001, in one plane or stacked, let (1 - .001)^1000 of the sky pass,
// since each layer decides independently.
TEST(Extremes, AThousandLayers) {
  for (const bool stacked : {false, true}) {
    SceneBuilderForTests b;
    MaterialDescription veil = lambert(Rgb(0.0f));
    veil.alpha = .001f;
    veil.alpha_mode = AlphaMode::kBlend;
    veil.double_sided = true;
    const int material = b.add_material(veil);
    MeshDescription layers;
    layers.name = "layers";
    layers.material = material;
    for (uint32_t i = 0; i < 1000; ++i) {
      const float y = stacked ? .001f * float(i) : 0;
      // Each layer is one triangle, so that no ray hits a diagonal twice.
      layers.positions.emplace_back(-9.0f, y, -9.0f);
      layers.positions.emplace_back(0.0f, y, 9.0f);
      layers.positions.emplace_back(9.0f, y, -9.0f);
      layers.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    b.place(b.add_mesh(layers));
    b.set_environment(Rgb(1.0f));
    RenderSettings s = extreme_settings();
    s.spp = long_or_short(256u, 64u);
    // The tolerance of 1e-4 covers two errors that add up over the 1000 layers: .001 is rounded to
    // a float, and the random numbers that decide coverage have only 24 bits (CoverageNumbers).
    expect_exact(render(*b.build(), orthographic({0, 5, 0}, {.1, 0, .1}, 1), s),
                 std::pow(.999, 1000), 1e-4, s,
                 {"E33", stacked ? "1000 layers of alpha .001, stacked"
                                 : "1000 layers of alpha .001 in one plane"});
  }
}

}  // namespace
}  // namespace emberline
