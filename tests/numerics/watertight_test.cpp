// Case 27: closed meshes do not leak. EMBERLINE_WATERTIGHT_RAYS sets the number of rays for each
// mesh and way of aiming. The default of 8e5 gives more than 1e7 rays in total, and 1e7 gives 2e8.
#include <atomic>
#include <cstdlib>

#include "closed_form.h"
#include "renderer/core/parallel.h"
#include "renderer/core/warps.h"
#include "support/chi_square.h"
#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

uint64_t ray_count() {
  const char* text = std::getenv("EMBERLINE_WATERTIGHT_RAYS");
  return text && *text ? uint64_t(std::strtod(text, nullptr)) : long_or_short(800'000, 200'000);
}

// Returns a bumpy ball without coplanar triangles, tessellated by longitude and latitude. Its
// triangles at the poles are needles, 48 of which share a vertex.
MeshDescription bumpy(int material) {
  MeshDescription mesh = SceneBuilderForTests::sphere(1.0f, 24, material, true);
  for (Vec3f& p : mesh.positions) {
    p *= 1 + 0.1f * std::sin(7 * p.x) * std::sin(5 * p.y + 1) * std::sin(6 * p.z + 2);
  }
  // Each pole has one vertex per column. This loop makes them identical.
  for (size_t i = 0; i < 48; ++i) {
    mesh.positions[i] = mesh.positions[0];
    mesh.positions[mesh.positions.size() - 1 - i] = mesh.positions.back();
  }
  return mesh;
}

struct Placed {
  const char* name;
  Mat44d to_world;
  bool instanced;
};

Mat44d sheared() {
  Mat44d m;
  const double rows[3][3] = {{-40, 3, 0}, {.2, .5, .1}, {1, -2, 6}};  // determinant < 0: mirrored
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) m[i][j] = rows[i][j];
  }
  return m * translation(100, -20, 7);
}

enum class Aim { kAnywhere, kAlongAxes, kAtEdges, kAtVertices };
constexpr const char* kAims[] = {"anywhere", "along the axes", "at edges", "at vertices"};

// Counts the rays that escape, from random points well inside. `vertices` are in internal space.
double escapes(const Scene& scene, const std::vector<Vec3f>& vertices,
               const std::vector<std::array<uint32_t, 3>>& triangles, const Vec3f& center,
               Aim aim) {
  std::atomic<uint64_t> lost = 0;
  parallel_ranges(ray_count(), 4096, [&](size_t begin, size_t end) {
    uint64_t missed = 0;
    for (size_t i = begin; i < end; ++i) {
      TestRandom random(27 + uint64_t(aim), i);
      // The ray starts between the centre and a vertex. This point is inside, since the ball is
      // star-shaped about its centre.
      const Vec3f& some = vertices[random.bits() % vertices.size()];
      const Vec3f from = center + (some - center) * (0.6f * random.next());
      Vec3f direction;
      if (aim == Aim::kAnywhere) {
        direction = square_to_sphere(random.vec2());
      } else if (aim == Aim::kAlongAxes) {
        const uint32_t axis = random.bits() % 3;
        direction = Vec3f(0.0f);
        direction[int(axis)] = random.bits() & 1 ? 1.0f : -1.0f;
        // Half of the directions have a second component and lie in a coordinate plane. The third
        // component is a zero of either sign.
        if (random.bits() & 1) direction[int((axis + 1) % 3)] = random.next() - .5f;
        direction[int((axis + 2) % 3)] = random.bits() & 1 ? -0.0f : 0.0f;
      } else {
        const auto& t = triangles[random.bits() % triangles.size()];
        const Vec3f &a = vertices[t[0]], &b = vertices[t[1]];
        // A third of the rays aim at the middles of edges, the rest at other points on edges.
        const uint32_t which = random.bits() % 3;
        const float s = aim == Aim::kAtVertices ? 0.0f : which == 0 ? .5f : random.next();
        direction = a + (b - a) * s - from;
      }
      SurfaceHit hit;
      missed += !scene.intersect({from, direction}, {}, &hit);
    }
    lost += missed;
  });
  return double(lost);
}

