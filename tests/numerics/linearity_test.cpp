// Cases E3 to E5: light is additive. Lamps together give the sum of what each gives alone, an
// emitter gives the same light whole or in pieces, and no magnitude of radiance is special.
#include <random>

#include "receiver.h"

namespace emberline {
namespace {

using namespace test;

// Returns a room with two lamps, a point light and a sky, which `lamps`, `point` and `sky` switch
// on. Light bounces between a glossy floor, a wall and a ball.
std::unique_ptr<Scene> room(bool lamps, bool point, bool sky, float scale = 1) {
  SceneBuilderForTests b;
  b.add_floor(3, 0, b.add_material(metal(Rgb(.8f), .5f)));
  MaterialDescription coated;  // a dielectric layer
  coated.base_color = Rgb(.6f);
  coated.metallic = 0;
  coated.roughness = .4f;
  b.add_quad({-3, 0, -3}, {3, 0, -3}, {3, 4, -3}, {-3, 4, -3}, b.add_material(coated));
  b.place(b.add_mesh(SceneBuilderForTests::sphere(.6f, 8, b.add_material(lambert(Rgb(.7f))))),
          translation(.4, .6, -.8));
  const auto lamp = [&](float radiance) {
    MaterialDescription m = lambert(Rgb(.5f));
    m.emission = Rgb(lamps ? radiance * scale : 0);
    m.double_sided = true;
    return b.add_material(m);
  };
  b.add_floor(.5f, 3, lamp(6), /*up=*/false);
  b.add_quad({-2, .2f, -1}, {-1.6f, .2f, 0}, {-1.6f, 1, 0}, {-2, 1, -1}, lamp(3));
  if (point) b.add_point_light({1.5, 2, 1}, Rgb(4 * scale));
  b.set_environment(Rgb(sky ? .5f * scale : 0));
  return b.build();
}

CameraDescription room_view() { return perspective({.5, 1.8, 4}, {0, .8, -1}, 45); }

RenderSettings room_settings(uint32_t seed) {
  RenderSettings s;
  s.width = s.height = 32;
  s.spp = 256;
  s.seed = seed;
  s.max_depth = 8;
  return s;
}

TEST(Linearity, LightsAddUp) {
  const MeasuredMean all = mean_of(*room(true, true, true), room_view(), room_settings(1));
  const MeasuredMean lamps = mean_of(*room(true, false, false), room_view(), room_settings(2));
  const MeasuredMean point = mean_of(*room(false, true, false), room_view(), room_settings(3));
  const MeasuredMean sky = mean_of(*room(false, false, true), room_view(), room_settings(4));
  const double sum = lamps.mean + point.mean + sky.mean;
  const double error = std::sqrt(square(all.standard_error) + square(lamps.standard_error) +
                                 square(point.standard_error) + square(sky.standard_error));
  EXPECT_GT(std::min({lamps.mean, point.mean, sky.mean}), .02 * sum);
  // The tolerance is 1e-6, since the film's channels are float.
  expect_case({"E3", "all lights against the sum of each alone"},
              {sum, all.mean, error, 1e-6 * sum}, "seeds 1 to 4, " + replay(room_settings(1)));
}

// Scaling the light by a power of two scales the picture exactly, since no constant of the renderer
// has the unit of radiance.
TEST(Linearity, PowersOfTwoAreExact) {
  RenderSettings s = room_settings(5);
  s.spp = 16;
  const RenderedImage one = render(*room(true, true, true), room_view(), s);
  for (const int exponent : {-60, -10, 1, 60}) {
    const RenderedImage other =
        render(*room(true, true, true, std::ldexp(1.0f, exponent)), room_view(), s);
    double worst = 0;
    for (size_t i = 0; i < one.values.size(); i += one.channels.size())
      for (size_t c = 0; c < 3; ++c) {
        const double expected = std::ldexp(double(one.values[i + c]), exponent);
        worst = std::max(worst, std::abs(double(other.values[i + c]) / expected - 1));
      }
    expect_case({"E5", "worst pixel when all light is times 2^" + std::to_string(exponent)},
                {0, worst, 0, 0}, replay(s));
  }
}

// The receiver is lit by two lamps of very different radiances, up to the ends of float's range.
TEST(Linearity, ExtremeRadiance) {
  for (const double bright : {1e30, 1.0})
    for (const double dim : {1e-30, 1.0}) {
      Emitters lamps;
      lamps.add({{-1, 1, 0}, {-.5, 1, 0}, {-.5, 1, .5}, {-1, 1, .5}}, double(float(bright)));
      lamps.add({{.5, 1, 0}, {1.5, 1, 0}, {1.5, 1, .5}, {.5, 1, .5}}, double(float(dim * .5)));
      expect_irradiance_of(
          lamps, {}, {"E5", "lamps of " + format_value(bright) + " and " + format_value(dim * .5)},
          true);
    }
  Emitters dim;
  dim.add({{-1, 1, 0}, {-.5, 1, 0}, {-.5, 1, .5}, {-1, 1, .5}}, double(1e-30f));
  expect_irradiance_of(dim, {}, {"E5", "a lamp of 1e-30 alone"}, true);
}

// ---- E4: pieces --------------------------------------------------------------------------------

// Cuts a quad into an uneven grid of n x n quads. The inner nodes move within the quad's plane, by
// too little to fold a triangle.
Emitters cut(const Vec3d& a, const Vec3d& u, const Vec3d& v, int n) {
  std::mt19937 random(4);
  const auto jitter = [&] { return double(random() % 1000) / 1000 * .4 - .2; };
  std::vector<Vec3d> nodes;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const double x = (i + (i > 0 && i < n ? jitter() : 0)) / n;
      const double y = (j + (j > 0 && j < n ? jitter() : 0)) / n;
      nodes.push_back(a + u * x + v * y);
    }
  Emitters pieces;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const size_t k = size_t(j * (n + 1) + i), up = size_t(n + 1);
      pieces.add({nodes[k], nodes[k + 1], nodes[k + up + 1]});
      pieces.add({nodes[k], nodes[k + up + 1], nodes[k + up]});
    }
  return pieces;
}

