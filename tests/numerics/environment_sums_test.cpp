// Cases 9, 11 and 12: environments whose irradiance is a sum over texels, computed in double. A
// map's radiance is the bilinear interpolation of its texels at u = 0.5 + atan2(z, x) / 2 pi and v
// = acos(y) / pi, where u wraps around and v is clamped. This file implements the interpolation
// again, so that the sum follows the definition and not the renderer.
#include <random>

#include "receiver.h"
#include "support/float_map.h"

namespace emberline {
namespace {

using namespace test;

struct Map {
  int width = 0, height = 0;
  std::vector<float> texels;  // grey

  double texel(int x, int y) const {
    x = ((x % width) + width) % width;
    y = std::clamp(y, 0, height - 1);
    return double(texels[size_t(y) * size_t(width) + size_t(x)]);
  }
  double radiance(double u, double v) const {
    const double x = u * width - 0.5, y = v * height - 0.5;
    const int i = int(std::floor(x)), j = int(std::floor(y));
    const double a = x - i, b = y - j;
    return (1 - b) * ((1 - a) * texel(i, j) + a * texel(i + 1, j)) +
           b * ((1 - a) * texel(i, j + 1) + a * texel(i + 1, j + 1));
  }
  // True if both rows of texels that are interpolated at `v` are black.
  bool is_black_at(double v) const {
    const int j = int(std::floor(v * height - 0.5));
    const auto row = [&](int y) {
      const auto begin = texels.begin() + std::clamp(y, 0, height - 1) * width;
      return std::all_of(begin, begin + width, [](float t) { return t == 0; });
    };
    return row(j) && row(j + 1);
  }
  double towards(const Vec3d& d) const {
    return radiance(0.5 + std::atan2(d.z, d.x) / (2 * kPiD), std::acos(d.y) / kPiD);
  }

