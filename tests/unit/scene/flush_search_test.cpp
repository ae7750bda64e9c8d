// Compares the search for emitters flush with surfaces with a test of every pair, and measures its
// time where a search with a single radius would compare all pairs.
#include "renderer/scene/flush_emitters.h"

#include <gtest/gtest.h>

#include <ctime>
#include <map>
#include <random>

#include "support/sanitized.h"

namespace emberline::scene_detail {
namespace {

struct World {
  std::vector<Mesh> meshes;
  std::vector<Instance> instances;
  std::vector<EmissiveTriangle> emitters;

  // Adds a mesh with these corners, in the mesh's space. If `shines`, its triangles are emitters.
  void add(const std::vector<Vec3f>& corners, const std::vector<Affine>& placed, bool shines) {
    Mesh mesh;
    mesh.positions = corners;
    for (uint32_t i = 0; i + 2 < corners.size(); i += 3)
      mesh.triangles.push_back({i, i + 1, i + 2});
    mesh.positions.emplace_back(0.0f);
    meshes.push_back(std::move(mesh));
    for (size_t k = 0; k < std::max(size_t(1), placed.size()); ++k) {
      Instance& instance = instances.emplace_back();
      instance.mesh = uint32_t(meshes.size() - 1);
      instance.transformed = !placed.empty();
      if (instance.transformed) instance.to_internal = placed[k];
      is_emissive_.push_back(shines);
    }
  }

  void light() {
    for (uint32_t i = 0; i < instances.size(); ++i) {
      const Mesh& mesh = meshes[instances[i].mesh];
      for (uint32_t p = 0; is_emissive_[i] && p < mesh.triangles.size(); ++p) {
        const auto c = placed_corners(mesh, instances[i], p);
        EmissiveTriangle e;
        e.p0 = to_float(c[0]);
        e.p1 = to_float(c[1]);
        e.p2 = to_float(c[2]);
        e.mean_radiance = Rgb(1.0f);
        e.instance = i;
        e.primitive = p;
        emitters.push_back(e);
      }
    }
  }

  FlushSurfaces search() const {
    return find_flush_surfaces({meshes, instances, {}, emitters}, LoadProgress::none());
  }

  // The reference tests all pairs for emitters with a point that lies in a surface.
  FlushSurfaces all_pairs() const {
    FlushSurfaces found{std::vector<float>(emitters.size(), 0.0f), {}};
    const auto note = [&](uint64_t key, float reach) {
      found.offsets[key] = std::max(found.offsets[key], reach);
    };
    for (size_t i = 0; i < emitters.size(); ++i) {
      const EmissiveTriangle& e = emitters[i];
      const std::array<Vec3d, 3> a = {to_double(e.p0), to_double(e.p1), to_double(e.p2)};
      const float e_error =
          plane_error(meshes[instances[e.instance].mesh], instances[e.instance], e.primitive);
      const Vec3d middle = (a[0] + a[1] + a[2]) / 3.0;
      std::vector<Vec3d> points = {middle};
      for (const Vec3d& corner : a) points.push_back(corner * 0.97 + middle * 0.03);
      for (uint32_t k = 0; k < instances.size(); ++k) {
        const Mesh& mesh = meshes[instances[k].mesh];
        for (uint32_t p = 0; p < mesh.triangles.size(); ++p) {
          if (k == e.instance && p == e.primitive) continue;
          const auto b = placed_corners(mesh, instances[k], p);
          const float error = e_error + plane_error(mesh, instances[k], p);
          if (std::ranges::none_of(points, [&](const Vec3d& x) { return lies(a, b, x, error); })) {
            continue;
          }
          found.reach[i] = std::max(found.reach[i], 2.0f * error);
          note(surface_key(k, p), 2.0f * error);
          note(surface_key(e.instance, e.primitive), 2.0f * error);
        }
      }
    }
    return found;
  }

