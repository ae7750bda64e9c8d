// Absorbing slabs at every angle (case 13), limited depth and index-matched interfaces (case 14),
// mirrors (case 25), and glass where its formulas lose all digits.

#include "closed_form.h"
#include "renderer/shading/lobes/transmission_lobe.h"
#include "support/glass_scenes.h"
#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

void add_slab(SceneBuilderForTests& b, int material, float top, float bottom, float size = 1000) {
  b.add_floor(size, top, material, /*up=*/true);
  b.add_floor(size, bottom, material, /*up=*/false);
}

// Looks at `theta` from the vertical, down from above or up from below. The target is off the
// diagonals.
CameraDescription seen_at(double theta, bool above) {
  const Vec3d direction(std::sin(theta), above ? std::cos(theta) : -std::cos(theta), 0.3e-3);
  const Vec3d at(7.3, above ? 0.0 : -0.1, 3.1);
  return orthographic(at + direction * 5.0, at, 1e-3);
}

RenderSettings optics_settings() {
  RenderSettings s;
  s.width = s.height = 8;
  s.spp = 1024;
  s.max_depth = 200;
  return s;
}

// Case 13: a slab reflects R + (1 - R)^2 R a^2 / (1 - R^2 a^2) and transmits (1 - R)^2 a / (1 - R^2
// a^2). R is the reflectance of a face, and a is the transmittance of one crossing. The tolerance
// of 1e-5 covers Fresnel and the exponential in float.
TEST(AbsorbingSlab, AtFourAngles) {
  const double eta = 1.5, d = .1, half_distance = .15;
  MaterialDescription m = glass(float(eta), 0);
  m.attenuation_color = Rgb(0.5f);
  m.attenuation_distance = float(half_distance);
  SceneBuilderForTests b;
  add_slab(b, b.add_material(m), 0, float(-d));
  b.set_environment(upper_half());
  const auto scene = b.build();
  for (const double theta : {0.0, .5, 1.0, 1.3}) {
    const double r = fresnel(theta, eta);
    const double a = std::pow(.5, d / half_distance / std::sqrt(1 - square(std::sin(theta) / eta)));
    const RenderSettings s = optics_settings();
    const std::string at = " at " + std::to_string(theta);
    expect_exact(render(*scene, seen_at(theta, true), s),
                 r + square(1 - r) * r * a * a / (1 - r * r * a * a), 1e-5, s,
                 {"13", "absorbing slab, reflected" + at});
    expect_exact(render(*scene, seen_at(theta, false), s), square(1 - r) * a / (1 - r * r * a * a),
                 1e-5, s, {"13", "absorbing slab, passed" + at});
  }
}

// Case 14 to depth k: in a furnace, a slab returns 1 minus the light that is still inside. A share
// 1 - R enters at the first face, and each further face keeps a share R of it. So (1 - R) R^(k - 1)
// is still inside after k events. Roulette is unbiased and does not matter.
TEST(GlassInAFurnace, ToLimitedDepth) {
  for (const double theta : {.3, 1.2}) {
    SceneBuilderForTests b;
    add_slab(b, b.add_material(glass(1.5f, 0)), 0, -.1f);
    b.set_environment(Rgb(1.0f));
    const auto scene = b.build();
    for (const int k : {1, 2, 3, 6}) {
      RenderSettings s = optics_settings();
      s.max_depth = k;
      const double r = fresnel(theta, 1.5);
      expect_exact(render(*scene, seen_at(theta, true), s), 1 - (1 - r) * std::pow(r, k - 1), 1e-5,
                   s,
                   {"14", "slab in a furnace to depth " + std::to_string(k) + " at " +
                              std::to_string(theta)});
    }
  }
}

// An interface between a solid and air of the same index does nothing. So layers of index 1 around
// a slab do not change its reflection.
TEST(GlassInAFurnace, IndexOneShellIsInvisible) {
  const double theta = .8, r = fresnel(theta, 1.5), exact = 2 * r / (1 + r);
  SceneBuilderForTests b;
  add_slab(b, b.add_material(glass(1.5f, 0)), -.1f, -.2f);
  const int none = b.add_material(glass(1.0f, 0));
  add_slab(b, none, 0, -.05f);
  add_slab(b, none, -.25f, -.3f);
  b.set_environment(upper_half());
  const RenderSettings s = optics_settings();
  expect_exact(render(*b.build(), seen_at(theta, true), s), exact, 1e-5, s,
               {"14", "slab between layers of index 1"});
}