TEST(Watertight, ClosedMeshesLetNothingOut) {
  const Placed cases[] = {{"as it is", Mat44d(), false},
                          {"1e-6", scaling(1e-6), false},
                          {"1e6 times, mirrored, sheared", scaling(1e6) * sheared(), false},
                          {"instanced", Mat44d(), true},
                          {"instanced, mirrored and sheared", sheared(), true}};
  double rays = 0, at_vertices = 0;
  for (const Placed& c : cases) {
    SceneBuilderForTests b;
    const MeshDescription mesh = bumpy(b.add_material(lambert(Rgb(.5f))));
    const int index = b.add_mesh(mesh);
    b.place(index, c.to_world);
    if (c.instanced) b.place(index, c.to_world * translation(1e3, 0, 0));
    b.set_environment(Rgb(1.0f));
    const auto scene = b.build();
    const auto internal = [&](const Vec3f& p) {
      Vec3d world;
      c.to_world.multVecMatrix(Vec3d(p), world);
      return Vec3f((world - scene->origin()) * scene->scale());
    };
    std::vector<Vec3f> vertices;
    for (const Vec3f& p : mesh.positions) vertices.push_back(internal(p));
    for (const Aim aim : {Aim::kAnywhere, Aim::kAlongAxes, Aim::kAtEdges, Aim::kAtVertices}) {
      const double lost = escapes(*scene, vertices, mesh.triangles, internal(Vec3f(0.0f)), aim);
      rays += double(ray_count());
      if (aim == Aim::kAtVertices) {
        at_vertices += lost;
        continue;
      }
      expect_case({"27", std::string("rays lost from a closed mesh, ") + c.name + ", aimed " +
                             kAims[int(aim)]},
                  {0, lost, 0, 0}, "TestRandom(" + std::to_string(27 + int(aim)) + ", ray)");
    }
  }
  // Rays at vertices are reported separately, since only one random ray in 1e14 hits a vertex
  // exactly.
  expect_known_failure({"27", "rays lost from closed meshes, aimed at vertices"},
                       {0, at_vertices, 0, 0}, 0.02 * rays / 4,
                       "Embree's robust triangle test is watertight at edges, not at vertices "
                       "(its issues 174, 181 and 381)",
                       "TestRandom(30, ray)");
  std::printf("measured: %.3g rays, lost at vertices %.0f\n", rays, at_vertices);
}

// Two halves of a ball are separate meshes. They share edges by coordinates, not by indices, and
// together they are closed.
TEST(Watertight, MeshesMeetAlongTheirVertices) {
  SceneBuilderForTests b;
  const int material = b.add_material(lambert(Rgb(.5f)));
  MeshDescription ball = bumpy(material), upper = ball, lower = ball;
  const size_t half = ball.triangles.size() / 2 / 48 * 48;
  upper.triangles.resize(half);
  lower.triangles.erase(lower.triangles.begin(), lower.triangles.begin() + std::ptrdiff_t(half));
  // The cut lies between two rows, so both triangles of each quad are in one mesh.
  b.place(b.add_mesh(upper));
  b.place(b.add_mesh(lower));
  b.set_environment(Rgb(1.0f));
  const auto scene = b.build();
  for (const Aim aim : {Aim::kAnywhere, Aim::kAtEdges}) {
    expect_case({"27", std::string("rays lost between two meshes, aimed ") + kAims[int(aim)]},
                {0, escapes(*scene, ball.positions, ball.triangles, Vec3f(0.0f), aim), 0, 0},
                "TestRandom(" + std::to_string(27 + int(aim)) + ", ray)");
  }
}

}  // namespace
}  // namespace emberline
