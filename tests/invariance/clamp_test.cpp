// --clamp-indirect: the clamped picture and the removed light add up to the unclamped picture, for
// every driver and light group. Directly visible light and direct illumination of visible surfaces
// are not clamped.
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

#include "renderer/core/errors.h"
#include "support/busy_scene.h"
#include "support/glass_scenes.h"
#include "support/grouped_scene.h"
#include "support/render.h"

namespace emberline {
namespace {

using namespace test;

constexpr int kWidth = 24, kHeight = 18;

RenderSettings settings(std::optional<float> limit, int max_depth = 6) {
  RenderSettings s;
  s.width = kWidth;
  s.height = kHeight;
  s.spp = 16;
  s.max_depth = max_depth;
  s.clamp_indirect = limit;
  if (limit) s.aovs = "clamped";
  return s;
}

CameraDescription view() { return perspective({0.4, 2.0, 5.0}, {0, 0.5, 0}, 40); }

// Two lamps above a glass ball, a mirror ball, a rough metal ball and a floor.
SceneBuilderForTests sparkling() {
  SceneBuilderForTests b;
  b.add_floor(4, 0, b.add_material(lambert(Rgb(0.8f, 0.5f, 0.3f))));
  const auto ball = [&b](int material, const Vec3d& at, float radius) {
    b.place(b.add_mesh(SceneBuilderForTests::sphere(radius, 12, material)),
            translation(at.x, at.y, at.z));
  };
  ball(b.add_material(glass(1.5f, 0.0f)), {-0.8, 0.6, 0}, 0.5f);
  ball(b.add_material(metal(Rgb(0.9f), 0.0f)), {0.8, 0.6, 0}, 0.5f);
  ball(b.add_material(metal(Rgb(0.9f, 0.7f, 0.4f), 0.3f)), {0, 0.5, 1}, 0.3f);
  ball(b.add_material(emitter(Rgb(60.0f, 40.0f, 20.0f))), {-0.8, 2, 0}, 0.1f);
  ball(b.add_material(emitter(Rgb(10.0f, 20.0f, 60.0f))), {1, 2, 1}, 0.1f);
  b.set_environment(Rgb(0.1f));
  return b;
}

Rgb removed_at(const RenderedImage& image, int x, int y) {
  const auto first = std::ranges::find(image.channels, "clamped.R") - image.channels.begin();
  const float* p = image.pixel(x, y) + first;
  return {p[0], p[1], p[2]};
}

TEST(ClampIndirect, RemovedAndRemainingLightAddUpToThePicture) {
  GroupedScene lit(sparkling().description);
  const Scene& scene = lit.scene.scene();
  const RenderedImage without = render(scene, view(), settings({}), &lit.groups);
  const RenderedImage with = render(scene, view(), settings(0.5f), &lit.groups);
  Rgb removed(0.0f);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const Rgb left = with.rgb(x, y), lost = removed_at(with, x, y), all = without.rgb(x, y);
      Rgb lights(0.0f);
      for (int g = 0; g < with.light_groups; ++g) {
        lights += with.light(with.crop.index_of(x, y), g);
      }
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(left[c] + lost[c], all[c], 1e-5f * all[c]);
        EXPECT_NEAR(lights[c], left[c], 1e-5f * left[c]);
      }
      removed += lost;
    }
  }
  EXPECT_GT(max_component(removed), 1.0f);
  // The counter equals the mean of the layer, and the groups' shares add up to the counter.
  const ClampedLight& counted = with.counters.clamped;
  Rgb of_groups(0.0f);
  ASSERT_EQ(counted.groups(), size_t(lit.groups.size()));
  for (size_t g = 0; g < counted.groups(); ++g) {
    of_groups += counted.removed_of_group(g, with.counters.samples);
  }
  const Rgb mean = counted.removed(with.counters.samples);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(mean[c], removed[c] / (kWidth * kHeight), 1e-4f * mean[c]);
    EXPECT_NEAR(of_groups[c], mean[c], 1e-5f * mean[c]);
  }
  EXPECT_GT(counted.fraction(), 0.01);
  EXPECT_LT(counted.fraction(), 0.9);
}

TEST(ClampIndirect, DoesNotDependOnDriverOrThreads) {
  GroupedScene lit(sparkling().description);
  const RenderedImage one = render(lit.scene.scene(), view(), settings(0.5f), &lit.groups);
  for (const char* driver : {"bucket", "bisection"}) {
    for (const int threads : {1, 2, 5}) {
      RenderSettings s = settings(0.5f);
      s.driver = driver;
      s.threads = threads;
      const RenderedImage other = render(lit.scene.scene(), view(), s, &lit.groups);
      expect_same_bits(other, one, driver);
      EXPECT_EQ(other.counters.clamped.fraction(), one.counters.clamped.fraction());
      for (size_t g = 0; g < one.counters.clamped.groups(); ++g) {
        EXPECT_EQ(other.counters.clamped.removed_of_group(g, 1),
                  one.counters.clamped.removed_of_group(g, 1));
      }
    }
  }
}

