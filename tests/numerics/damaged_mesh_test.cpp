// Degenerate triangles: without area, with a non-finite vertex, or a billion times as long as wide.
#include "closed_form.h"

#include <nlohmann/json.hpp>
#include "io/gltf/gltf_file.h"
#include "support/chi_square.h"
#include "support/gltf_builder.h"
#include "support/light_scenes.h"
#include "support/scenes.h"
#include "support/single_queries.h"

namespace emberline {
namespace {

using namespace test;
using nlohmann::json;

// Writes and reads a file with a ball on a floor under a lamp. `damaged` adds triangles that cannot
// be drawn to every mesh, including the lamp. Their vertices are repeated, collinear, NaN or
// infinite.
SceneDescription damaged_scene(const TempFolder& folder, bool damaged) {
  GltfBuilder gltf;
  const auto add = [&](const MeshDescription& mesh, const json& material) {
    std::vector<float> positions;
    std::vector<uint32_t> indices;
    for (const Vec3f& p : mesh.positions) positions.insert(positions.end(), {p.x, p.y, p.z});
    for (const auto& t : mesh.triangles) indices.insert(indices.end(), t.begin(), t.end());
    if (damaged) {
      const auto first = uint32_t(positions.size() / 3);
      const float nan = std::numeric_limits<float>::quiet_NaN();
      const float inf = std::numeric_limits<float>::infinity();
      positions.insert(positions.end(), {nan, 0, 0, 0, -inf, 0, 2, 2, 2, 3, 3, 3, 4, 4, 4});
      // The bad triangles come first in the index list, so they shift the numbers of all other
      // triangles.
      const std::vector<uint32_t> bad = {0,         1,         first,     1,         first + 1, 2,
                                         1,         1,         2,         2,         2,         2,
                                         first + 2, first + 3, first + 4, first + 2, first + 2, 0};
      indices.insert(indices.begin(), bad.begin(), bad.end());
    }
    const int p = gltf.add_accessor<float>("VEC3", positions);
    const int i = gltf.add_accessor<uint32_t>("SCALAR", indices);
    gltf.add_mesh_node(gltf.add_mesh({{"attributes", {{"POSITION", p}}},
                                      {"indices", i},
                                      {"material", gltf.push("materials", material)}}));
  };
  const auto square = [](float half, float y, bool up) {
    MeshDescription mesh;
    for (const float x : {-half, half}) mesh.positions.emplace_back(x, y, half);
    for (const float x : {half, -half}) mesh.positions.emplace_back(x, y, -half);
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    if (!up) mesh.triangles = {{0, 2, 1}, {0, 3, 2}};
    return mesh;
  };
  add(square(4, -1, true), json::object());
  add(SceneBuilderForTests::sphere(1, 12, -1),
      {{"pbrMetallicRoughness", {{"metallicFactor", 1.0}, {"roughnessFactor", 0.4}}}});
  add(square(1, 3, false), {{"emissiveFactor", {1, 1, 1}}});
  const std::string path = folder / (damaged ? "damaged.glb" : "sound.glb");
  return load_gltf(gltf.write_glb(path), {});
}

// Case 19: the damage does not change a single bit of the picture.
TEST(DamagedMesh, LeavesNoTrace) {
  const TempFolder folder;
  const SceneDescription sound = damaged_scene(folder, false);
  const SceneDescription damaged = damaged_scene(folder, true);
  EXPECT_EQ(damaged.repairs.non_finite_triangles, 6u);
  EXPECT_EQ(damaged.repairs.degenerate_triangles, 12u);
  RenderSettings s;
  s.width = s.height = 48;
  const CameraDescription view = perspective({3, 2, 6}, {0, 0, 0}, 40);
  const RenderedImage a = render(*build_scene(sound, {}), view, s);
  const RenderedImage b = render(*build_scene(damaged, {}), view, s);
  EXPECT_GT(a.mean, 0.01);
  EXPECT_EQ(b.counters.non_finite_samples, 0u);
  double different = 0;
  for (size_t i = 0; i < a.values.size(); ++i) different += a.values[i] != b.values[i];
  expect_case({"19", "values that differ from the undamaged mesh's"}, {0, different, 0, 0},
              replay(s));
}

// A lamp is never sampled if its area is zero, or too small for double to tell from zero.
TEST(DamagedMesh, EmitterWithoutAreaHasNoDensity) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  Triangles list = {triangle({-1, 1, -1}, {1, 1, -1}, {0, 1, 1}, 1, true),
                    triangle({2, 1, 0}, {2, 1, 0}, {2, 1, 0}, 1, true),
                    triangle({0, 2, 0}, {1, 2, 0}, {2, 2, 0}, 1, true),
                    triangle({0, 2, 0}, {nan, 2, 0}, {0, 2, 1}, 1, true)};
  for (const uint32_t threshold : {1u, 16u}) {
    const LightSampler lights = make_light_sampler(list, {}, nullptr, threshold);
    const LightQuery query{Vec3f(0.1f, 0, 0.1f), Vec3f(0, 1, 0)};
    double wrong = 0;
    for (int i = 0; i < 20'000; ++i) {
      TestRandom random(19, uint64_t(i));
      const float pick = random.next();
      const LightSample sample = test::sample_one(lights, query, pick, random.vec2());
      wrong += sample.kind != LightKind::kTriangle || sample.index != 0 || !(sample.pdf > 0);
    }
    for (const uint32_t index : {1u, 2u, 3u}) {
      wrong += lights.pdf_triangle(query, index, 1.0f) != 0.0f;
    }
    expect_case({"19", threshold == 1 ? "degenerate emitters, tree" : "degenerate emitters, power"},
                {0, wrong, 0, 0}, "TestRandom(19, draw)");
  }
}

// The floor and the back of a closed cavity are fans of needles, triangles with aspect ratios up to
// 1e9. The needles end on the edge between the two, at distances from its corner that start at a
// millionth or a billionth. Every estimator gives Le / (1 - rho) = 1.
TEST(SkinnyTriangles, CavityStaysClosed) {
  for (const float narrowest : {1e-6f, 1e-9f}) {
    SceneBuilderForTests b;
    MaterialDescription m = lambert(Rgb(.8f));
    m.emission = Rgb(.2f);
    const int material = b.add_material(m);
    // The unit box faces inwards. Floats are finest at its corner (0, 0, 0).
    b.add_quad({0, 0, 0}, {0, 1, 0}, {0, 1, 1}, {0, 0, 1}, material);
    b.add_quad({1, 0, 0}, {1, 0, 1}, {1, 1, 1}, {1, 1, 0}, material);
    b.add_quad({0, 1, 0}, {1, 1, 0}, {1, 1, 1}, {0, 1, 1}, material);
    b.add_quad({0, 0, 1}, {0, 1, 1}, {1, 1, 1}, {1, 0, 1}, material);
    MeshDescription back, floor;
    back.name = floor.name = "fan";
    back.material = floor.material = material;
    back.positions.emplace_back(0.5f, 1.0f, 0.0f);  // above the shared edge y = z = 0
    floor.positions.emplace_back(0.5f, 0.0f, 1.0f);
    std::vector<float> cuts = {0};
    for (float x = narrowest; x < 0.3f; x *= 2) cuts.push_back(x);
    cuts.push_back(1);
    for (const float x : cuts) {
      back.positions.emplace_back(x, 0.0f, 0.0f);
      floor.positions.emplace_back(x, 0.0f, 0.0f);
    }
    const auto n = uint32_t(cuts.size());
    for (uint32_t i = 1; i < n; ++i) {
      back.triangles.push_back({0, i, i + 1});
      floor.triangles.push_back({0, i + 1, i});
    }
    back.positions.emplace_back(0.0f, 1.0f, 0.0f);
    back.positions.emplace_back(1.0f, 1.0f, 0.0f);
    back.triangles.push_back({0, n + 1, 1});
    back.triangles.push_back({0, n, n + 2});
    floor.positions.emplace_back(0.0f, 0.0f, 1.0f);
    floor.positions.emplace_back(1.0f, 0.0f, 1.0f);
    floor.triangles.push_back({0, 1, n + 1});
    floor.triangles.push_back({0, n + 2, n});
    b.place(b.add_mesh(back));
    b.place(b.add_mesh(floor));
    const auto scene = b.build();
    for (const bool light_sampling : {true, false}) {
      RenderSettings s;
      s.spp = 64;
      s.max_depth = 1000;
      s.light_samples = light_sampling ? 1 : 0;
      // Looks into the corner with the needles.
      expect_exact(render(*scene, perspective({.5, .5, .7}, {.05, .02, 0}, 60), s), 1.0, 1e-5, s,
                   {"19", "cavity with needles of width " + std::to_string(1e9 * narrowest) +
                              "e-9" + (light_sampling ? "" : ", BSDF sampling")});
    }
  }
}

// Collinear triangles can get past the file reader, since a tiny triangle far from the scene's
// centre collapses only when it is placed. Rounding can make a ray hit such a triangle. The hit
// must be finite and its normals must have unit length.
TEST(DamagedMesh, CollapsedTrianglesGiveNoNaN) {
  SceneBuilderForTests b;
  MeshDescription mesh;
  mesh.name = "collapsed";
  mesh.material = b.add_material(lambert(Rgb(.5f)));
  constexpr uint32_t kCount = 20'000;
  std::vector<Vec3f> targets;
  for (uint32_t i = 0; i < kCount; ++i) {
    TestRandom random(20, i);
    const auto point = [&] {
      return Vec3f(random.next(), random.next(), random.next()) - Vec3f(.5f);
    };
    // Half of the triangles are collinear up to rounding. The others are exactly collinear, since
    // their coordinates are small multiples of powers of two.
    Vec3f p = point(), d = point();
    if (i % 2) {
      for (int c = 0; c < 3; ++c)
        p[c] = std::round(p[c] * 64) / 64, d[c] = std::round(d[c] * 64) / 64;
    }
    for (const float t : {0.0f, .25f, 1.0f}) mesh.positions.push_back(p + d * t);
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    targets.push_back(p + d * .375f);
  }
  b.place(b.add_mesh(mesh));
  b.set_environment(Rgb(1.0f));
  const auto scene = b.build();
  uint32_t hits = 0;
  double wrong = 0;
  for (uint32_t i = 0; i < kCount; ++i) {
    TestRandom random(21, i);
    const Vec3f from(random.next() + 1, random.next() + 1, random.next() + 1);
    SurfaceHit hit;
    if (!scene->intersect({from, normalize(targets[i] - from)}, {}, &hit)) continue;
    ++hits;
    SurfaceInteraction s;
    scene->interaction(hit, 0, &s);
    wrong += !is_finite(s.position) || !(std::abs(s.geometric_normal.length() - 1) < 1e-5f) ||
             !(std::abs(s.shading_normal.length() - 1) < 1e-5f);
  }
  EXPECT_GT(hits, 100u) << "too few rays met anything to tell";
  expect_case({"E20", "collapsed triangles without a finite frame"}, {0, wrong, 0, 0},
              "TestRandom(20 and 21, triangle)");
}

}  // namespace
}  // namespace emberline
