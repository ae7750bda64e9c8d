// Nested, overlapping and touching solids (case 14 with more than two solids, and E53). In a
// furnace of radiance 1 every arrangement of clear solids shows 1 from outside. A stack of wide
// slabs reflects Stokes' sum over its faces.
#include "closed_form.h"

#include "renderer/scene/interior.h"
#include "support/glass_scenes.h"
#include "support/moving_scenes.h"
#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

RenderSettings solid_settings(uint32_t spp = 256) {
  RenderSettings s;
  s.width = s.height = 8;
  s.spp = spp;
  s.max_depth = 1000;
  return s;
}

MaterialDescription tinted(float ior, float half_distance) {
  MaterialDescription m = glass(ior, 0);
  m.attenuation_color = Rgb(.5f);
  m.attenuation_distance = half_distance;
  return m;
}

// Neighbouring indices differ.
constexpr double kIndices[] = {1.5, 1.33, 1.8, 1.0, 1.45, 1.6, 1.31, 1.7};

// Looks at `theta` from the vertical, from above or below. The target is off the centre and off the
// diagonals.
CameraDescription seen_along(double theta, bool above) {
  const Vec3d direction(std::sin(theta), above ? std::cos(theta) : -std::cos(theta), 0.3e-3);
  const Vec3d at(.73, 0, .31);
  return orthographic(at + direction * 20.0, at, 1e-3);
}

// Returns the reflectance of layers with these indices, between air on both sides (Stokes 1862).
double stack(double theta, const std::vector<double>& layers) {
  double reflected = 0, before = 1;
  const auto add = [&](double index) {
    const double r = fresnel(std::asin(std::sin(theta) / before), index / before);
    reflected += square(1 - reflected) * r / (1 - reflected * r);
    before = index;
  };
  for (const double index : layers) add(index);
  add(1);
  return reflected;
}

// Lights `slabs` by the upper half of the sky. Compares the reflected and the transmitted light
// with exact values.
void expect_stack(const SceneBuilderForTests& slabs, const std::vector<double>& layers,
                  const std::string& what) {
  SceneBuilderForTests b = slabs;
  b.set_environment(upper_half());
  const auto scene = b.build();
  const double theta = .7, exact = stack(theta, layers);
  const RenderSettings s = solid_settings();
  // The tolerance of 1e-5 covers Fresnel in float.
  expect_exact(render(*scene, seen_along(theta, true), s), exact, 1e-5, s,
               {"14", what + ", reflected"});
  expect_exact(render(*scene, seen_along(theta, false), s), 1 - exact, 1e-5, s,
               {"14", what + ", passed"});
}

void expect_furnace(const SceneBuilderForTests& solids, const std::string& what) {
  SceneBuilderForTests b = solids;
  b.set_environment(Rgb(1.0f));
  const auto scene = b.build();
  const RenderSettings s = solid_settings();
  const RenderedImage image = render(*scene, perspective({.3, .2, 4}, {.02, .01, 0}, 30), s);
  // The noise comes from roulette. The tolerance of 2e-5 covers the index ratios in float, one for
  // each face that a path hits.
  expect_case({"E53", what}, {1.0, image.mean, image.standard_error, 2e-5}, replay(s));
  EXPECT_EQ(image.counters.non_finite_samples, 0u);
  EXPECT_EQ(image.counters.optics.dropped_solids, 0u);
}

constexpr float kSlabWidth = 40;

void add_slab(SceneBuilderForTests& b, double ior, float top, float bottom,
              float wide = kSlabWidth) {
  b.add_box({-wide, bottom, -wide}, {wide, top, wide}, b.add_material(glass(float(ior), 0)));
}

