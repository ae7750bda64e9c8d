#include "renderer/shading/shading_normal.h"

#include <gtest/gtest.h>

#include "renderer/core/constants.h"
#include "renderer/core/warps.h"
#include "support/chi_square.h"

namespace emberline {
namespace {

using test::TestRandom;

Vec3f random_direction(TestRandom& random) { return square_to_sphere(random.vec2()); }

TEST(MappedNormal, FlatMapIsTheNormal) {
  for (uint64_t i = 0; i < 1000; ++i) {
    TestRandom random(1, i);
    const Vec3f n = random_direction(random);
    const ShadingFrame frame = ShadingFrame::from_normal(n);
    const Vec4f t(frame.tangent.x, frame.tangent.y, frame.tangent.z, 1);
    const Vec3f got = mapped_normal(n * 3.0f, t, Vec3f(0, 0, 1));
    EXPECT_NEAR((got - n).length(), 0, 1e-6);
  }
}

TEST(MappedNormal, FollowsHandedness) {
  const Vec3f n(0, 0, 1);
  const Vec3f m = normalize(Vec3f(.3f, .5f, 1));
  const auto near = [](const Vec3f& a, const Vec3f& b) { return (a - b).length() < 1e-6f; };
  EXPECT_TRUE(near(mapped_normal(n, {1, 0, 0, 1}, m), m));
  EXPECT_TRUE(near(mapped_normal(n, {1, 0, 0, -1}, m), Vec3f(m.x, -m.y, m.z)));
}

// A mirroring instance shows the mirror image. Mapping a normal and then mirroring it equals
// mirroring the attributes and then mapping. The mirror is in X: positions and tangents become (-x,
// y, z), and so do normals, by the inverse transpose.
TEST(MappedNormal, MirroredInstanceIsTheMirrorImage) {
  const auto mirror = [](const Vec3f& v) { return Vec3f(-v.x, v.y, v.z); };
  for (uint64_t i = 0; i < 1000; ++i) {
    TestRandom random(2, i);
    const Vec3f n = random_direction(random);
    const Vec3f t =
        ShadingFrame::from_normal(n).to_world(normalize(Vec3f(random.next() + .1f, 1, 0)));
    const float w = random.next() < .5f ? 1.0f : -1.0f;
    const Vec3f m = normalize(Vec3f(random.next() - .5f, random.next() - .5f, .7f));
    const Vec3f want = mirror(mapped_normal(n, {t.x, t.y, t.z, w}, m));
    const Vec3f mt = mirror(t);
    const Vec3f got = mapped_normal(mirror(n), {mt.x, mt.y, mt.z, -w}, m);
    ASSERT_NEAR((got - want).length(), 0, 1e-5) << "TestRandom(2, " << i << ")";
  }
}

TEST(MappedNormal, SurvivesUnusableTangents) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Vec3f n(0, .6f, .8f), m = normalize(Vec3f(.3f, .2f, 1));
  for (const Vec4f& t : {Vec4f(0, 0, 0, 1), Vec4f(0, .6f, .8f, 1), Vec4f(nan, 0, 0, 1),
                         Vec4f(0, -.6f, -.8f, -1), Vec4f(1e-30f, 0, 0, 1)}) {
    const Vec3f got = mapped_normal(n, t, m);
    ASSERT_TRUE(is_finite(got));
    EXPECT_NEAR(dot(got, n), m.z, 1e-5);  // the map fixes the angle, not the direction
  }
}

TEST(SurfaceFrame, PropertiesHoldForAnyNormals) {
  int tilted = 0;
  for (uint64_t i = 0; i < 200000; ++i) {
    TestRandom random(3, i);
    const Vec3f face = random_direction(random), wo_any = random_direction(random);
    // The direction is often grazing.
    const float grazing = random.next() < .5f ? 1.0f : std::pow(10.0f, -7 * random.next());
    const Vec3f wo = normalize(wo_any + face * ((grazing - 1) * dot(face, wo_any)));
    const Vec3f vertex = normalize(face + random_direction(random) * random.next());
    const float lean = random.next() < .3f ? 0 : random.next() * 2;
    const Vec3f shading = vertex + random_direction(random) * lean;
    const SurfaceFrame f = make_surface_frame(face, vertex, shading, wo);
    const std::string replay = "TestRandom(3, " + std::to_string(i) + ")";

    const float cos_g = dot(f.geometric_normal, wo);
    ASSERT_TRUE(cos_g < 1e-6f || f.back_facing == (dot(face, wo) < 0)) << replay;
    ASSERT_GE(cos_g, -1e-7f) << replay;  // rounding of this dot product
    const Vec3f n = f.shading.normal;
    ASSERT_NEAR(dot(n, n), 1, 1e-5) << replay;
    ASSERT_NEAR(dot(cross(f.shading.tangent, f.shading.bitangent), n), 1, 1e-5) << replay;
    ASSERT_GT(dot(n, wo), -1e-7f) << replay;
    const Vec3f reflected = n * (2 * dot(n, wo)) - wo;
    const float floor = std::min(.9f * cos_g, .01f);
    ASSERT_GE(dot(reflected, f.geometric_normal), floor - 6e-7f) << replay;

    // A valid normal is unchanged. An invalid normal moves no farther than needed.
    const Vec3f wanted = normalize(f.back_facing ? -shading : shading);
    if ((n - wanted).length() > 1e-5f && dot(vertex, face) > 0) {
      ++tilted;
      ASSERT_NEAR(dot(reflected, f.geometric_normal), floor, 1e-5f) << replay;
      ASSERT_NEAR(dot(n, cross(f.geometric_normal, wanted)), 0, 1e-4f) << replay;  // in their plane
    }
  }
  EXPECT_GT(tilted, 1000);
}

TEST(SurfaceFrame, TurnsNormalsThatDisagreeWithTheWinding) {
  const Vec3f up(0, 0, 1), wo = normalize(Vec3f(.2f, .1f, 1));
  const Vec3f n = normalize(Vec3f(.1f, 0, 1));
  for (const float sign : {1.0f, -1.0f}) {
    const SurfaceFrame front = make_surface_frame(up, n * sign, n * sign, wo);
    EXPECT_NEAR((front.shading.normal - n).length(), 0, 1e-6);
    EXPECT_FALSE(front.back_facing);
    const SurfaceFrame back = make_surface_frame(-up, n * sign, n * sign, wo);
    EXPECT_NEAR((back.shading.normal - n).length(), 0, 1e-6);
    EXPECT_TRUE(back.back_facing);
    EXPECT_EQ(back.geometric_normal, up);
  }
}

TEST(SurfaceFrame, FallsBackToTheFace) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Vec3f up(0, 0, 1), wo = normalize(Vec3f(.2f, .1f, 1));
  for (const Vec3f& bad : {Vec3f(0), Vec3f(nan), Vec3f(1e-35f, 0, 0), Vec3f(INFINITY, 0, 0)})
    EXPECT_EQ(make_surface_frame(up, bad, bad, wo).shading.normal, up);
  // A wo in the plane of the face is valid, too.
  const SurfaceFrame edge =
      make_surface_frame(up, Vec3f(1, 0, .1f), Vec3f(1, 0, .1f), Vec3f(0, 1, 0));
  EXPECT_TRUE(is_finite(edge.shading.normal));
}

TEST(Terminator, IsGgxMaskingAndNeutralWithoutABend) {
  EXPECT_EQ(terminator_alpha2(1), 0);
  EXPECT_EQ(terminator_alpha2(0), 1);
  EXPECT_EQ(terminator_factor(.3f, 0), 1);
  EXPECT_EQ(terminator_factor(0, .5f), 0);
  EXPECT_EQ(terminator_factor(-.1f, .5f), 0);
  EXPECT_EQ(terminator_factor(1, .5f), 1);
  // If tan(delta) = 1, alpha^2 is 1/8, and at 45 degrees the factor is 2 / (1 + sqrt(1 + 1/8)).
  const float alpha2 = terminator_alpha2(std::sqrt(.5f));
  EXPECT_NEAR(alpha2, .125f, 1e-6);
  EXPECT_NEAR(terminator_factor(std::sqrt(.5f), alpha2), 2 / (1 + std::sqrt(1.125)), 1e-6);
  float last = 0;
  for (float c = 1e-20f; c <= 1; c = c * 1.5f + 1e-20f) {
    const float factor = terminator_factor(c, alpha2);
    EXPECT_TRUE(factor >= last && factor <= 1) << c;
    last = factor;
  }
}

}  // namespace
}  // namespace emberline
