// Tests the light BVH itself: its probabilities, ranges and depth.
#include "renderer/lights/light_bvh.h"

#include <gtest/gtest.h>

#include "renderer/core/warps.h"
#include "support/chi_square.h"
#include "support/closed_forms.h"

namespace emberline {
namespace {

using test::TestRandom;

struct Emitter {
  EmitterBounds bounds;
  Vec3f p[3];  // a triangle, or a point if all three are equal
};

Vec3f random_point(TestRandom& random, float scale) {
  return Vec3f(random.next() * 2 - 1, random.next() * 2 - 1, random.next() * 2 - 1) * scale;
}

Emitter make_triangle(const Vec3f& p0, const Vec3f& p1, const Vec3f& p2, bool two_sided) {
  Emitter e{{}, {p0, p1, p2}};
  for (int i = 0; i < 3; ++i) {
    e.bounds.lower[i] = std::min({p0[i], p1[i], p2[i]});
    e.bounds.upper[i] = std::max({p0[i], p1[i], p2[i]});
  }
  const Vec3d n = cross(Vec3d(p1) - Vec3d(p0), Vec3d(p2) - Vec3d(p0));
  e.bounds.axis = Vec3f(test::unit(n));
  e.bounds.two_sided = two_sided;
  e.bounds.intensity = 0.5 * std::sqrt(dot(n, n));
  return e;
}

// Triangles of very different sizes, points and spots in a cube of the given half width.
std::vector<Emitter> random_emitters(int count, uint64_t seed, float scale) {
  std::vector<Emitter> result;
  for (int i = 0; i < count; ++i) {
    TestRandom random(seed, uint64_t(i));
    const Vec3f at = random_point(random, scale);
    const float kind = random.next();
    if (kind < 0.7f) {
      const float size = scale * std::ldexp(1.0f, -int(random.bits() % 10));
      const Vec3f p1 = at + random_point(random, size), p2 = at + random_point(random, size);
      result.push_back(make_triangle(at, p1, p2, kind < 0.2f));
    } else {
      Emitter e{{}, {at, at, at}};
      e.bounds.lower = e.bounds.upper = at;
      e.bounds.axis = square_to_sphere(random.vec2());
      e.bounds.intensity = double(random.next() + 1e-3f) * scale * scale;
      e.bounds.cos_theta_o = kind < 0.85f ? -1.0f : std::cos(random.next() * 0.7f);
      e.bounds.cos_theta_e = kind < 0.85f ? 0.0f : std::cos(random.next() * 0.7f);
      result.push_back(e);
    }
  }
  return result;
}

LightBvh build(const std::vector<Emitter>& emitters) {
  std::vector<EmitterBounds> bounds;
  for (const Emitter& e : emitters) bounds.push_back(e.bounds);
  return LightBvh(bounds);
}

LightQuery random_query(TestRandom& random, float scale) {
  LightQuery query;
  query.point = random_point(random, scale * (random.next() < 0.3f ? 20.0f : 1.5f));
  query.normal = square_to_sphere(random.vec2());
  query.both_sides = random.next() < 0.2f;
  return query;
}

// Tries some points on the emitter and tells, by definition, whether any light from them reaches
// the query.
bool contributes(const Emitter& e, const LightQuery& query, TestRandom& random) {
  const EmitterBounds& b = e.bounds;
  for (int i = 0; i < 12; ++i) {
    const Vec2f bary = i < 3 ? Vec2f(i == 1 ? 1.0f : 0.0f, i == 2 ? 1.0f : 0.0f)
                             : square_to_triangle(random.vec2());
    const Vec3d at = Vec3d(e.p[0]) * double(1 - bary.x - bary.y) + Vec3d(e.p[1]) * double(bary.x) +
                     Vec3d(e.p[2]) * double(bary.y);
    const Vec3d to_query = Vec3d(query.point) - at;
    const double received = -dot(to_query, Vec3d(query.normal));
    if (!(query.both_sides ? received != 0 : received > 0)) continue;
    const double reach =
        std::acos(std::clamp(double(b.cos_theta_o), -1.0, 1.0)) + std::acos(double(b.cos_theta_e));
    double angle = test::angle_between(test::unit(to_query), Vec3d(b.axis));
    if (b.two_sided) angle = std::min(angle, kPiD - angle);
    if (angle < reach) return true;
  }
  return false;
}

TEST(LightBvh, PickTellsItsProbabilityToTheBit) {
  for (int count : {1, 2, 3, 5, 17, 100, 1000}) {
    const LightBvh bvh = build(random_emitters(count, 1, 1.0f));
    for (uint64_t draw = 0; draw < 3000; ++draw) {
      TestRandom random(2, draw);
      const LightQuery query = random_query(random, 1.0f);
      const LightBvh::Pick pick = bvh.pick(query, random.next_double());
      if (pick.probability == 0) continue;
      ASSERT_EQ(pick.probability, bvh.probability(query, pick.emitter)) << count << " " << draw;
    }
  }
}

// A regular grid of u visits each emitter as often as its probability says, to within a few steps
// of the grid. The test is deterministic.
TEST(LightBvh, ProbabilitiesAreTheLengthsOfTheirIntervals) {
  const int kGrid = 200'000;
  for (int count : {2, 7, 60}) {
    const LightBvh bvh = build(random_emitters(count, 3, 1.0f));
    for (uint64_t draw = 0; draw < 5; ++draw) {
      TestRandom random(4, draw);
      const LightQuery query = random_query(random, 1.0f);
      std::vector<int> hits(size_t(count), 0);
      int none = 0;
      for (int i = 0; i < kGrid; ++i) {
        const LightBvh::Pick pick = bvh.pick(query, (i + 0.5) / kGrid);
        if (pick.probability > 0) {
          ++hits[pick.emitter];
        } else {
          ++none;
        }
      }
      double total = double(none) / kGrid;
      for (int e = 0; e < count; ++e) {
        const double p = bvh.probability(query, uint32_t(e));
        total += p;
        EXPECT_NEAR(double(hits[size_t(e)]) / kGrid, p, 2.0 / kGrid) << count << " emitter " << e;
      }
      EXPECT_NEAR(total, 1, 1e-4);
    }
  }
}

TEST(LightBvh, EveryContributingLightCanBePicked) {
  int contributing = 0, refused = 0;
  for (float scale : {1e-6f, 1.0f, 1e6f})
    for (int count : {3, 40, 400}) {
      const std::vector<Emitter> emitters = random_emitters(count, 5, scale);
      const LightBvh bvh = build(emitters);
      for (uint64_t draw = 0; draw < 60; ++draw) {
        TestRandom random(6, draw);
        LightQuery query = random_query(random, scale);
        const Emitter& near = emitters[random.bits() % emitters.size()];
        if (draw % 4 == 0)  // in the plane of a light
          query.point = near.p[0] + (near.p[1] - near.p[0]) * 3.0f - (near.p[2] - near.p[0]);
        if (draw % 4 == 1)  // inside its bounds
          query.point = (near.bounds.lower + near.bounds.upper) * 0.5f;
        for (size_t e = 0; e < emitters.size(); ++e) {
          const bool lit = contributes(emitters[e], query, random);
          const float p = bvh.probability(query, uint32_t(e));
          ASSERT_TRUE(std::isfinite(p));
          ASSERT_FALSE(lit && p == 0) << "scale " << scale << " draw " << draw << " emitter " << e;
          contributing += lit;
          refused += p == 0;
        }
      }
    }
  EXPECT_GT(contributing, 10000);  // the test covers enough contributing emitters,
  EXPECT_GT(refused, 10000);       // and the tree rejects enough of them
}

TEST(LightBvh, PowersOfTwoOfScaleChangeNothing) {
  const std::vector<Emitter> emitters = random_emitters(200, 7, 1.0f);
  const LightBvh one = build(emitters);
  for (float scale : {0x1p-60f, 0x1p-20f, 0x1p20f, 0x1p60f}) {
    std::vector<EmitterBounds> scaled;
    for (const Emitter& e : emitters) {
      scaled.push_back(e.bounds);
      scaled.back().lower *= scale;
      scaled.back().upper *= scale;
    }
    const LightBvh other{std::span<const EmitterBounds>(scaled)};
    for (uint64_t draw = 0; draw < 500; ++draw) {
      TestRandom random(8, draw);
      LightQuery query = random_query(random, 1.0f);
      const uint32_t e = random.bits() % 200;
      const float p = one.probability(query, e);
      query.point *= scale;
      ASSERT_EQ(p, other.probability(query, e)) << scale;
    }
  }
}

// Cost-driven splits could separate one emitter per level, but the depth must stay limited.
TEST(LightBvh, DepthIsBounded) {
  std::vector<EmitterBounds> geometric, same_place;
  for (int i = 0; i < 4000; ++i) {
    EmitterBounds b;
    const float x = std::ldexp(1.0f + float(i / 200) / 20.0f, -(i % 200) / 2);
    b.lower = b.upper = Vec3f(x, 0, 0);
    b.axis = Vec3f(0, 0, 1);
    b.cos_theta_o = -1;
    b.intensity = x;
    geometric.push_back(b);
    b.lower = b.upper = Vec3f(3, 3, 3);
    same_place.push_back(b);
  }
  for (const auto& emitters : {geometric, same_place}) {
    const LightBvh bvh{std::span<const EmitterBounds>(emitters)};
    EXPECT_LE(bvh.depth(), 64);
    const LightQuery query{Vec3f(0, 1, 0), Vec3f(0, -1, 0), true};
    double total = 0;
    for (uint32_t e = 0; e < emitters.size(); ++e) total += bvh.probability(query, e);
    EXPECT_NEAR(total, 1, 1e-5);
  }
}

// The lights are mirrored in X. From the mirror plane, both halves are equally likely.
TEST(LightBvh, MirroredLightsAreEquallyLikely) {
  std::vector<Emitter> emitters;
  for (int i = 0; i < 64; ++i) {
    TestRandom random(9, uint64_t(i));
    const Vec3f at = random_point(random, 1.0f) + Vec3f(1.5f, 0, 0);
    const Vec3f p1 = at + random_point(random, 0.1f), p2 = at + random_point(random, 0.1f);
    const auto mirror = [](const Vec3f& p) { return Vec3f(-p.x, p.y, p.z); };
    emitters.push_back(make_triangle(at, p1, p2, false));
    emitters.push_back(make_triangle(mirror(at), mirror(p2), mirror(p1), false));
  }
  const LightBvh bvh = build(emitters);
  for (uint64_t draw = 0; draw < 50; ++draw) {
    TestRandom random(10, draw);
    LightQuery query = random_query(random, 3.0f);
    query.point.x = query.normal.x = 0;
    query.normal = normalize(query.normal);
    double left = 0, right = 0;
    for (uint32_t e = 0; e < emitters.size(); e += 2) {
      right += bvh.probability(query, e);
      left += bvh.probability(query, e + 1);
    }
    EXPECT_NEAR(left, right, 0.01 * (left + right)) << draw;
  }
}

}  // namespace
}  // namespace emberline
