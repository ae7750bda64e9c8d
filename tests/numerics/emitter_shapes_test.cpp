// Cases 6 to 9: rectangles, spheres, disks and suns, above and across the horizon, near and far.
// Every exact value is Lambert's formula, evaluated in double over the mesh's actual polygons
// (support/closed_forms.h). The formula for the smooth shape checks this value.
#include "receiver.h"

namespace emberline {
namespace {

using namespace test;

// ---- case 6 ------------------------------------------------------------------------------------

// The corner formula of the catalogue: F = 1/2pi [A / sqrt(1 + A^2) atan(B / sqrt(1 + A^2)) + ...].
double corner_form_factor(double a, double b) {
  const double x = std::sqrt(1 + a * a), y = std::sqrt(1 + b * b);
  return (a / x * std::atan(b / x) + b / y * std::atan(a / y)) / (2 * kPiD);
}

TEST(RectangleLight, OverTheCorner) {
  for (const auto& [a, b, h] :
       {std::tuple{1.0, 1.0, 1.0}, std::tuple{5.0, .3, .5}, std::tuple{.01, .02, 1.0}}) {
    Emitters lamp;
    lamp.add({{0, h, 0}, {a * h, h, 0}, {a * h, h, b * h}, {0, h, b * h}});
    const double exact = kPiD * corner_form_factor(a, b);
    // The tolerance is 1e-6, since the corners are rounded to float.
    EXPECT_NEAR(exact_irradiance(lamp, Vec3d(0.0), {0, 1, 0}), exact, 1e-6 * exact);
    expect_irradiance_of(lamp, {},
                         {"6", "over the corner, a " + format_value(a) + ", b " + format_value(b)},
                         exact > .05);
  }
}

// Tests a wall that stands on the receiver's plane, walls that cross the plane, and tilted ones.
// The part below the horizon gives no light, and samples there must not lose energy.
TEST(RectangleLight, AcrossTheHorizon) {
  const auto wall = [](double bottom, double top, double lean) {
    Emitters lamp;
    lamp.add({{1 + lean * bottom, bottom, -.5},
              {1 + lean * bottom, bottom, .9},
              {1 + lean * top, top, .9},
              {1 + lean * top, top, -.5}});
    // The wall faces the receiver, so it gives light if its top is above the horizon.
    EXPECT_EQ(exact_irradiance(lamp, Vec3d(0.0), {0, 1, 0}) > 0, top > 0);
    return lamp;
  };
  expect_irradiance_of(wall(0, 1, 0), {}, {"6", "wall on the horizon"}, true);
  expect_irradiance_of(wall(-1, 1, 0), {}, {"6", "wall across the horizon"}, true);
  expect_irradiance_of(wall(-1, .05, 0), {}, {"6", "wall that hardly rises"}, true);
  expect_irradiance_of(wall(-.7, 1.2, -.6), {}, {"6", "leaning over, across the horizon"}, true);
  expect_irradiance_of(wall(-.7, 1.2, .8), {}, {"6", "leaning away, across the horizon"}, true);
  // A wall that is entirely below the horizon gives no light.
  expect_irradiance_of(wall(-2, -.1, 0), {}, {"6", "wall below the horizon"}, true);
}

TEST(RectangleLight, NearAndFar) {
  Emitters near, far;
  near.add({{-1, 1e-3, -1}, {1, 1e-3, -1}, {1, 1e-3, 1}, {-1, 1e-3, 1}});
  Receiver close;
  close.half_size = .5;
  close.camera_height = 5e-4;
  expect_irradiance_of(near, close, {"6", "a thousandth of its size away"}, true);
  far.add({{-1, 1e3, -1}, {1, 1e3, -1}, {1, 1e3, 1}, {-1, 1e3, 1}});
  expect_irradiance_of(far, {}, {"6", "a thousand times its size away"}, false);
}

// ---- case 7 ------------------------------------------------------------------------------------

TEST(SphereLight, AboveAndAcrossTheHorizon) {
  EXPECT_NEAR(kPiD * square(.5 / 2) * std::cos(.6), .162054, 1e-6);  // from the catalogue
  struct Sphere {
    double radius, distance, cosine;
    const char* what;
  };
  for (const Sphere& sphere :
       {Sphere{.5, 2, std::cos(.6), "above the horizon"},
        Sphere{.9, 1, 1, "filling most of the sky"}, Sphere{.5, 1, .2, "across the horizon"},
        Sphere{.5, 1, -.3, "mostly below the horizon"}, Sphere{.01, 10, .5, "far away"}}) {
    const auto [radius, distance, cosine, what] = sphere;
    const Vec3d center(distance * std::sqrt(1 - cosine * cosine), distance * cosine, 0);
    Emitters lamp;
    lamp.add_mesh(SceneBuilderForTests::sphere(float(radius), 24, -1), center);
    if (cosine * distance >= radius) {
      const double exact = kPiD * square(radius / distance) * cosine;
      // The faces are inscribed in the sphere and span pi / 24, so the outline encloses up to (pi /
      // 24)^2 / 2 = 9e-3 less area than a circle.
      EXPECT_NEAR(exact_irradiance(lamp, Vec3d(0.0), {0, 1, 0}) / exact, 1, 1e-2) << what;
    }
    Receiver r;
    r.camera_height = .02;
    r.half_size = .05;
    expect_irradiance_of(lamp, r, {"7", std::string("sphere ") + what}, distance < 5);
  }
}

// ---- case 8 ------------------------------------------------------------------------------------

TEST(DiskLight, Coaxial) {
  EXPECT_NEAR(kPiD * square(.7) / (square(.7) + square(1.3)), .706138, 1e-6);  // from the catalogue
  for (const auto& [radius, h] :
       {std::pair{.7, 1.3}, std::pair{10.0, .1}, std::pair{.01, 1.0}, std::pair{1000.0, 1.0}}) {
    Emitters lamp;
    lamp.add_disk(radius, h, 64);
    const double exact = kPiD * square(radius) / (square(radius) + square(h));
    // A regular polygon of n sides has 1 - 2 pi^2 / 3 n^2 of the area of its circumscribed circle.
    EXPECT_NEAR(exact_irradiance(lamp, Vec3d(0.0), {0, 1, 0}) / exact, 1, 2e-3);
    Receiver r;
    r.camera_height = .05;
    expect_irradiance_of(lamp, r,
                         {"8", "radius " + format_value(radius) + ", height " + format_value(h)},
                         radius > .1);
  }
}

// ---- case 9 ------------------------------------------------------------------------------------

// A sun of half-angle a gives E = pi L sin^2 a cos theta. The disc stays above the origin, where
// float has enough digits for a half-angle of 1e-4, and the receiver tilts by theta.
TEST(SunDisc, EveryHalfAngle) {
  for (const double a : {.1, .03, .01, 1e-3, 1e-4})
    for (const double cosine : {1.0, .5, .2}) {
      Emitters sun;
      const int sides = 64;
      sun.add_disk(100 * std::tan(a), 100, sides, 1 / square(std::sin(a)));
      Receiver r;
      r.normal = Vec3d(std::sqrt(1 - cosine * cosine), cosine, 0);
      const double polygon = sides / (2 * kPiD) * std::sin(2 * kPiD / sides);
      // A flat disc differs from a spherical cap by a^2, relatively.
      EXPECT_NEAR(exact_irradiance(sun, Vec3d(0.0), r.normal) / (kPiD * cosine * polygon), 1,
                  a * a + 1e-6);
      expect_irradiance_of(
          sun, r,
          {"9", "sun of half-angle " + format_value(a) + ", cosine " + format_value(cosine)},
          a >= .1);
    }
}

}  // namespace
}  // namespace emberline
