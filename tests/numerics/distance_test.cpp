// Cases E9 and E10 test distances. Radiance is constant along a ray. Only the solid angle of an
// emitter matters. An emitter that almost touches a surface fills the hemisphere above it.
#include "receiver.h"

namespace emberline {
namespace {

using namespace test;

// ---- E9 ----------------------------------------------------------------------------------------

TEST(Distance, RadianceIsInvariant) {
  for (const double d : {1e-3, 1.0, 1e3, 1e6}) {
    SceneBuilderForTests b;
    b.add_floor(float(d), float(d), b.add_material(emitter(Rgb(3.25f))), /*up=*/false);
    const auto scene = b.build();
    RenderSettings s = direct_light_settings(16);
    expect_case({"E9", "emitter seen from " + format_value(d) + " m"},
                compared(render(*scene, perspective({0, 0, 0}, {0, d, 0}, 10), s), 3.25, 0),
                replay(s));
    // From large distances, also looks at an emitter of fixed size, through an angle that the
    // emitter fills.
    if (d > 1)
      expect_case(
          {"E9", "emitter of 2 m seen from " + format_value(d) + " m"},
          [&] {
            SceneBuilderForTests small;
            small.add_floor(1, 0, small.add_material(emitter(Rgb(3.25f))), /*up=*/false);
            const double degrees = .5 / d * 180 / kPiD;
            return compared(render(*small.build(), perspective({0, -d, 0}, {0, 0, 0}, degrees), s),
                            3.25, 0);
          }(),
          replay(s));
  }
}

// An emitter whose size grows in proportion to its distance gives the same irradiance.
TEST(Distance, OnlySolidAngleCounts) {
  for (const double d : {1e-3, 1.0, 1e3, 1e6}) {
    Emitters lamp;
    lamp.add({{-.5 * d, 1.2 * d, -.3 * d},
              {.9 * d, 1.2 * d, -.3 * d},
              {.9 * d, 1.2 * d, .7 * d},
              {-.5 * d, 1.2 * d, .7 * d}});
    Receiver r;
    r.half_size = .1 * d;
    r.camera_height = .05 * d;
    r.view_half_size = 1e-5 * d;
    EXPECT_NEAR(exact_irradiance(lamp, r.point, r.normal), .683537, 1e-6);
    expect_irradiance_of(lamp, r, {"E9", "the rectangle of case 6, all times " + format_value(d)},
                         false);
  }
}

// ---- E10 ---------------------------------------------------------------------------------------

Emitters lamp_overhead(double gap) {
  Emitters lamp;
  lamp.add({{-1, gap, -1}, {1, gap, -1}, {1, gap, 1}, {-1, gap, 1}});
  return lamp;
}

// Under a 2 x 2 lamp at height `gap`, E is pi up to the square of `gap`. Rays start about 3e-7 off
// each surface, so 4e-6 is close to the smallest gap that works.
TEST(Distance, AlmostTouching) {
  for (const double gap : {1e-2, 1e-3, 1e-4, 3e-5}) {
    Receiver r;
    r.half_size = .5;
    r.camera_height = gap / 2;
    expect_irradiance_of(lamp_overhead(gap), r, {"E10", "lamp overhead at " + format_value(gap)},
                         true);
  }
}

TEST(Distance, TouchingWithinTenOffsets) {
  const double gap = 4e-6;
  Receiver r;
  r.half_size = .5;
  r.camera_height = gap / 2;
  const Emitters lamp = lamp_overhead(gap);
  SceneBuilderForTests b;
  add_receiver(b, r);
  add_emitters(b, lamp);
  const RenderSettings s = direct_light_settings(32768);
  const double exact = exact_irradiance(lamp, r.point, r.normal);
  expect_known_failure(
      {"E10", "lamp overhead at " + format_value(gap)},
      measured_irradiance(render(*b.build(), view_of(r), s), exact, 1e-5 * exact), .02 * exact,
      "lights are sampled from the surface, rays start an offset of 3e-7 above it: the two see "
      "another triangle along one direction, and their weights miss 1 by some offset / gap near "
      "the lamp's diagonal. Sampling from the rays' origin mends it (measured), but moves every "
      "light by the offset, 5e-4 of a floor of 1000: worse",
      replay(s));
}

// At its foot, an emissive wall fills a quarter of the sphere, so E tends to pi / 2. Nearly all of
// the light comes from a strip that is as high as the distance between the point and the wall.
TEST(Distance, FootOfAShiningWall) {
  for (const double gap : {1e-2, 1e-4, 1e-6}) {
    Emitters wall;
    wall.add({{gap, 0, -1}, {gap, 0, 1}, {gap, 1, 1}, {gap, 1, -1}});
    Receiver r;
    r.half_size = .5;
    r.camera_height = gap / 2;
    r.view_half_size = gap * 1e-3;
    const double exact = exact_irradiance(wall, r.point, r.normal);
    EXPECT_NEAR(exact, kPiD / 2, 2 * gap);
    expect_irradiance_of(wall, r, {"E10", "foot of a wall at " + format_value(gap)}, true);
  }
}

}  // namespace
}  // namespace emberline