TEST(NestedSolids, SlabsToEightLevels) {
  for (const size_t depth : {3u, 5u, 8u}) {
    SceneBuilderForTests b;
    std::vector<double> layers;
    for (size_t i = 0; i < depth; ++i) {
      const float half = 1 - .1f * float(i);
      add_slab(b, kIndices[i], half, -half, kSlabWidth * half);
      layers.push_back(kIndices[i]);
    }
    for (size_t i = depth - 1; i-- > 0;) layers.push_back(kIndices[i]);
    expect_stack(b, layers, std::to_string(depth) + " slabs in each other");
  }
}

// The same slabs as open sheets. The medium that a ray entered last applies.
TEST(NestedSolids, OpenSlabsToEightLevels) {
  SceneBuilderForTests b;
  std::vector<double> layers;
  for (size_t i = 0; i < 8; ++i) {
    const float half = 1 - .1f * float(i);
    const int material = b.add_material(glass(float(kIndices[i]), 0));
    b.add_floor(kSlabWidth, half, material, true);
    b.add_floor(kSlabWidth, -half, material, false);
    layers.push_back(kIndices[i]);
  }
  for (size_t i = 7; i-- > 0;) layers.push_back(kIndices[i]);
  expect_stack(b, layers, "8 open slabs in each other");
}

TEST(NestedSolids, SpheresToEightLevelsInAFurnace) {
  for (const size_t depth : {2u, 3u, 8u}) {
    SceneBuilderForTests b;
    for (size_t i = 0; i < depth; ++i) {
      b.place(b.add_mesh(SceneBuilderForTests::sphere(1 - .1f * float(i), 12,
                                                      b.add_material(glass(float(kIndices[i]), 0)),
                                                      false, i % 2 == 0)));
    }
    expect_furnace(b, std::to_string(depth) + " spheres in each other");
  }
}

// Light samples from a rough face start in the right solid.
TEST(NestedSolids, RoughSpheresInAFurnace) {
  SceneBuilderForTests b;
  for (size_t i = 0; i < 3; ++i) {
    b.place(b.add_mesh(SceneBuilderForTests::sphere(
        1 - .2f * float(i), 12, b.add_material(glass(float(kIndices[i]), i == 1 ? .4f : 0)))));
  }
  b.set_environment(Rgb(1.0f));
  const RenderSettings s = solid_settings();
  const RenderedImage image = render(*b.build(), perspective({.3, .2, 4}, {.02, .01, 0}, 20), s);
  // A rough face takes its albedo from a table with an error of 4e-3 (README). A path uses the
  // table about twice.
  expect_case({"E53", "a rough sphere between two smooth ones"},
              {1.0, image.mean, image.standard_error, 1e-2}, replay(s));
}

// Where two slabs overlap, the thinner one fills the common part, whichever side a ray comes from.
TEST(OverlappingSolids, SlabsInBothOrders) {
  for (const bool dense_first : {true, false}) {
    const double above = dense_first ? 1.8 : 1.33, below = dense_first ? 1.33 : 1.8;
    const std::string what = dense_first ? ", the dense one above" : ", the dense one below";
    SceneBuilderForTests thin_above;
    add_slab(thin_above, above, 0, -.2f);
    add_slab(thin_above, below, -.1f, -.5f);
    expect_stack(thin_above, {above, below}, "two slabs overlap" + what);

    SceneBuilderForTests in_another;
    add_slab(in_another, 1.5, .5f, -1.0f, 2 * kSlabWidth);
    add_slab(in_another, above, 0, -.2f);
    add_slab(in_another, below, -.1f, -.5f);
    expect_stack(in_another, {1.5, above, below, 1.5}, "two slabs overlap in a third" + what);
  }
}