  std::shared_ptr<const Image> image() const {
    return float_map(width, height, [&](int x, int y) { return Rgb(float(texel(x, y))); });
  }
};

// E is the sum of L cos sin(theta) dtheta dphi over cells. L is smooth within each half texel,
// which is cut into cuts x cuts pieces of 2 x 2 Gauss points. The remaining error comes from the
// kink at the horizon, where the horizon does not follow the border of a cell. It is (pi / height
// cuts)^2, at most 4e-7 for the maps below.
double exact_irradiance(const Map& map, const Vec3d& n, int cuts) {
  const int columns = 2 * map.width * cuts, rows = 2 * map.height * cuts;
  const double offset = 0.5 / std::sqrt(3.0);
  double sum = 0;
  for (int j = 0; j < 2 * rows; ++j) {
    const double v = (j / 2 + 0.5 + (j % 2 ? offset : -offset)) / rows, theta = kPiD * v;
    const double y = std::cos(theta), r = std::sin(theta);
    if (map.is_black_at(v)) continue;
    for (int i = 0; i < 2 * columns; ++i) {
      const double u = (i / 2 + 0.5 + (i % 2 ? offset : -offset)) / columns;
      const double radiance = map.radiance(u, v);
      if (radiance == 0) continue;
      const double phi = 2 * kPiD * (u - 0.5);
      const double cosine = n.x * r * std::cos(phi) + n.y * y + n.z * r * std::sin(phi);
      sum += radiance * std::max(0.0, cosine) * r;
    }
  }
  return sum * kPiD / rows / 2 * 2 * kPiD / columns / 2;
}

// Only one scattered ray in 30,000 meets a sun of one texel, so fewer samples would miss it.
void expect_environment(const Map& map, const Vec3d& n, double exact, double tolerance,
                        const CaseName& name, bool bsdf_alone) {
  SceneBuilderForTests b;
  Receiver r;
  r.normal = n;
  add_receiver(b, r);
  b.set_environment(map.image());
  const auto scene = b.build();
  RenderSettings s = direct_light_settings(bsdf_alone ? long_or_short(2048u, 512u) : 2048);
  s.seed = seed_of(name);
  expect_case(name, measured_irradiance(render(*scene, view_of(r), s), exact, tolerance),
              replay(s));
  if (!bsdf_alone) return;
  s.light_samples = 0;
  ++s.seed;
  expect_case({name.number, name.what + ", BSDF sampling alone"},
              measured_irradiance(render(*scene, view_of(r), s), exact, tolerance), replay(s));
}

// Case 11: L = a + b cos(theta) over the whole sphere gives E = pi a + 2 pi b / 3 (n . up).
TEST(EnvironmentSums, GradientOnTiltedReceivers) {
  const double a = 1.5, b = 1;
  Map map{8, 256, {}};
  for (int y = 0; y < map.height; ++y)
    map.texels.insert(map.texels.end(), size_t(map.width),
                      float(a + b * std::cos(kPiD * (y + .5) / map.height)));
  // Linear interpolation of rows h apart misses a cosine by at most h^2 / 8.
  const double tolerance = kPiD * b * square(kPiD / map.height) / 8 + 1e-5;
  for (const double tilt : {0.0, .5, kPiD / 2, 2.5, kPiD}) {
    const Vec3d n(std::sin(tilt), std::cos(tilt), 0);
    expect_environment(map, n, kPiD * a + 2 * kPiD * b / 3 * n.y, tolerance,
                       {"11", "gradient sky, receiver tilted by " + format_value(tilt)}, true);
  }
}

Map eight_by_four() {
  Map map{8, 4, {}};
  std::mt19937 random(12);  // the same on every machine
  for (int i = 0; i < 32; ++i) map.texels.push_back(float(random() % 1000) / 100);
  return map;
}

// Case 12: receivers face the poles, the seam (-X), the horizon, and other directions.
TEST(EnvironmentSums, EightByFourTexels) {
  const Map map = eight_by_four();
  const std::pair<Vec3d, const char*> normals[] = {{{0, 1, 0}, "up"},
                                                   {{0, -1, 0}, "down"},
                                                   {{-1, 0, 0}, "to the seam"},
                                                   {{1, 0, 0}, "+X"},
                                                   {{0, 0, 1}, "+Z"},
                                                   {unit({.3, .8, -.5}), "up and aside"},
                                                   {unit({-1, .05, 1e-3}), "just above the seam"},
                                                   {unit({1e-3, -1, 2e-3}), "off the lower pole"}};
  for (const auto& [n, what] : normals) {
    const double exact = exact_irradiance(map, n, 48);
    expect_environment(map, n, exact, 1e-5 * exact, {"12", std::string("8 x 4 map, ") + what},
                       true);
  }
}

// Each map has one bright texel, in one of several rows and columns, which include the seam.
// Interpolation spreads the texel over its neighbours, across the seam, and up to the pole itself.
TEST(EnvironmentSums, LoneTexels) {
  for (const int row : {0, 1, 3})
    for (const int column : {0, 3, 7}) {
      Map map{8, 4, std::vector<float>(32, 0.0f)};
      map.texels[size_t(row * 8 + column)] = 100;
      const Vec3d n = row < 2 ? unit({-.5, 1, .2}) : unit({-.5, -1, .2});
      const double exact = exact_irradiance(map, n, 48);
      expect_environment(
          map, n, exact, 1e-5 * exact,
          {"12", "one texel, row " + format_value(row) + ", column " + format_value(column)},
          false);
    }
}

// The camera sees the map without noise, on both sides of the poles and of the seam.
TEST(EnvironmentSums, SeenByTheCamera) {
  const Map map = eight_by_four();
  SceneBuilderForTests b;
  // A scene needs some geometry. No ray hits this floor.
  b.add_floor(.01f, -10, b.add_material(lambert(Rgb(1.0f))), /*up=*/false);
  b.set_environment(map.image());
  const auto scene = b.build();
  RenderSettings s = direct_light_settings(1);
  s.width = s.height = 2;
  for (const double theta : {1e-3, .4, kPiD / 2, 3.0, kPiD - 1e-3})
    for (const double phi : {-kPiD + 1e-3, kPiD - 1e-3, 0.0, 1.9}) {
      const Vec3d d(std::sin(theta) * std::cos(phi), std::cos(theta),
                    std::sin(theta) * std::sin(phi));
      const RenderedImage image = render(*scene, orthographic({0, 0, 0}, d, 1e-3), s);
      // In a float direction, x and z are exact to 6e-8, so at 1e-3 from the pole the azimuth is
      // exact to 1e-4. A texel is 2 pi / 8 wide, and the contrast between texels is at most 10.
      const double at_pole = std::sin(theta) < 1e-2 ? 1e-4 / (2 * kPiD / 8) * 10 : 0;
      expect_case({"12", "seen at theta " + format_value(theta) + ", phi " + format_value(phi)},
                  {map.towards(d), image.mean, 0, 2e-5 + at_pole}, replay(s));
    }
}

// Case 9 with the sun in an HDRI. The sun covers one or several texels, 30 degrees above the
// horizon, alone or in a sky. E is the sum over the texels. The texels approximate a disc, whose pi
// sin^2 a checks the sum.
TEST(EnvironmentSums, SunInAMap) {
  for (const auto& [a, width] : {std::pair{.05, 512}, std::pair{.01, 1024}, std::pair{0.0, 1024}})
    for (const float sky : {0.0f, 1.0f}) {
      Map map{width, width / 2, std::vector<float>(size_t(width) * size_t(width / 2), sky)};
      const double elevation = kPiD / 6;
      const Vec3d to_sun(std::cos(elevation), std::sin(elevation), 0);
      int texels = 0;
      for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
          const double theta = kPiD * (y + .5) / map.height;
          const double phi = 2 * kPiD * ((x + .5) / map.width - .5);
          const Vec3d d(std::sin(theta) * std::cos(phi), std::cos(theta),
                        std::sin(theta) * std::sin(phi));
          if (a == 0 ? x != map.width / 2 || y != map.height / 3 : angle_between(d, to_sun) > a)
            continue;
          map.texels[size_t(y) * size_t(map.width) + size_t(x)] += 1e6f;
          ++texels;
        }
      EXPECT_GE(texels, a == 0 ? 1 : 9);
      Map sun = map;  // the sky alone gives pi
      for (float& t : sun.texels) t -= sky;
      const double exact = exact_irradiance(sun, {0, 1, 0}, 2) + double(sky) * kPiD;
      const double disc = 1e6 * kPiD * square(std::sin(a)) * std::sin(elevation);
      if (a > .02) {  // smaller outlines of whole texels are too coarse
        EXPECT_NEAR(exact / disc, 1, .05);
      }
      expect_environment(map, {0, 1, 0}, exact, 1e-5 * exact,
                         {"9", "sun of half-angle " + format_value(a) + " in a map, sky " +
                                   format_value(double(sky))},
                         false);
    }
}

}  // namespace
}  // namespace emberline