// The same emitter consists of 2 triangles, which do not use the light tree, or of 1058 uneven
// triangles, which do. One quad is entirely above the receiver's horizon, the other crosses it.
TEST(Linearity, PiecesGiveTheWhole) {
  const std::tuple<Vec3d, Vec3d, Vec3d, const char*> quads[] = {
      {{-.5, 1.2, -.3}, {1.4, 0, 0}, {0, 0, 1}, "overhead"},
      {{1, -.4, -.5}, {0, 0, 1.4}, {-.6, 1.6, 0}, "across the horizon"}};
  for (const auto& [a, u, v, what] : quads) {
    Emitters whole;
    whole.add({a, a + u, a + u + v, a + v});
    const Emitters pieces = cut(a, u, v, 23);
    const double exact = exact_irradiance(whole, Vec3d(0.0), {0, 1, 0});
    EXPECT_GT(exact, .1);
    EXPECT_NEAR(exact_irradiance(pieces, Vec3d(0.0), {0, 1, 0}), exact, 1e-6 * exact);
    expect_irradiance_of(whole, {}, {"E4", std::string("quad ") + what}, true);
    expect_irradiance_of(pieces, {}, {"E4", std::string("1058 pieces ") + what}, true);
    Emitters halves;
    halves.add({a, a + u * .3, a + u * .3 + v, a + v});
    halves.add({a + u * .3, a + u, a + u + v, a + u * .3 + v});
    expect_irradiance_of(halves, {}, {"E4", std::string("two halves ") + what}, true);
  }
}

}  // namespace
}  // namespace emberline
