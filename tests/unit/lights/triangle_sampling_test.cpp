// Tests triangle sampling by solid angle: its pdf, inverse, closed forms and degenerate shapes.
#include "renderer/lights/triangle_sampling.h"

#include <gtest/gtest.h>

#include "support/chi_square.h"
#include "support/closed_forms.h"

namespace emberline {
namespace {

using test::ChiSquarePoint;
using test::ChiSquareSettings;
using test::TestRandom;

struct Case {
  const char* name;
  Vec3f p0, p1, p2, point;
  bool spherical;
};

// The shapes are on both sides of the lower and of the upper limit of spherical sampling.
const Case kCases[] = {
    {"ordinary", {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2f, 0.3f, 0.8f}, true},
    {"from behind", {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2f, 0.3f, -0.8f}, true},
    {"octant", {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}, true},
    {"beside its plane", {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {3, 2, 0.05f}, true},
    {"sliver", {0, 0, 0}, {1, 0, 0}, {0.5f, 0.004f, 0}, {0.3f, 0.1f, 0.5f}, true},
    {"obtuse", {0, 0, 0}, {4, 0.1f, 0}, {-4, 0.1f, 0}, {0.1f, 0.5f, 0.7f}, true},
    {"almost a hemisphere", {-50, -50, 0}, {50, -50, 0}, {0, 70, 0}, {0, 0, 0.6f}, true},
    {"a thousandth above it", {-50, -50, 0}, {50, -50, 0}, {0, 70, 0}, {0, 0, 0.1f}, true},
    {"close to its edge", {-50, -50, 0}, {50, -50, 0}, {0, 70, 0}, {0.1f, -49.5f, 1.0f}, true},
    {"on it all but", {-50, -50, 0}, {50, -50, 0}, {0, 70, 0}, {0, 0, 2e-4f}, false},
    {"just large enough", {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3f, 0.3f, 39.0f}, true},
    {"just too small", {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3f, 0.3f, 43.0f}, false},
    {"small and tilted", {0, 0, 0}, {1, 0, 0.5f}, {0, 1, 2}, {30, 60, 20}, false},
    {"micrometre", {1e-6f, 0, 0}, {0, 1e-6f, 0}, {0, 0, 1e-6f}, {3e-7f, 1e-7f, 2e-8f}, true},
    {"megametre", {1e6f, 0, 0}, {0, 1e6f, 0}, {0, 0, 1e6f}, {3e5f, 1e5f, 2e4f}, true},
};

ProjectedTriangle project(const Case& c) { return project_triangle(c.p0, c.p1, c.p2, c.point); }

TriangleSample sample_one(const Case& c, const Vec2f& u, float scale = 1.0f) {
  TriangleBatch batch;
  batch.add({c.p0 * scale, c.p1 * scale, c.p2 * scale}, c.point * scale, u);
  batch.sample();
  return batch[0];
}

// The inverse of the spherical map. The first coordinate is the share of the solid angle beyond the
// arc from b through w, and the second is the position of w along this arc.
Vec2f to_square(const ProjectedTriangle& t, const Vec3d& w) {
  Vec3d end = test::unit(cross(cross(t.b, w), cross(t.c, t.a)));
  if (dot(end, t.a + t.c) < 0) end = -end;
  const double part = 2 * std::atan2(std::abs(dot(t.a, cross(t.b, end))),
                                     1 + dot(t.a, t.b) + dot(t.a, end) + dot(t.b, end));
  const Vec3d to_w = w - t.b, to_end = end - t.b;
  return {float(part / t.solid_angle), float(dot(to_w, to_w) / dot(to_end, to_end))};
}

// The pdf in barycentrics (b1, b2), computed from the pdf per solid angle.
double density_in_barycentrics(const Case& c, double b1, double b2) {
  if (b1 + b2 > 1) return 0;
  const Vec3d e1 = Vec3d(c.p1) - Vec3d(c.p0), e2 = Vec3d(c.p2) - Vec3d(c.p0);
  const Vec3d n = cross(e1, e2), d = Vec3d(c.p0) + e1 * b1 + e2 * b2 - Vec3d(c.point);
  const double distance = std::sqrt(dot(d, d));
  return double(triangle_pdf(project(c), float(distance))) * std::abs(dot(n, d)) /
         (distance * distance * distance);
}

TEST(TriangleSampling, HasItsDensity) {
  uint64_t seed = 100;
  for (const Case& c : kCases) {
    ChiSquareSettings settings;
    settings.bins_x = settings.bins_y = 20;
    settings.samples = 200'000;
    settings.tests = int(std::size(kCases));
    settings.seed = ++seed;
    const ProjectedTriangle projected = project(c);
    ASSERT_EQ(projected.spherical(), c.spherical) << c.name << " " << projected.solid_angle;
    EXPECT_TRUE(test::chi_square_test(
        [&](TestRandom& r) -> std::optional<ChiSquarePoint> {
          const TriangleSample s = sample_one(c, r.vec2());
          return ChiSquarePoint{s.barycentric.x, s.barycentric.y, 1};
        },
        [&](double x, double y) { return density_in_barycentrics(c, x, y); }, {}, settings))
        << c.name;
  }
}

TEST(TriangleSampling, Inverts) {
  for (const Case& c : kCases) {
    if (!c.spherical) continue;
    const ProjectedTriangle projected = project(c);
    for (uint64_t draw = 0; draw < 5000; ++draw) {
      const Vec2f u = TestRandom(5, draw).vec2();
      const TriangleSample s = sample_one(c, u);
      const Vec3d to_light = projected.to_p0 + projected.edge1 * double(s.barycentric.x) +
                             projected.edge2 * double(s.barycentric.y);
      const Vec2f back = to_square(projected, test::unit(to_light));
      // Barycentrics are floats, so near vertex b a whole range of u.x maps to the same
      // barycentrics.
      ASSERT_NEAR(back.y, u.y, 2e-5) << c.name << " " << u;
      ASSERT_NEAR(back.x, u.x, 2e-5 + 2e-6 / std::sqrt(double(u.y) + 1e-9)) << c.name << " " << u;
    }
  }
}

TEST(TriangleSampling, SolidAngleMatchesGirard) {
  for (const Case& c : kCases) {
    const ProjectedTriangle projected = project(c);
    const double exact = test::girard_solid_angle(projected.a, projected.b, projected.c);
    EXPECT_NEAR(projected.solid_angle, exact, 1e-14 + 1e-10 * exact) << c.name;
  }
  const ProjectedTriangle octant = project(kCases[2]);
  EXPECT_NEAR(octant.solid_angle, kPiD / 2, 1e-14);
}

// A triangle with edges of length s at distance d fills s^2/2d^2 cos, here from 1e-2 down to 1e-16
// sr.
TEST(TriangleSampling, SolidAngleKeepsItsDigitsFarAway) {
  for (double d = 10; d <= 1e8; d *= 10) {
    const Vec3f p0(0, 0, 0), p1(1, 0, 0), p2(0, 1, 0), point(float(d), 0, float(d));
    const ProjectedTriangle projected = project_triangle(p0, p1, p2, point);
    const Vec3d to_centre = Vec3d(1.0 / 3, 1.0 / 3, 0) - Vec3d(point);
    const double r2 = dot(to_centre, to_centre);
    const double flat = 0.5 * d / (r2 * std::sqrt(r2));
    EXPECT_NEAR(projected.solid_angle / flat, 1, 2 / (d * d) + 1e-9) << d;
  }
}

// The mean direction times the solid angle is Lambert's vector irradiance, which is known exactly.
TEST(TriangleSampling, MeanDirectionIsVectorIrradiance) {
  for (const Case& c : kCases) {
    const ProjectedTriangle projected = project(c);
    // From this close, sampling by area has too high a variance for any count. Only MIS may use it.
    if (projected.solid_angle > kMaxSphericalAngle) continue;
    Vec3d sum(0.0), squares(0.0);
    constexpr int kSamples = 100'000;
    for (uint64_t draw = 0; draw < kSamples; ++draw) {
      const TriangleSample s = sample_one(c, TestRandom(9, draw).vec2());
      const Vec3d x = Vec3d(s.direction) / double(s.pdf);
      sum += x;
      squares += Vec3d(x.x * x.x, x.y * x.y, x.z * x.z);
    }
    sum /= kSamples;
    squares /= kSamples;
    Vec3d exact = test::vector_irradiance({projected.a, projected.b, projected.c});
    if (dot(exact, projected.a + projected.b + projected.c) < 0) exact = -exact;
    for (int i = 0; i < 3; ++i) {
      const double error = std::sqrt(std::max(0.0, squares[i] - sum[i] * sum[i]) / kSamples);
      // 42 comparisons at 5.5 deviations give one false alarm in 1e6 runs with other seeds.
      EXPECT_NEAR(sum[i], exact[i], 5.5 * error + 1e-6 * projected.solid_angle)
          << c.name << " axis " << i;
    }
  }
}

TEST(TriangleSampling, SampleAndHitAgreeAboutTheDensity) {
  for (const Case& c : kCases)
    for (uint64_t draw = 0; draw < 2000; ++draw) {
      const ProjectedTriangle projected = project(c);
      const TriangleSample s = sample_one(c, TestRandom(11, draw).vec2());
      ASSERT_GT(s.pdf, 0) << c.name;
      ASSERT_NEAR(dot(s.direction, s.direction), 1, 1e-6) << c.name;
      const Vec3d hit = Vec3d(s.position) - Vec3d(c.point);  // as a ray would find it, rounded
      const float distance = float(std::sqrt(dot(hit, hit)));
      ASSERT_NEAR(distance / s.distance, 1, 1e-5) << c.name;
      ASSERT_NEAR(triangle_pdf(projected, distance) / s.pdf, 1, 1e-4) << c.name;
    }
}

// The result does not depend on the rest of the batch, nor on its padding to whole vectors.
TEST(TriangleSampling, BatchHasTheBitsOfSingleSamples) {
  for (int count = 1; count <= kRayBatch; ++count) {
    for (uint64_t draw = 0; draw < 50; ++draw) {
      TestRandom random(13, draw);
      TriangleBatch batch;
      std::vector<const Case*> cases;
      std::vector<Vec2f> u;
      for (int i = 0; i < count; ++i) {
        cases.push_back(&kCases[random.bits() % std::size(kCases)]);
        u.push_back(random.vec2());
        const Case& c = *cases.back();
        batch.add({c.p0, c.p1, c.p2}, c.point, u.back());
      }
      ASSERT_EQ(batch.size(), count);
      batch.sample();
      for (int i = 0; i < count; ++i) {
        const Case& c = *cases[size_t(i)];
        const ProjectedTriangle projected = project(c);
        const TriangleSample alone = sample_one(c, u[size_t(i)]);
        const TriangleSample s = batch[i];
        EXPECT_EQ(s.barycentric, alone.barycentric) << c.name << " in " << count;
        EXPECT_EQ(s.position, alone.position) << c.name;
        EXPECT_EQ(s.direction, alone.direction) << c.name;
        EXPECT_EQ(s.distance, alone.distance) << c.name;
        EXPECT_EQ(s.pdf, alone.pdf) << c.name;
        EXPECT_EQ(batch.normal(i), to_float(projected.normal)) << c.name;
        EXPECT_EQ(batch.in_front(i), projected.height > 0) << c.name;
      }
    }
  }
}

// Scaling by powers of two is exact, so only the scale of the result may change.
TEST(TriangleSampling, IsScaleFree) {
  for (const Case& c : kCases)
    for (float scale : {0x1p-40f, 0x1p-20f, 0x1p20f, 0x1p40f}) {
      const ProjectedTriangle one = project(c);
      const ProjectedTriangle other =
          project_triangle(c.p0 * scale, c.p1 * scale, c.p2 * scale, c.point * scale);
      const TriangleSample a = sample_one(c, {0.3f, 0.6f});
      const TriangleSample b = sample_one(c, {0.3f, 0.6f}, scale);
      EXPECT_EQ(one.spherical(), other.spherical()) << c.name;
      EXPECT_EQ(a.pdf, b.pdf) << c.name << " x " << scale;
      EXPECT_EQ(a.direction, b.direction) << c.name << " x " << scale;
      EXPECT_EQ(a.distance * scale, b.distance) << c.name << " x " << scale;
    }
}

TEST(TriangleSampling, NothingToSampleIsDensityZero) {
  const Vec3f p0(0, 0, 0), p1(1, 0, 0), p2(0, 1, 0), above(0.2f, 0.2f, 1);
  const Case degenerate[] = {
      {"a point", p0, p0, p0, above, false},
      {"two equal vertices", p0, p1, p1, above, false},
      {"on a line", p0, p1, {2, 0, 0}, above, false},
      {"seen edge on", p0, p1, p2, {3, 3, 0}, false},
      {"point inside it", p0, p1, p2, {0.2f, 0.2f, 0}, false},
      {"point on a vertex", p0, p1, p2, p1, false},
      {"point at infinity", p0, p1, p2, {0, 0, std::numeric_limits<float>::infinity()}, false},
      {"not a number", p0, p1, {0, std::nanf(""), 0}, above, false},
  };
  for (const Case& c : degenerate) {
    const ProjectedTriangle projected = project(c);
    const TriangleSample s = sample_one(c, {0.4f, 0.4f});
    EXPECT_FALSE(s.pdf > 0 && !std::isfinite(s.pdf)) << c.name;
    EXPECT_EQ(triangle_pdf(projected, 1.0f), 0.0f) << c.name;
    EXPECT_EQ(s.pdf, 0.0f) << c.name;
  }
}

TEST(TriangleSampling, EdgesOfTheSquareStayOnTheTriangle) {
  for (const Case& c : kCases)
    for (float x : {0.0f, 0x1p-24f, 0.5f, kOneMinusEpsilon})
      for (float y : {0.0f, 0x1p-24f, 0.5f, kOneMinusEpsilon}) {
        const TriangleSample s = sample_one(c, {x, y});
        EXPECT_TRUE(is_finite(s.position) && is_finite(s.direction))
            << c.name << " " << x << " " << y;
        EXPECT_GE(s.barycentric.x, 0) << c.name;
        EXPECT_GE(s.barycentric.y, 0) << c.name;
        EXPECT_LE(s.barycentric.x + s.barycentric.y, 1 + 1e-6f) << c.name;
        EXPECT_GT(s.pdf, 0) << c.name;
      }
}

}  // namespace
}  // namespace emberline
