// Light through smooth thin walls. Light samples pass straight through them, and BSDF samples can
// take the same path. Closed forms check the total (E40), and BSDF sampling alone checks that
// nothing is counted twice (E41).
#include <cstring>

#include "lamp_over_floor.h"
#include "support/edited_scene.h"
#include "support/glass_scenes.h"

namespace emberline {
namespace {

using namespace test;

MaterialDescription pane(float tint = 1.0f) {
  MaterialDescription m = glass(1.5f, 0.0f, false);
  m.base_color = Rgb(tint);
  return m;
}

MaterialDescription two_sided(MaterialDescription m) {
  m.double_sided = true;
  return m;
}

// Returns the transmittance of a pane of index 1.5 at this cosine.
double pane_transmittance(double cosine) { return 1 - fresnel(std::acos(cosine), 1.5); }

// ---- closed forms
// --------------------------------------------------------------------------------

// A sky of radiance 1 shines through a pane a thousand times as wide as its height above the floor.
// The sky beside the pane adds 1e-6.
TEST(ThinWalls, ConstantSky) {
  const struct {
    std::string what;
    MaterialDescription material;
    int panes;
    double weight;  // of each pane, besides Fresnel
  } cases[] = {
      {"sky through a pane", pane(), 1, 1},
      {"sky through a tinted pane", pane(.4f), 1, .4},
      {"sky through two panes", pane(.8f), 2, .8},
      {"sky through a pane that is .3 opaque",
       [] {
         MaterialDescription m = pane(.5f);
         m.transmission = .7f;
         return m;
       }(),
       1, .7 * .5},
      {"sky through a pane that is .25 metal",
       [] {
         MaterialDescription m = pane();
         m.metallic = .25f;
         return m;
       }(),
       1, .75},
  };
  for (const auto& c : cases) {
    SceneBuilderForTests b = white_floor();
    const int material = b.add_material(c.material);
    for (int i = 0; i < c.panes; ++i) b.add_floor(1000, 1 + .01f * float(i), material);
    b.set_environment(Rgb(1.0f));
    double sum = 0;  // 2 pi int T mu dmu
    constexpr int kSteps = 20000;
    for (int i = 0; i < kSteps; ++i) {
      const double mu = (i + .5) / kSteps;
      sum += 2 * kPiD * mu / kSteps * std::pow(c.weight * pane_transmittance(mu), c.panes);
    }
    // The tolerance of 1e-5 covers float arithmetic and the sky beside the pane.
    expect_irradiance_at("E40", b, sum, 1e-5, c.what);
  }
}

TEST(ThinWalls, Lamp) {
  for (const int panes : {1, 2, 7}) {
    SceneBuilderForTests b = white_floor();
    const int material = b.add_material(pane(.9f));
    for (int i = 0; i < panes; ++i) b.add_floor(5, .6f + .1f * float(i), material);
    add_lamp(b);
    const double exact =
        lamp_irradiance([&](double mu) { return std::pow(.9 * pane_transmittance(mu), panes); });
    // The tolerance is 1e-4, since the lamp's corners are floats, and the midpoint rule errs by 1 /
    // 24 steps^2.
    expect_irradiance_at("E40", b, exact, 1e-4, "lamp through " + std::to_string(panes) + " panes");
  }
}

// Coverage is decided once per path. A pane of coverage .4 lets .6 of the light through unchanged.
// If one path used two random keys, more light would pass.
TEST(ThinWalls, BlendedPane) {
  for (const bool point_light : {false, true}) {
    SceneBuilderForTests b = white_floor();
    MaterialDescription m = pane(.5f);
    m.alpha_mode = AlphaMode::kBlend;
    m.alpha = .4f;
    b.add_floor(5, .6f, b.add_material(m));
    const auto transmittance = [](double mu) { return .6 + .4 * .5 * pane_transmittance(mu); };
    if (point_light) {
      b.add_point_light({1.3, 2, .1}, Rgb(9.0f));
      const double mu = 2 / std::sqrt(5.0);
      expect_irradiance_at("E40", b, 9 * mu / 5 * transmittance(mu), 1e-5,
                           "point light through a blended pane");
    } else {
      add_lamp(b);
      expect_irradiance_at("E40", b, lamp_irradiance(transmittance), 1e-4,
                           "lamp through a blended pane");
    }
  }
}

// A blended card blocks light where it is present, in a scene with a pane elsewhere.
TEST(ThinWalls, BlendedCardBesideAPane) {
  SceneBuilderForTests b = white_floor();
  MaterialDescription m = two_sided(lambert(Rgb(.5f)));
  m.alpha_mode = AlphaMode::kBlend;
  m.alpha = .75f;
  b.add_floor(5, .6f, b.add_material(m));
  b.add_floor(1, -3, b.add_material(pane()));
  b.add_point_light({1.3, 2, .1}, Rgb(9.0f));
  expect_irradiance_at("E40", b, .25 * 9 * (2 / std::sqrt(5.0)) / 5, 1e-5,
                       "point light through a blended card");
}

// ---- two estimators
// ------------------------------------------------------------------------------

// A room 2 wide, which is open towards +Z. The tests add panes and lamps.
struct Room {
  SceneBuilderForTests b;
  CameraDescription view = perspective({.2, 1.1, .8}, {-.1, .7, -1}, 70);