// If a solid contains a solid of the same index, the inner faces neither refract nor reflect.
TEST(NestedGlass, OfTheSameIndexIsInvisible) {
  const double theta = .5, r = fresnel(theta, 1.5), exact = 2 * r / (1 + r);
  SceneBuilderForTests b;
  const int material = b.add_material(glass(1.5f, 0));
  add_slab(b, material, 0, -.3f);
  add_slab(b, material, -.1f, -.2f);
  b.set_environment(upper_half());
  const auto scene = b.build();
  const RenderSettings s = optics_settings();
  expect_exact(render(*scene, seen_at(theta, true), s), exact, 1e-5, s,
               {"14", "slab in a slab of the same index, reflected"});
  expect_exact(render(*scene, seen_at(theta, false), s), 1 - exact, 1e-5, s,
               {"14", "slab in a slab of the same index, passed"});
}

// The layers have the indices 1, a, b, a, 1. Each face reflects by the ratio of its two indices. A
// stack of reflectance r and a face of reflectance r' combine to r + t r' t / (1 - r r'), where t =
// 1 - r (Stokes 1862). All layers are lossless and symmetric.
TEST(NestedGlass, FacesBendByTheRatio) {
  const double theta = .9;
  for (const auto& [outer, inner] : {std::pair{1.33, 1.8}, std::pair{1.8, 1.33}}) {
    const auto within = [&](double n) { return std::asin(std::sin(theta) / n); };
    const double face[4] = {fresnel(theta, outer), fresnel(within(outer), inner / outer),
                            fresnel(within(inner), outer / inner),
                            fresnel(within(outer), 1 / outer)};
    double reflected = 0;
    for (const double r : face) {
      // The stack is lossless, so it has the same reflectance from both sides.
      reflected += square(1 - reflected) * r / (1 - reflected * r);
    }
    SceneBuilderForTests b;
    add_slab(b, b.add_material(glass(float(outer), 0)), 0, -.3f);
    add_slab(b, b.add_material(glass(float(inner), 0)), -.1f, -.2f);
    b.set_environment(upper_half());
    const auto scene = b.build();
    const RenderSettings s = optics_settings();
    const std::string what = inner > outer ? ", dense in thin" : ", thin in dense";
    expect_exact(render(*scene, seen_at(theta, true), s), reflected, 1e-5, s,
                 {"14", "slab in a slab, reflected" + what});
    expect_exact(render(*scene, seen_at(theta, false), s), 1 - reflected, 1e-5, s,
                 {"14", "slab in a slab, passed" + what});
  }
}

// The outer solid absorbs before and after the inner one, along .2 of a path of .3. The slabs are
// only 20 wide. On a floor of 1000, rounding by 6e-5 would change a path of .1 by 1e-3 of the
// light.
TEST(NestedGlass, TheOuterAbsorbsBeforeAndAfter) {
  MaterialDescription tinted = glass(1.0f, 0);
  tinted.attenuation_color = Rgb(.5f);
  tinted.attenuation_distance = .1f;
  SceneBuilderForTests b;
  add_slab(b, b.add_material(tinted), 0, -.3f, 10);
  add_slab(b, b.add_material(glass(1.0f, 0)), -.1f, -.2f, 10);
  b.set_environment(upper_half());
  const RenderSettings s = optics_settings();
  expect_exact(render(*b.build(), seen_at(.4, false), s), std::pow(.5, 2 / std::cos(.4)), 1e-5, s,
               {"26", "absorbing slab around a clear one"});
}

// The indices are close to that of air. The lobe changes its formula at a difference of 1e-3. At
// normal incidence R is below (1e-3 / 2)^2 = 2.5e-7, so transmission is 1 to 1e-6.
TEST(Glass, IndexNextToOne) {
  for (const float difference : {1e-6f, 1e-4f, .9e-3f, 1.1e-3f}) {
    SceneBuilderForTests b;
    add_slab(b, b.add_material(glass(1 + difference, 0)), 0, -.1f);
    b.set_environment(upper_half());
    const RenderSettings s = optics_settings();
    expect_exact(render(*b.build(), seen_at(.3, false), s), 1.0, 1e-6, s,
                 {"E22", "index 1 + " + std::to_string(1e6 * double(difference)) + "e-6"});
  }
}