// A saved state with a different limit or number of groups is rejected as damaged.
TEST(ClampIndirect, LoadsOnlyStateOfTheSameFrame) {
  const auto saved = [](const ClampedLight& light) {
    std::vector<std::byte> bytes;
    Archive saving(bytes);
    ClampedLight(light).archive(saving);
    saving.end();
    return bytes;
  };
  const auto load = [](const std::vector<std::byte>& bytes, ClampedLight into) {
    Archive loading{std::span<const std::byte>(bytes)};
    into.archive(loading);
    loading.end();
    return into;
  };
  ClampedLight light(0.5f, 3);
  light.add_removed(1, Rgb(1, 2, 3));
  const ClampedLight again = load(saved(light), {0.5f, 3});
  EXPECT_EQ(again.removed_of_group(1, 1), light.removed_of_group(1, 1));
  EXPECT_FALSE(load(saved({}), {}).clamps());
  for (const ClampedLight& other : {ClampedLight(), ClampedLight(0.5f, 0), ClampedLight(0.5f, 2),
                                    ClampedLight(0.5f, 64), ClampedLight(0.25f, 3)}) {
    EXPECT_THROW(load(saved(light), other), InputError);
    EXPECT_THROW(load(saved(other), {0.5f, 3}), InputError);
  }
}

// With a limit that nothing reaches, the bits equal those of a frame without a limit.
TEST(ClampIndirect, LightBelowTheLimitKeepsItsBits) {
  for (const auto& scene : {busy_scene(), sparkling().build()}) {
    const RenderedImage without = render(*scene, view(), settings({}));
    const RenderedImage with = render(*scene, view(), settings(1e8f));
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        ASSERT_EQ(with.rgb(x, y), without.rgb(x, y));
        ASSERT_EQ(removed_at(with, x, y), Rgb(0.0f));
      }
    }
    EXPECT_EQ(with.counters.clamped.fraction(), 0.0);
  }
}

// In these scenes a path scatters at one surface only. Clear panes, mirrors and glass do not count
// as bounces.
TEST(ClampIndirect, KeepsVisibleAndDirectLight) {
  const auto expect_left = [](const Scene& scene, int max_depth, const char* what) {
    const RenderedImage without = render(scene, view(), settings({}, max_depth));
    const RenderedImage with = render(scene, view(), settings(1e-6f, max_depth));
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        ASSERT_EQ(with.rgb(x, y), without.rgb(x, y)) << what;
        ASSERT_EQ(removed_at(with, x, y), Rgb(0.0f)) << what;
      }
    }
    EXPECT_GT(without.mean, 0.01) << what;
  };
  expect_left(*sparkling().build(), 1, "direct light");

  SceneBuilderForTests seen;
  const auto ball = [&seen](int material, const Vec3d& at) {
    seen.place(seen.add_mesh(SceneBuilderForTests::sphere(0.5f, 12, material)),
               translation(at.x, at.y, at.z));
  };
  ball(seen.add_material(glass(1.5f, 0.0f)), {-0.8, 0.6, 0});
  ball(seen.add_material(metal(Rgb(0.9f), 0.0f)), {0.8, 0.6, 0});
  ball(seen.add_material(emitter(Rgb(60.0f))), {0, 2, 0});
  seen.set_environment(Rgb(0.1f));
  expect_left(*seen.build(), 12, "seen in mirrors and glass");

  SceneBuilderForTests behind;
  behind.add_floor(4, 0, behind.add_material(lambert(Rgb(0.8f))));
  MaterialDescription pane = glass(1.5f, 0.0f, false);
  pane.base_color = Rgb(0.9f, 0.5f, 0.2f);
  behind.add_floor(4, 3, behind.add_material(pane), false);
  behind.add_floor(0.5f, 4, behind.add_material(emitter(Rgb(60.0f))), false);
  expect_left(*behind.build(), 1, "a lamp over a pane");
}

// Besides the direct light, each vertex after the first adds at most two contributions to a sample,
// and each of them is at most the limit.
TEST(ClampIndirect, NoSampleGetsMoreThanTheLimitAllows) {
  SceneBuilderForTests b;
  b.add_floor(4, 0, b.add_material(lambert(Rgb(0.8f, 0.5f, 0.3f))));
  b.place(b.add_mesh(SceneBuilderForTests::sphere(0.5f, 12, b.add_material(lambert(Rgb(0.9f))))),
          translation(0.3, 0.6, 0));
  b.place(b.add_mesh(SceneBuilderForTests::sphere(0.1f, 8, b.add_material(emitter(Rgb(90.0f))))),
          translation(0, 1.3, 0.3));
  b.add_point_light({1, 0.3, 0.5}, Rgb(3.0f));
  const auto scene = b.build();
  constexpr float kLimit = 0.05f;
  constexpr int kDepth = 4;
  RenderSettings direct = settings({}, 1), all = settings(kLimit, kDepth);
  direct.spp = all.spp = 1;
  float most = 0.0f, most_taken = 0.0f;
  for (uint32_t seed = 0; seed < 16; ++seed) {
    direct.seed = all.seed = seed;
    const RenderedImage seen = render(*scene, view(), direct);
    const RenderedImage more = render(*scene, view(), all);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        most = std::max(most, max_component(more.rgb(x, y) - seen.rgb(x, y)));
        most_taken = std::max(most_taken, max_component(removed_at(more, x, y)));
      }
    }
  }
  EXPECT_GT(most_taken, 1.0f);
  EXPECT_GT(most, 0.999f * kLimit);
  EXPECT_LE(most, 1.001f * 2 * (kDepth - 1) * kLimit);
}

TEST(ClampIndirect, RequiresAnIntegratorWithLights) {
  RenderSettings s = settings(1.0f);
  s.integrator = "normal";
  EXPECT_THROW(plan_of(s), UsageError);
  s = settings({});
  s.aovs = "clamped";
  EXPECT_THROW(plan_of(s), UsageError);
}

}  // namespace
}  // namespace emberline
