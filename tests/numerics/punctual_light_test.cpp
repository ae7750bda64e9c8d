// Case 10: lights without extent. Only the position within a pixel is random.
#include "receiver.h"
#include "renderer/core/moments.h"
#include "renderer/description/framing.h"

namespace emberline {
namespace {

using namespace test;

RenderedImage lit(const PunctualLightDescription& light, const Receiver& r,
                  const RenderSettings& s) {
  SceneBuilderForTests b;
  add_receiver(b, r);
  b.description.lights.push_back(light);
  return render(*b.build(), view_of(r), s);
}

// Returns a light at `position` whose axis (-Z of its matrix) points along `axis`.
PunctualLightDescription lamp(PunctualType type, const Vec3d& position, const Vec3d& axis,
                              float intensity) {
  PunctualLightDescription light;
  light.type = type;
  light.intensity = Rgb(intensity);
  light.to_world = look_at_matrix(position, position + axis);
  return light;
}

// E is I cos / d^2. The view extends 1e-6 d to either side, over which E changes by 3e-6 of its
// value. Float rounds the heights of the light (cos d) and of the receiver by 6e-8 d each.
TEST(PunctualLight, PointFromNearAndFar) {
  for (const double d : {.01, 1.0, 1e3, 1e6})
    for (const double cosine : {1.0, .3, .01}) {
      Receiver r;
      r.half_size = .2 * d;
      r.camera_height = .001 * d;
      r.view_half_size = 1e-6 * d;
      const Vec3d at(d * std::sqrt(1 - cosine * cosine), d * cosine, 0);
      const RenderSettings s = direct_light_settings(16);
      const double exact = 3 * cosine;
      expect_case({"10", "point at " + format_value(d) + ", cosine " + format_value(cosine)},
                  measured_irradiance(
                      lit(lamp(PunctualType::kPoint, at, {0, -1, 0.1}, float(3 * d * d)), r, s),
                      exact, exact * (1e-5 + 1.2e-7 / cosine)),
                  replay(s));
    }
}

// The light falls off with the inverse square within its range, and gives nothing beyond.
TEST(PunctualLight, Range) {
  for (const double d : {.01, 1.0, 1e6})
    for (const double share : {.999, 1.001}) {
      Receiver r;
      r.half_size = .2 * d;
      r.camera_height = .001 * d;
      r.view_half_size = 1e-6 * d;
      const RenderSettings s = direct_light_settings(16);
      PunctualLightDescription light =
          lamp(PunctualType::kPoint, {0, d, 0}, {0, -1, 0.1}, float(3 * d * d));
      light.range = float(d / share);
      const double exact = share < 1 ? 3 : 0;
      expect_case({"10", "point at " + format_value(share) + " of its range, " + format_value(d)},
                  measured_irradiance(lit(light, r, s), exact, exact * 1.1e-5), replay(s));
    }
}

// The flux through a closed box is the sum over its six walls of area times mean irradiance. It is
// 4 pi I wherever the light is. The standard error comes from the spread over seeds, since the
// pixels of a wall have different expected values.
TEST(PunctualLight, FluxThroughAClosedBox) {
  constexpr double kIntensity = 2;
  for (const Vec3d& at : {Vec3d(0, 0, 0), Vec3d(.3, -.4, .5), Vec3d(.9, .9, .9)}) {
    SceneBuilderForTests b;
    const int wall = b.add_material(lambert(Rgb(1.0f)));
    const Vec3d axes[] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    for (const Vec3d& out : axes) {
      const Vec3d u = std::abs(out.y) < .5 ? Vec3d(0, 1, 0) : Vec3d(0, 0, 1), v = cross(u, out);
      b.add_quad(Vec3f(out - u - v), Vec3f(out + u - v), Vec3f(out + u + v), Vec3f(out - u + v),
                 wall);  // facing inwards
    }
    b.add_point_light(at, Rgb(float(kIntensity)));
    const auto scene = b.build();
    RenderSettings s = direct_light_settings(16);
    Moments flux;
    for (s.seed = 1; s.seed <= 64; ++s.seed) {
      double sum = 0;
      for (const Vec3d& out : axes) {
        const RenderedImage image = render(*scene, orthographic(out * 0.01, out, 1), s);
        sum += 4 * kPiD * image.mean;
      }
      flux.add(sum);
    }
    const double exact = 4 * kPiD * kIntensity;
    // The tolerance of 1e-5 covers float arithmetic.
    expect_case({"10", "flux through a box, light at " + format_value(at.x) + ", " +
                           format_value(at.y) + ", " + format_value(at.z)},
                {exact, flux.mean(), flux.standard_error(), 1e-5 * exact},
                "seeds 1 to 64, " + replay(s));
  }
}

// KHR_lights_punctual defines the intensity as I saturate((cos - cos_outer) / max(.001, cos_inner -
// cos_outer))^2.
TEST(PunctualLight, SpotProfile) {
  PunctualLightDescription light = lamp(PunctualType::kSpot, {0, 2, 0}, {0, -1, 0}, 5);
  light.inner_cone = .3f;
  light.outer_cone = .7f;
  const double inner = std::cos(double(light.inner_cone)),
               outer = std::cos(double(light.outer_cone));
  for (const double angle : {0.0, .2, .29, .31, .5, .69, .71, 1.2}) {
    Receiver r;
    r.point = Vec3d(2 * std::tan(angle), 0, 0);
    r.camera_height = .05;
    const double cosine = std::cos(angle);
    const double falloff = square(std::clamp((cosine - outer) / (inner - outer), 0.0, 1.0));
    const double exact = 5 * falloff * cosine * square(cosine / 2);
    const RenderSettings s = direct_light_settings(16);
    // The tolerance is 1e-4 of the light's own E. Near the outer edge, the falloff doubles the
    // rounding of the cosine over the cone's narrow range.
    expect_case({"10", "spot at " + format_value(angle) + " of .3 to .7"},
                measured_irradiance(lit(light, r, s), exact, 1e-4 * exact + 1e-6), replay(s));
  }
}

// The total flux of a spotlight is 2 pi I [(1 - cos_inner) + (cos_inner - cos_outer) / 3]. The
// third comes from the integral of the squared ramp.
TEST(PunctualLight, SpotFlux) {
  // Half the floor's size. The spot's circle has a radius of 2 tan .7 = 1.68.
  constexpr double kHalfSize = 2;
  SceneBuilderForTests b;
  b.add_floor(float(kHalfSize), 0, b.add_material(lambert(Rgb(1.0f))));
  PunctualLightDescription light = lamp(PunctualType::kSpot, {0, 2, 0}, {0, -1, 0}, 5);
  light.inner_cone = .3f;
  light.outer_cone = .7f;
  b.description.lights.push_back(light);
  const auto scene = b.build();
  RenderSettings s = direct_light_settings(64);
  s.width = s.height = 16;
  Moments flux;
  for (s.seed = 1; s.seed <= 64; ++s.seed)
    flux.add(square(2 * kHalfSize) * kPiD *
             render(*scene, orthographic({0, 1, 0}, {0, 0, 0}, kHalfSize), s).mean);
  const double inner = std::cos(double(light.inner_cone)),
               outer = std::cos(double(light.outer_cone));
  const double exact = 2 * kPiD * 5 * (1 - inner + (inner - outer) / 3);
  expect_case({"10", "flux of a spot"}, {exact, flux.mean(), flux.standard_error(), 1e-5 * exact},
              "seeds 1 to 64, " + replay(s));
}

// A directional light gives its lux times the cosine, and nothing from below.
TEST(PunctualLight, Directional) {
  for (const double cosine : {1.0, .5, .01, -.5}) {
    const Vec3d axis(std::sqrt(1 - cosine * cosine), -cosine, 0);
    const Receiver r;
    const RenderSettings s = direct_light_settings(16);
    const double exact = 7 * std::max(0.0, cosine);
    // Rounding the direction to float changes it by 6e-8, and so a cosine of .01 by 6e-6 of its
    // value.
    expect_case({"10", "directional, cosine " + format_value(cosine)},
                measured_irradiance(lit(lamp(PunctualType::kDirectional, {3, 4, 5}, axis, 7), r, s),
                                    exact, 1e-5 * exact),
                replay(s));
  }
}

}  // namespace
}  // namespace emberline