  explicit Room(const MaterialDescription& walls = lambert(Rgb(.6f))) {
    const int wall = b.add_material(two_sided(walls));
    b.add_floor(1, 0, wall);
    b.add_floor(1, 2, wall);
    b.add_quad({-1, 0, -1}, {1, 0, -1}, {1, 2, -1}, {-1, 2, -1}, wall);
    for (const float x : {-1.0f, 1.0f}) {
      b.add_quad({x, 0, -1}, {x, 0, 1}, {x, 2, 1}, {x, 2, -1}, wall);
    }
  }
  void close(const MaterialDescription& m, float z = 1) {
    b.add_quad({-1, 0, z}, {1, 0, z}, {1, 2, z}, {-1, 2, z}, b.add_material(m));
  }
  void add_lamp(MaterialDescription m = emitter(Rgb(3.0f)), float half = .8f) {
    b.add_quad({-half, 1.2f - half, 1.6f}, {-half, 1.2f + half, 1.6f}, {half, 1.2f + half, 1.6f},
               {half, 1.2f - half, 1.6f}, b.add_material(m));
  }
  void add_sky() {
    b.set_environment(patterned_sky(4.0f));
    b.description.environment->image = grey(*b.description.environment->image);
  }
  // The sky is grey, since mean_of reads one channel.
  static std::shared_ptr<const Image> grey(const Image& colours) {
    auto image = std::make_shared<Image>(colours);
    for (size_t i = 0; i < image->texels.size(); i += 12) {
      std::memcpy(&image->texels[i + 4], &image->texels[i], 4);
      std::memcpy(&image->texels[i + 8], &image->texels[i], 4);
    }
    return image;
  }
};

void expect_estimators_agree(const Room& room, const std::string& what, int max_depth = 6) {
  const auto scene = room.b.build();
  const auto measured = [&](const CaseName& name, int light_samples, uint32_t spp) {
    RenderSettings s;
    s.width = s.height = 24;
    s.max_depth = max_depth;
    s.light_samples = light_samples;
    s.spp = spp;
    s.seed = seed_of(name) + (light_samples == 0 ? 1 : 0);
    return std::pair(mean_of(*scene, room.view, s), replay(s));
  };
  const CaseName one{"E41", what}, three{"E41", what + ", three light samples"};
  const uint32_t spp = 256;
  const auto [alone, how] = measured(one, 0, spp);
  EXPECT_GT(alone.mean, 1e-3) << what;
  for (const auto& [name, light_samples, share] :
       {std::tuple(one, 1, 4u), std::tuple(three, 3, 8u)}) {
    const MeasuredMean both = measured(name, light_samples, spp / share).first;
    expect_case(
        name, {alone.mean, both.mean, std::hypot(both.standard_error, alone.standard_error), 1e-6},
        how);
  }
}

MaterialDescription changed(MaterialDescription m,
                            const std::function<void(MaterialDescription&)>& change) {
  change(m);
  return m;
}

TEST(ThinWalls, EstimatorsAgreeOnPanes) {
  using M = MaterialDescription;
  const std::pair<std::string, M> panes[] = {
      {"clear pane", pane()},
      {"tinted pane", pane(.5f)},
      {"pane of transmission .6", changed(pane(.9f), [](M& m) { m.transmission = .6f; })},
      {"pane of metalness .3", changed(pane(.9f), [](M& m) { m.metallic = .3f; })},
      {"pane of alpha .5", changed(pane(.7f),
                                   [](M& m) {
                                     m.alpha_mode = AlphaMode::kBlend;
                                     m.alpha = .5f;
                                   })},
      {"shining pane", changed(pane(.7f), [](M& m) { m.emission = Rgb(.3f); })},
      {"rough pane", changed(pane(.9f), [](M& m) { m.roughness = .4f; })},
  };
  for (const auto& [what, material] : panes) {
    for (const bool sky : {false, true}) {
      Room room;
      room.close(material);
      if (sky) {
        room.add_sky();
      } else {
        room.add_lamp();
      }
      expect_estimators_agree(room, what + (sky ? ", sky" : ", lamp"));
    }
  }
}

TEST(ThinWalls, EstimatorsAgreeAtEveryDepth) {
  for (int depth = 1; depth <= 5; ++depth) {
    Room room;
    room.close(changed(pane(.8f), [](MaterialDescription& m) { m.transmission = .8f; }));
    room.close(pane(), 1.2f);
    room.add_lamp();
    room.add_sky();
    expect_estimators_agree(room, "two panes, depth " + std::to_string(depth), depth);
  }
}

// Textures control a pane's transmission, its roughness, and a lamp's brightness.
TEST(ThinWalls, EstimatorsAgreeOnTextures) {
  const auto checkers = [](Room& room) {
    auto image = std::make_shared<Image>();
    image->width = image->height = 4;
    image->channels = 4;
    for (int i = 0; i < 16; ++i) {
      const bool on = ((i + i / 4) & 1) != 0;
      // Colours are grey. Green is roughness, blue is metalness, and red is transmission.
      for (int c = 0; c < 4; ++c) image->texels.push_back(std::byte(on || c == 3 ? 255 : 0));
    }
    room.b.description.images.push_back(image);
  };
  Room tint;
  checkers(tint);
  tint.close(changed(pane(), [](MaterialDescription& m) { m.base_color_texture.image = 0; }));
  tint.add_lamp();
  expect_estimators_agree(tint, "checkered pane");
  Room rough;
  checkers(rough);
  rough.close(changed(pane(), [](MaterialDescription& m) {
    m.roughness = .5f;
    m.metallic = .2f;
    m.metallic_roughness_texture.image = 0;
  }));
  rough.add_lamp();
  expect_estimators_agree(rough, "pane that is rough in places");
  Room lamp;
  checkers(lamp);
  lamp.close(pane());
  lamp.add_lamp(changed(emitter(Rgb(16.0f)), [](MaterialDescription& m) {
    m.emission_texture.image = 0;
    m.base_color_texture.image = 0;
  }));
  expect_estimators_agree(lamp, "checkered lamp behind a pane");
}

// The wall of a drinking glass is two panes. It encloses a ball or the lamp.
TEST(ThinWalls, EstimatorsAgreeOnDrinkingGlasses) {
  const auto put = [](Room& room, const Vec3d& at, float radius) {
    const int wall = room.b.add_material(pane(.95f));
    for (const float r : {radius, .9f * radius}) {
      room.b.place(room.b.add_mesh(SceneBuilderForTests::sphere(r, 8, wall, r < radius, true)),
                   translation(at.x, at.y, at.z));
    }
  };
  Room ball;
  put(ball, {0, .5, -.2}, .5f);
  ball.b.place(ball.b.add_mesh(
                   SceneBuilderForTests::sphere(.25f, 8, ball.b.add_material(lambert(Rgb(.8f))))),
               translation(0, .5, -.2));
  ball.add_lamp();
  ball.add_sky();
  expect_estimators_agree(ball, "ball in a drinking glass");
  Room lamp;
  put(lamp, {.3, .6, -.2}, .45f);
  lamp.b.place(lamp.b.add_mesh(
                   SceneBuilderForTests::sphere(.2f, 6, lamp.b.add_material(emitter(Rgb(4.0f))))),
               translation(.3, .6, -.2));
  expect_estimators_agree(lamp, "lamp in a drinking glass");
}

// The lamp's triangles are small enough to be sampled by area. The walls are glossy enough for both
// strategies to matter. The pdf must use the distance from the wall, not from the pane.
TEST(ThinWalls, EstimatorsAgreeOnSmallTriangles) {
  Room room(metal(Rgb(.8f), .35f));
  room.close(pane(.9f));
  MeshDescription lamp;
  lamp.name = "lamp";
  lamp.material = room.b.add_material(emitter(Rgb(3.0f)));
  constexpr uint32_t kCells = 40;
  for (uint32_t i = 0; i <= kCells; ++i) {
    for (uint32_t j = 0; j <= kCells; ++j) {
      lamp.positions.emplace_back(1.6f * (float(i) / kCells - .5f), .4f + 1.6f * float(j) / kCells,
                                  1.6f);
    }
  }
  for (uint32_t i = 0; i < kCells; ++i) {
    for (uint32_t j = 0; j < kCells; ++j) {
      const uint32_t a = i * (kCells + 1) + j, c = a + kCells + 1;
      lamp.triangles.push_back({a, a + 1, c});
      lamp.triangles.push_back({a + 1, c + 1, c});
    }
  }
  room.b.place(room.b.add_mesh(std::move(lamp)));
  expect_estimators_agree(room, "lamp of small triangles behind a pane");
}

// Tests a pane inside an absorbing solid, and a pane that scatters the light of its own lamp and is
// seen from outside.
TEST(ThinWalls, EstimatorsAgreeOnPanesElsewhere) {
  Room room;
  const int solid = room.b.add_material(changed(glass(1.0f, 0), [](MaterialDescription& m) {
    m.attenuation_color = Rgb(.5f);
    m.attenuation_distance = 2;
  }));
  room.b.add_quad({-9, -9, 2}, {9, -9, 2}, {9, 9, 2}, {-9, 9, 2}, solid);
  room.b.add_quad({-9, 9, -9}, {9, 9, -9}, {9, -9, -9}, {-9, -9, -9}, solid);
  room.view = perspective({.6, 1.1, 4}, {.3, .9, 0}, 30);
  room.close(pane(.9f));
  room.add_lamp();
  expect_estimators_agree(room, "pane in a solid");
  Room outside;
  outside.close(changed(pane(.9f), [](MaterialDescription& m) { m.transmission = .5f; }));
  outside.add_lamp();
  outside.view = perspective({1.5, 1.4, 3}, {0, .9, 0}, 45);
  expect_estimators_agree(outside, "pane of transmission .5 from outside");
}

// Light samples through the pane reduce noise, since BSDF samples hit the small lamp only by
// chance.
TEST(ThinWalls, TakeATwentiethOfTheVariance) {
  Room room;
  room.close(pane());
  room.add_lamp(emitter(Rgb(400.0f)), .05f);
  const auto scene = room.b.build();
  RenderSettings s;
  s.width = s.height = 24;
  s.max_depth = 6;
  s.spp = 256;
  const MeasuredMean both = mean_of(*scene, room.view, s);
  s.light_samples = 0;
  const MeasuredMean alone = mean_of(*scene, room.view, s);
  EXPECT_LT(20 * square(both.standard_error), square(alone.standard_error));
}

// A floor under a solid slab gets no light from a lamp above the slab, and all light samples of the
// floor are counted as blocked. Without solid glass nothing is counted as blocked.
TEST(SolidGlass, LightSamplesThatItBlocksAreCounted) {
  for (const bool solid : {true, false}) {
    SceneBuilderForTests b;
    b.add_box({-9, .5f, -9}, {9, .6f, 9}, b.add_material(glass(1.5f, 0, solid)));
    b.add_floor(5, 0, b.add_material(lambert(Rgb(1.0f))));
    b.add_point_light({0, 2, 0}, Rgb(4.0f));
    RenderSettings s;
    s.spp = 64;
    const OpticsCounters counted =
        render(*b.build(), perspective({1, .3, 0}, {0, 0, 0}, 20), s).counters.optics;
    EXPECT_EQ(counted.point_light_samples > 100u, solid);
    EXPECT_EQ(counted.blocked_fraction(), solid ? 1.0 : 0.0);
  }
}

// An opaque lid blocks the light samples here, not the glass.
TEST(SolidGlass, WhatOtherThingsBlockIsNotCounted) {
  SceneBuilderForTests b;
  b.add_box({-9, .5f, -9}, {9, .6f, 9}, b.add_material(glass(1.5f, 0)));
  const int chalk = b.add_material(lambert(Rgb(1.0f)));
  b.add_floor(5, 0, chalk);
  b.add_box({-9, 1, -9}, {9, 1.1f, 9}, chalk);
  b.add_point_light({0, 2, 0}, Rgb(4.0f));
  const OpticsCounters counted =
      render(*b.build(), perspective({1, .3, 0}, {0, 0, 0}, 20), RenderSettings()).counters.optics;
  EXPECT_GT(counted.point_light_samples, 0u);
  EXPECT_EQ(counted.blocked_by_glass, 0u);
}

}  // namespace
}  // namespace emberline
