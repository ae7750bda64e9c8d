// Cases E6 to E8: exchange between surfaces. Form factors and whole paths are reciprocal, and the
// walls of a closed box absorb exactly the lamp's power.
#include "receiver.h"
#include "renderer/core/moments.h"

namespace emberline {
namespace {

using namespace test;

// Returns the mean irradiance, divided by pi, of a square of half size h in the plane y = 0.
MeasuredMean over_square(const SceneBuilderForTests& b, double h, uint32_t seed) {
  RenderSettings s = direct_light_settings(256);
  s.width = s.height = 16;
  s.seed = seed;
  return mean_of(*b.build(), orthographic({0, .004, 0}, {0, 0, 0}, h), s);
}

// ---- E6 ----------------------------------------------------------------------------------------

// Two squares are parallel and coaxial. The flux from square 1 to square 2 is pi L A1 F12, so area
// times mean irradiance is the same in both directions. For equal squares of side 1 at distance 1,
// the exact value is the formula for opposite rectangles (Howell's catalogue, C-11).
TEST(FormFactors, AreReciprocal) {
  struct Squares {
    double first, second, distance;  // half sizes, and the distance
  };
  for (const auto& [first, second, distance] :
       {Squares{.5, .5, 1}, Squares{.1, .8, .3}, Squares{1, .01, .02}}) {
    const auto flux = [&](double from, double to, uint32_t seed) {
      SceneBuilderForTests b;
      b.add_floor(float(to), 0, b.add_material(lambert(Rgb(1.0f))));
      b.add_floor(float(from), float(distance), b.add_material(emitter(Rgb(1.0f))), /*up=*/false);
      const MeasuredMean m = over_square(b, to, seed);
      const double area = square(2 * to) * kPiD;
      return MeasuredMean{m.mean * area, m.standard_error * area};
    };
    const MeasuredMean there = flux(first, second, 1), back = flux(second, first, 2);
    const std::string what = "squares of " + format_value(2 * first) + " and " +
                             format_value(2 * second) + " at " + format_value(distance);
    // The tolerance of 1e-5 covers float arithmetic.
    expect_case({"E6", what + ", flux 1 to 2 against 2 to 1"},
                {back.mean, there.mean, std::hypot(there.standard_error, back.standard_error),
                 1e-5 * back.mean},
                "seeds 1 and 2, 16 x 16, 256 spp");
    if (first == second && distance == 2 * first) {
      const double r2 = std::sqrt(2.0);  // X = Y = 1
      const double f =
          2 / kPiD * (std::log(std::sqrt(4.0 / 3)) + 2 * r2 * std::atan(1 / r2) - 2 * kPiD / 4);
      EXPECT_NEAR(f, .1998249, 1e-6);
      expect_case({"E6", what + ", flux against Howell's C-11"},
                  {kPiD * f, there.mean, there.standard_error, 1e-5}, "seed 1");
    }
  }
}

// ---- E7 ----------------------------------------------------------------------------------------

// Tests the Helmholtz reciprocity of whole paths with two Lambertian patches of the same size that
// do not face each other. The irradiance of patch 2 when patch 1 emits equals the irradiance of
// patch 1 when patch 2 emits, summed over all orders. Patch 1 faces the wall squarely and patch 2
// sees it at a grazing angle, so a lobe that is not symmetric in its two directions would show. The
// wall is rough enough for BSDF sampling to find the patches.
MeasuredMean received(const MaterialDescription& wall, bool swapped, const CaseName& name) {
  SceneBuilderForTests b;
  MaterialDescription shining = lambert(Rgb(.5f)), plain = lambert(Rgb(.5f));
  shining.emission = Rgb(50.0f);
  const int lamp = b.add_material(shining), detector = b.add_material(plain);
  constexpr double kHalf = .15;
  const Vec3d at[] = {{0, 1, -.5}, {1.8, 1, -.7}};
  const Vec3d facing[] = {{0, 0, -1}, unit({-1, 0, -.3})};
  for (int i = 0; i < 2; ++i) {
    const Vec3d u = unit(cross(Vec3d(0, 1, 0), facing[i])) * kHalf, v = cross(facing[i], u);
    b.add_quad(Vec3f(at[i] - u - v), Vec3f(at[i] + u - v), Vec3f(at[i] + u + v),
               Vec3f(at[i] - u + v), (i == 1) == swapped ? lamp : detector);
  }
  b.add_quad({-2, 0, -1}, {3, 0, -1}, {3, 2, -1}, {-2, 2, -1}, b.add_material(wall));
  b.add_floor(3, 0, b.add_material(metal(Rgb(.9f), .6f)));
  b.set_environment(Rgb(0.0f));
  RenderSettings s;
  s.width = s.height = 16;
  s.spp = long_or_short(1024u, 256u);
  s.max_depth = 8;
  s.seed = seed_of(name) + swapped;
  const int seen = swapped ? 0 : 1;
  const MeasuredMean m =
      mean_of(*b.build(), orthographic(at[seen] + facing[seen] * .004, at[seen], kHalf), s);
  // The detector's radiance is rho / pi times its irradiance.
  return {m.mean * kPiD / .5, m.standard_error * kPiD / .5};
}

TEST(Reciprocity, LampAndDetectorChangePlaces) {
  for (const float metallic : {0.0f, 1.0f})
    for (const float roughness : {.4f, 1.0f}) {
      MaterialDescription wall;
      wall.base_color = Rgb(.7f);
      wall.metallic = metallic;
      wall.roughness = roughness;
      const CaseName name = {"E7", "lamp and detector change places, metallic " +
                                       format_value(double(metallic)) + ", roughness " +
                                       format_value(double(roughness))};
      const MeasuredMean there = received(wall, false, name), back = received(wall, true, name);
      EXPECT_GT(there.mean, 0);
      // The tolerance of 1e-5 covers float arithmetic. The albedo tables scale the diffuse lobe
      // symmetrically in both directions.
      expect_case(name,
                  {back.mean, there.mean, std::hypot(there.standard_error, back.standard_error),
                   1e-5 * back.mean},
                  "seeds " + std::to_string(seed_of(name)) + " and the next, 16 x 16");
    }
}

// ---- E8 ----------------------------------------------------------------------------------------

// A point light shines in a closed box of reflectance rho. The walls absorb 1 - rho of their total
// irradiance. The absorbed power equals the lamp's 4 pi I, wherever the lamp is. It includes all
// bounces and Russian roulette.
TEST(EnergyBalance, WallsAbsorbWhatTheLampSends) {
  for (const double rho : {.3, .8, .95}) {
    SceneBuilderForTests b;
    const int wall = b.add_material(lambert(Rgb(float(rho))));
    const Vec3d axes[] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    for (const Vec3d& out : axes) {
      const Vec3d u = std::abs(out.y) < .5 ? Vec3d(0, 1, 0) : Vec3d(0, 0, 1), v = cross(u, out);
      b.add_quad(Vec3f(out - u - v), Vec3f(out + u - v), Vec3f(out + u + v), Vec3f(out - u + v),
                 wall);  // facing inwards
    }
    b.add_point_light({.3, -.4, .5}, Rgb(2.0f));
    const auto scene = b.build();
    RenderSettings s;
    s.width = s.height = 16;
    s.spp = long_or_short(128u, 32u);
    s.max_depth = 100'000;
    double absorbed = 0, variance = 0;
    for (const Vec3d& out : axes) {
      const double area = 4,
                   per_radiance = area * kPiD / double(float(rho)) * (1 - double(float(rho)));
      const MeasuredMean m = mean_of(*scene, orthographic(out * .01, out, 1), s);
      absorbed += per_radiance * m.mean;
      variance += square(per_radiance * m.standard_error);
      ++s.seed;  // gives the walls independent errors
    }
    const double exact = 4 * kPiD * 2;
    expect_case({"E8", "box of reflectance " + format_value(rho)},
                {exact, absorbed, std::sqrt(variance), 1e-5 * exact}, "seeds 1 to 6, " + replay(s));
  }
}

}  // namespace
}  // namespace emberline