// The camera looks up from inside a slab. It sees n^2 (1 - R) of the sky through the upper face,
// and more after every two reflections, n^2 / (1 + R) in sum. Beyond the critical angle it sees no
// sky. At the critical angle the result is finite.
TEST(Glass, CriticalAngle) {
  const double eta = 1.5, critical = std::asin(1 / eta);
  SceneBuilderForTests b;
  add_slab(b, b.add_material(glass(float(eta), 0)), 1, -1);
  b.set_environment(upper_half());
  const auto scene = b.build();
  for (const double off : {-.2, -1e-2, 1e-3, .1}) {
    const double theta = critical + off;
    RenderSettings s = optics_settings();
    s.spp = long_or_short(256u, 64u);  // beyond the angle every path goes to the end
    s.max_depth = 100;
    const Vec3d up(std::sin(theta), std::cos(theta), 0);
    const RenderedImage image =
        render(*scene, orthographic(Vec3d(7.3, -.5, 3.1), Vec3d(7.3, -.5, 3.1) + up, 1e-4), s);
    double exact = 0;
    if (off < 0) {
      // Fresnel from the outside, at the refracted angle.
      exact = eta * eta / (1 + fresnel(std::asin(eta * std::sin(theta)), eta));
    }
    // Radiance varies with the angle. The tolerance of 1e-4 is the rounding of a float direction
    // times the slope there.
    expect_case({"E23", "from inside, critical angle " + std::to_string(off)},
                {exact, image.mean, image.standard_error, 1e-4}, replay(s));
    EXPECT_EQ(image.counters.non_finite_samples, 0u);
  }
  // At the critical angle, and several floats on either side of it, the weights are finite.
  const auto cosine = float(std::cos(critical));
  float c = cosine;
  for (int i = 0; i < 8; ++i) c = std::nextafter(c, 0.0f);
  double wrong = 0;
  for (int i = 0; i < 17; ++i, c = std::nextafter(c, 1.0f)) {
    const TransmissionLobe lobe({.ior = float(eta), .thin_walled = false, .inside = true},
                                Vec3f(std::sqrt(1 - c * c), 0, c));
    for (const float u : {0.0f, .3f, .7f, .999999f}) {
      const BsdfSample sample = lobe.sample(u, {.5f, .5f});
      if (!sample.valid) continue;  // refraction along the surface itself
      wrong +=
          !is_finite(sample.weight) || !is_finite(sample.wi) || max_component(sample.weight) > 2.3f;
    }
  }
  expect_case({"E23", "samples at the critical angle that are not finite or too bright"},
              {0, wrong, 0, 0}, "17 floats around cos of the angle");
}

// Case 25: after k bounces between two mirrors of reflectance r, the sky of radiance 1 appears as
// r^k. The mirrors are 1 apart and the ray climbs by kStep per crossing, so that the whole frame
// leaves after exactly k bounces. At this angle, Schlick's formula adds kStep^10 / 32.
RenderedImage between_mirrors(float r, int k, const RenderSettings& s) {
  constexpr double kStep = .01;
  SceneBuilderForTests b;
  const int mirror = b.add_material(metal(Rgb(r), 0.0f));
  // The mirrors extend from half a step below the first bounce to half a step above the k-th.
  const auto height = float((k - .5) * kStep), low = float(-.5 * kStep);
  b.add_quad({1, low, -5}, {1, low, 5}, {1, height, 5}, {1, height, -5}, mirror);
  b.add_quad({0, low, 5}, {0, low, -5}, {0, height, -5}, {0, height, 5}, mirror);
  b.set_environment(Rgb(1.0f));
  // The ray comes from below the left mirror. Its first bounce is at x = 1, y = 0.
  return render(*b.build(), orthographic({-1, -2 * kStep, .1}, {1, 0, .1}, 1e-4), s);
}

TEST(Mirrors, ManyBounces) {
  for (const auto& [r, k] : {std::pair{.5f, 2}, std::pair{.9f, 20}, std::pair{.999f, 1000}}) {
    RenderSettings s = optics_settings();
    // Roulette makes a sample 0 or 1, so that many samples are needed. A thousand bounces are slow.
    s.spp = k < 100 ? 4096 : long_or_short(256, 64);
    s.max_depth = 2000;
    // The tolerance is k 2^-23, since r is rounded to float, and the throughput is rounded k times.
    expect_exact(between_mirrors(r, k, s), std::pow(double(r), k), k * 0x1p-23, s,
                 {"25", std::to_string(k) + " bounces between mirrors"});
    s.spp = 16;
    s.max_depth = k - 1;
    expect_exact(between_mirrors(r, k, s), 0.0, 0, s,
                 {"25", std::to_string(k) + " bounces, one fewer allowed"});
  }
  EXPECT_NEAR(std::pow(.999, 1000), std::exp(-1.0005), 1e-6);
}

}  // namespace
}  // namespace emberline