// Overlapping solids of one material act as one solid.
TEST(OverlappingSolids, OfOneMaterialAreOne) {
  SceneBuilderForTests b;
  const int material = b.add_material(glass(1.5f, 0));
  b.add_box({-kSlabWidth, -.3f, -kSlabWidth}, {kSlabWidth, 0, kSlabWidth}, material);
  b.add_box({-kSlabWidth, -.5f, -kSlabWidth}, {kSlabWidth, -.2f, kSlabWidth}, material);
  expect_stack(b, {1.5}, "two slabs of one material overlap");

  // A single mesh consists of three boxes that overlap.
  SceneBuilderForTests mesh;
  MeshDescription all =
      SceneBuilderForTests::box({-kSlabWidth, -.3f, -kSlabWidth}, {kSlabWidth, 0, kSlabWidth}, 0);
  for (const float top : {-.1f, -.2f}) {
    const MeshDescription more =
        SceneBuilderForTests::box({-kSlabWidth, top - .3f, -kSlabWidth},
                                  {kSlabWidth, top, kSlabWidth}, mesh.add_material(glass(1.5f, 0)));
    const auto first = uint32_t(all.positions.size());
    all.positions.insert(all.positions.end(), more.positions.begin(), more.positions.end());
    for (const auto& t : more.triangles) {
      all.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
  }
  mesh.place(mesh.add_mesh(all));
  expect_stack(mesh, {1.5}, "a mesh that overlaps itself twice");
}

TEST(OverlappingSolids, SpheresInAFurnace) {
  for (const bool third : {false, true}) {
    SceneBuilderForTests b;
    const auto add = [&](float radius, double ior, double x) {
      const int mesh = b.add_mesh(SceneBuilderForTests::sphere(
          radius, 12, b.add_material(glass(float(ior), 0)), false, true));
      b.place(mesh, translation(x, 0, 0));
    };
    add(.6f, 1.5, -.3);
    add(.5f, 1.33, .3);
    if (third) add(1.2f, 1.8, 0);
    expect_furnace(b, third ? "two spheres overlap in a third" : "two spheres overlap");
  }
}

// The common part absorbs like the solid that fills it.
TEST(OverlappingSolids, AbsorbAsTheOneThatFillsThePlace) {
  SceneBuilderForTests b;
  b.add_box({-9, -.2f, -9}, {9, 0, 9}, b.add_material(tinted(1.0f, .1f)));
  b.add_box({-9, -.5f, -9}, {9, -.1f, 9}, b.add_material(tinted(1.0f, .4f)));
  b.set_environment(upper_half());
  const RenderSettings s = solid_settings(16);
  // The ray crosses .2 of the first solid and .3 of the second. The tolerance is 2e-5, since a face
  // of a slab of 9 is rounded by 1e-6, and the half-value distance is only .1.
  expect_exact(render(*b.build(), seen_along(.4, false), s), std::pow(.5, (2 + .75) / std::cos(.4)),
               2e-5, s, {"26", "two absorbing slabs overlap"});
}

// A liquid and the glass around it have coincident faces.
TEST(TouchingSolids, SlabsShareAFace) {
  for (const bool instanced : {false, true}) {
    SceneBuilderForTests b;
    const auto add = [&](double ior, float top, float bottom) {
      const int material = b.add_material(glass(float(ior), 0));
      if (!instanced)
        return b.add_box({-kSlabWidth, bottom, -kSlabWidth}, {kSlabWidth, top, kSlabWidth},
                         material);
      // A second use of the mesh, far below, makes it an instance.
      const int mesh = b.add_mesh(SceneBuilderForTests::box({-1, 0, -1}, {1, 1, 1}, material));
      b.place(mesh, scaling(kSlabWidth, top - bottom, kSlabWidth) * translation(0, bottom, 0));
      b.place(mesh, translation(0, -500, 0));
    };
    add(1.5, 0, -.1f);
    add(1.33, -.1f, -.3f);
    add(1.5, -.3f, -.4f);
    expect_stack(b, {1.5, 1.33, 1.5},
                 instanced ? "a liquid between panes, instances" : "a liquid between panes");
  }
}

// A hollow sphere and its contents share vertices. They are tested clear in a furnace, and with a
// tinted liquid.
TEST(TouchingSolids, ASphereFullOfLiquid) {
  const auto full = [](const MaterialDescription& shell, const MaterialDescription& liquid) {
    SceneBuilderForTests b;
    const int glass_material = b.add_material(shell);
    MeshDescription hollow = SceneBuilderForTests::sphere(1, 12, glass_material);
    const MeshDescription inner = SceneBuilderForTests::sphere(.9f, 12, glass_material, true);
    const auto first = uint32_t(hollow.positions.size());
    hollow.positions.insert(hollow.positions.end(), inner.positions.begin(), inner.positions.end());
    for (const auto& t : inner.triangles) {
      hollow.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
    b.place(b.add_mesh(hollow));
    b.place(b.add_mesh(SceneBuilderForTests::sphere(.9f, 12, b.add_material(liquid))));
    return b;
  };
  expect_furnace(full(glass(1.5f, 0), glass(1.33f, 0)), "a hollow sphere full of water");

  SceneBuilderForTests b = full(glass(1, 0), tinted(1, 1.8f));
  b.set_environment(Rgb(1.0f));
  const RenderSettings s = solid_settings(16);
  // A ray through the middle crosses 1.8 of liquid, less what the facets of 15 degrees cut off, at
  // most 1 - cos 7.5 degrees on either side.
  expect_exact(render(*b.build(), perspective({.001, .002, 4}, {.001, .002, 0}, .01), s), .5,
               .9 * (1 - std::cos(.131)) * 2 / 1.8 * std::log(2.), s,
               {"26", "a hollow sphere full of something dark"});
}

// Ice is in water, and an air bubble is in the ice. The medium of each segment absorbs light along
// that segment.
TEST(NestedSolids, WaterIceAir) {
  for (const bool bends : {false, true}) {
    SceneBuilderForTests b;
    const auto add = [&](float half, double ior, float half_distance) {
      MaterialDescription m = tinted(bends ? float(ior) : 1, half_distance);
      if (bends) m.attenuation_color = Rgb(1.0f);
      if (bends) {
        b.place(b.add_mesh(SceneBuilderForTests::sphere(half, 12, b.add_material(m))));
      } else {
        b.add_box({-half, -half, -half}, {half, half, half}, b.add_material(m));
      }
    };
    add(1, 1.333, 1);
    add(.6f, 1.31, 2);
    add(.2f, 1.0003, 1e6f);
    if (bends) {
      expect_furnace(b, "water, ice and a bubble");
      continue;
    }
    b.set_environment(upper_half());
    const RenderSettings s = solid_settings(16);
    expect_exact(render(*b.build(), orthographic({.01, -5, .02}, {.01, 0, .02}, 1e-3), s),
                 std::pow(.5, .8 + .8 / 2), 1e-5, s, {"26", "water, ice and a bubble, absorbing"});
  }
}

// A lamp and a floor are in two overlapping bodies of the same water, whose common face does not
// block light. The floor shows I cos / (pi d^2) times the transmittance.
TEST(OverlappingSolids, LetLightSamplesThrough) {
  SceneBuilderForTests b;
  const int water = b.add_material(tinted(1.33f, 2));
  b.add_box({-9, -1, -9}, {9, 1, 9}, water);
  b.add_box({-8, .5f, -8}, {8, 3, 8}, water);
  b.add_floor(5, 0, b.add_material(lambert(Rgb(1.0f))));
  b.add_point_light({0, 2, 0}, Rgb(4.0f));
  RenderSettings s = solid_settings(16);
  s.max_depth = 1;
  expect_exact(render(*b.build(), orthographic({.001, .4, .002}, {.001, 0, .002}, 1e-3), s),
               4 / (kPiD * 4) * std::pow(.5, 2.4 / 2), 1e-5, s,
               {"E53", "a lamp in another body of the same water"});
}

// The same with two kinds of water that have the same index, and through a solid of index 1 in air.
TEST(OverlappingSolids, OfOneIndexLetLightSamplesThrough) {
  SceneBuilderForTests b;
  b.add_box({-9, -1, -9}, {9, 1, 9}, b.add_material(tinted(1.33f, 2)));
  b.add_box({-8, .5f, -8}, {8, 3, 8}, b.add_material(tinted(1.33f, 4)));
  b.add_floor(5, 0, b.add_material(lambert(Rgb(1.0f))));
  b.add_point_light({0, 2, 0}, Rgb(4.0f));
  RenderSettings s = solid_settings(16);
  s.max_depth = 1;
  const CameraDescription camera = orthographic({.001, .4, .002}, {.001, 0, .002}, 1e-3);
  // The smaller body fills the common part.
  expect_exact(render(*b.build(), camera, s),
               4 / (kPiD * 4) * std::pow(.5, .4 / 2 + .5 / 2 + 1.5 / 4), 1e-5, s,
               {"E53", "a lamp in water of another tint"});

  SceneBuilderForTests air;
  air.add_box({-9, .5f, -9}, {9, 1.5f, 9}, air.add_material(tinted(1, 2)));
  air.add_floor(5, 0, air.add_material(lambert(Rgb(1.0f))));
  air.add_point_light({0, 2, 0}, Rgb(4.0f));
  expect_exact(render(*air.build(), camera, s), 4 / (kPiD * 4) * std::pow(.5, 1. / 2), 1e-5, s,
               {"E53", "a lamp behind tinted air"});
  const CameraDescription above = orthographic({.001, 1.9, .002}, {.001, 0, .002}, 1e-3);
  expect_exact(render(*air.build(), above, s), 4 / (kPiD * 4) * .5, 1e-5, s,
               {"E53", "a floor that is lit and seen through tinted air"});
}

// A solid stands on a table. The table counts as lying below the solid, both seen from above and
// seen from below.
TEST(TouchingSolids, AGlassOnATable) {
  for (const bool turned : {false, true}) {
    SceneBuilderForTests b;
    MaterialDescription black = lambert(Rgb(0.0f));
    black.double_sided = true;
    const int table = b.add_material(black), clear = b.add_material(glass(1.5f, 0));
    Mat44d pose;
    if (turned) pose = pose.setEulerAngles(Vec3d(.7, .3, -.2)) * translation(31.3, -7.1, 11.9);
    b.place(b.add_mesh(SceneBuilderForTests::box({-1, 0, -1}, {1, 1, 1}, clear)), pose);
    MeshDescription top;
    top.positions = {{-3, 0, -3}, {-3, 0, 3}, {3, 0, 3}, {3, 0, -3}};
    top.triangles = {{0, 1, 2}, {0, 2, 3}};
    top.material = table;
    b.place(b.add_mesh(top), pose);
    b.set_environment(Rgb(1.0f));
    const auto scene = b.build();
    const RenderSettings s = solid_settings(64);
    const std::string what = turned ? ", turned" : "";
    const auto seen_from = [&](double y) {
      Vec3d from, at;
      pose.multVecMatrix(Vec3d(.1, y, .2), from);
      pose.multVecMatrix(Vec3d(.1, 0, .2), at);
      return orthographic(from, at, .5);
    };
    expect_exact(render(*scene, seen_from(5), s), .04, 1e-5, s,
                 {"E53", "a glass on a black table" + what});
    expect_exact(render(*scene, seen_from(-5), s), 0, 1e-7, s,
                 {"E53", "a black table under a glass, from below" + what});
  }
}

// A solid whose faces coincide is a thin wall, as in glTF, and reflects once.
TEST(NestedSolids, AFlatSolidIsAWall) {
  const double theta = .7, exact = fresnel(theta, 1.5);
  for (const char* kind : {"two sheets back to back", "a box pressed flat"}) {
    SceneBuilderForTests b;
    const int clear = b.add_material(glass(1.5f, 0));
    if (kind[0] == 't') {
      MeshDescription sheets;
      sheets.positions = {{-kSlabWidth, 0, -kSlabWidth},
                          {-kSlabWidth, 0, kSlabWidth},
                          {kSlabWidth, 0, kSlabWidth},
                          {kSlabWidth, 0, -kSlabWidth}};
      sheets.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 2, 1}, {0, 3, 2}};
      sheets.material = clear;
      b.place(b.add_mesh(sheets));
    } else {
      b.place(b.add_mesh(SceneBuilderForTests::box({-1, -1, -1}, {1, 1, 1}, clear)),
              scaling(kSlabWidth, 1e-8, kSlabWidth));
    }
    b.set_environment(upper_half());
    const auto scene = b.build();
    const RenderSettings s = solid_settings();
    expect_exact(render(*scene, seen_along(theta, true), s), exact, 1e-5, s,
                 {"14", std::string(kind) + ", reflected"});
    expect_exact(render(*scene, seen_along(theta, false), s), 1 - exact, 1e-5, s,
                 {"14", std::string(kind) + ", passed"});
  }
}