 private:
  using Triangle = std::array<Vec3d, 3>;
  static Vec3d normal(const Triangle& t) { return (t[1] - t[0]).cross(t[2] - t[0]).normalized(); }
  static double apart(const Triangle& plane, const Triangle& other) {
    double most = 0.0;
    for (const Vec3d& p : other) most = std::max(most, std::abs((p - plane[0]).dot(normal(plane))));
    return most;
  }
  static bool lies(const Triangle& a, const Triangle& b, const Vec3d& x, float error) {
    const Vec3d n = normal(b);
    for (size_t c = 0; c < 3; ++c) {  // left of each edge
      const Vec3d edge = b[(c + 1) % 3] - b[c];
      if (n.cross(edge).dot(x - b[c]) < -1e-9 * edge.length2()) return false;
    }
    return std::abs((x - b[0]).dot(n)) <= 2.0 * double(error) &&
           std::min(apart(a, b), apart(b, a)) <= double(error);
  }
  std::vector<bool> is_emissive_;
};

Affine placed(float scale, const Vec3f& at) {
  return {Vec3f(scale, 0, 0), Vec3f(0, scale, 0), Vec3f(0, 0, scale), at};
}

// The triangles lie in a few tilted planes, and their sizes are a millimetre to ten kilometres.
TEST(FlushSearch, MatchesASearchOfAllPairs) {
  for (uint32_t seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    const auto unit = [&] { return std::uniform_real_distribution<float>(-1, 1)(random); };
    std::vector<std::array<Vec3d, 3>> planes;  // origin and two axes
    for (int i = 0; i < 4; ++i) {
      const Vec3d u = Vec3d(unit(), unit(), unit()).normalized();
      const Vec3d v = u.cross(Vec3d(unit(), unit(), unit())).normalized();
      planes.push_back({Vec3d(unit(), unit(), unit()) * (i % 2 ? 1.0 : 0.01), u, v});
    }
    World world;
    for (int mesh = 0; mesh < 12; ++mesh) {
      std::vector<Vec3f> corners;
      for (int t = 0; t < 12; ++t) {
        const auto& plane = planes[random() % planes.size()];
        const double size = std::pow(10.0, -3.0 + double(random() % 8));
        const double x = double(unit()) * 0.3, y = double(unit()) * 0.3;
        const double turn = double(unit()) * 3.0;
        for (int c = 0; c < 3; ++c) {
          const double angle = turn + 2.1 * c;
          corners.push_back(to_float(plane[0] + plane[1] * (x + size * std::cos(angle)) +
                                     plane[2] * (y + size * std::sin(angle))));
        }
      }
      std::vector<Affine> places;
      if (mesh % 3 == 2) {  // far from its own origin, where instances are inexact
        const Vec3f away(0, 0, mesh % 2 ? 1000.0f : 8.0f);
        for (Vec3f& p : corners) p += away;
        places = {placed(1, -away), placed(1, -away + Vec3f(0, 0.5f, 0))};
      }
      world.add(corners, places, mesh % 2 == 0);
    }
    world.light();
    const FlushSurfaces found = world.search(), expected = world.all_pairs();
    ASSERT_GT(expected.offsets.size(), 10u);
    EXPECT_EQ(found.reach, expected.reach) << "seed " << seed;
    EXPECT_EQ(std::map(found.offsets.begin(), found.offsets.end()),
              std::map(expected.offsets.begin(), expected.offsets.end()));
  }
}

// A square of n x n tiles of two triangles each, `size` wide.
std::vector<Vec3f> tiles(int n, float size) {
  std::vector<Vec3f> corners;
  const auto at = [&](int x, int y) {
    return Vec3f(size * float(x) / float(n), 0.0f, size * float(y) / float(n));
  };
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      for (const auto& [u, v] : {std::pair(0, 0), {0, 1}, {1, 1}, {0, 0}, {1, 1}, {1, 0}}) {
        corners.push_back(at(x + u, y + v));
      }
    }
  }
  return corners;
}

double processor_seconds(const World& world) {
  const std::clock_t start = std::clock();
  world.search();
  return double(std::clock() - start) / CLOCKS_PER_SEC / test::kSanitizerSlowdown;
}

// The error of the far triangle is larger than all the small triangles together. With a single
// search radius, the search would take minutes.
TEST(FlushSearch, AFarTriangleDoesNotMakeTheNearOnesMeet) {
  World world;
  world.add(tiles(141, 0.1f), {}, true);
  world.add({{1e6f, 0, 0}, {1e6f, 0, 1}, {1e6f, 1, 0}}, {}, true);
  world.light();
  EXPECT_LT(processor_seconds(world), 3.0);
}

TEST(FlushSearch, ALongTriangleAcrossThemIsFoundByAll) {
  World world;
  world.add(tiles(141, 0.1f), {}, true);
  world.add({{-1e6f, 0, -1e6f}, {0, 0, 2e6f}, {1e6f, 0, -1e6f}}, {}, false);
  world.light();
  EXPECT_EQ(std::ranges::count(world.search().reach, 0.0f), 0);
  EXPECT_LT(processor_seconds(world), 3.0);
}

TEST(FlushSearch, StackedTrianglesAreNotAllPaired) {
  World world;
  std::vector<Vec3f> stack;
  for (int i = 0; i < 100000; ++i) stack.insert(stack.end(), {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}});
  world.add(stack, {}, true);
  world.light();
  EXPECT_EQ(std::ranges::count(world.search().reach, 0.0f), 0);
  EXPECT_LT(processor_seconds(world), 10.0);
}

// The rounding error of an instance comes from the largest terms of its transform.
TEST(FlushSearch, InstancesFarFromTheirOwnOrigin) {
  World world;
  std::vector<Vec3f> far = tiles(50, 0.1f);
  for (Vec3f& p : far) p.z += 1e5f;
  world.add(far, {placed(1, {0, 0, -1e5f}), placed(1, {0, 1, -1e5f})}, true);
  world.add(tiles(100, 0.1f), {}, true);
  world.light();
  EXPECT_LT(processor_seconds(world), 10.0);
}

}  // namespace
}  // namespace emberline::scene_detail