// Light samples pass through a flat solid.
TEST(NestedSolids, AFlatSolidLetsLightSamplesThrough) {
  SceneBuilderForTests b;
  b.place(b.add_mesh(
              SceneBuilderForTests::box({-1, -1, -1}, {1, 1, 1}, b.add_material(glass(1.5f, 0)))),
          scaling(kSlabWidth, 1e-8, kSlabWidth) * translation(0, 1, 0));
  b.add_floor(5, 0, b.add_material(lambert(Rgb(1.0f))));
  b.add_point_light({0, 2, 0}, Rgb(4.0f));
  RenderSettings s = solid_settings(16);
  s.max_depth = 1;
  expect_exact(render(*b.build(), orthographic({.001, .4, .002}, {.001, 0, .002}, 1e-3), s),
               4 / (kPiD * 4) * .96, 1e-5, s, {"E53", "a lamp behind a box pressed flat"});
}

// The faces of a glass and its liquid still coincide in motion.
TEST(TouchingSolids, SlabsThatMoveTogether) {
  SceneBuilderForTests b;
  for (const auto& [ior, top, bottom] :
       {std::tuple{1.5f, 0.f, -.1f}, std::tuple{1.33f, -.1f, -.3f}}) {
    const int mesh = b.add_mesh(SceneBuilderForTests::box({-kSlabWidth, bottom, -kSlabWidth},
                                                          {kSlabWidth, top, kSlabWidth},
                                                          b.add_material(glass(ior, 0))));
    b.place(mesh);
    b.description.instances.back().motion = {translation(.3, .7, .1)};
  }
  expect_stack(b, {1.5, 1.33}, "a liquid and its pane, moving");
}

TEST(NestedSolids, TooManyAreCounted) {
  SceneBuilderForTests b;
  for (int i = 0; i < Interior::kLimit + 2; ++i) {
    const float half = 2 - .05f * float(i);
    add_slab(b, kIndices[i % 8], half, -half, kSlabWidth * half);
  }
  b.set_environment(Rgb(1.0f));
  const RenderSettings s = solid_settings(16);
  EXPECT_GT(render(*b.build(), seen_along(.1, true), s).counters.optics.dropped_solids, 0u);
}

// A ray passes 300 panes in a row, none of which is a solid.
TEST(ThinWalls, ThreeHundredPanes) {
  SceneBuilderForTests b;
  const int pane = b.add_material(glass(1.5f, 0, false));
  for (int i = 0; i < 300; ++i) b.add_floor(1000, -.1f * float(i), pane);
  b.set_environment(Rgb(1.0f));
  const RenderSettings s = solid_settings(64);
  const RenderedImage image = render(*b.build(), seen_along(.3, true), s);
  expect_exact(image, 1.0, 1e-4, s, {"E40", "300 panes in a furnace"});
  EXPECT_EQ(image.counters.optics.rays_ended_at_panes, 0u);
}

}  // namespace
}  // namespace emberline
