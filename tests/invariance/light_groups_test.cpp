// Light groups add up to the picture and do not change its bits. Each group equals the picture lit
// by its light alone. Mixing the groups equals rendering with edited lights.
//
// The statistical tests have fixed seeds, so --gtest_filter=NAME replays a test exactly.
#include <gtest/gtest.h>

#include "renderer/drivers/driver_table.h"
#include "renderer/engine/render_job.h"
#include "renderer/film/film.h"
#include "renderer/scene/light_groups.h"
#include "support/busy_scene.h"
#include "support/edited_scene.h"
#include "support/grouped_scene.h"
#include "support/lit_scenes.h"
#include "support/long_tests.h"
#include "support/render.h"

namespace emberline {
namespace {

using namespace test;

RenderSettings settings(int max_depth = 5) {
  RenderSettings s;
  s.width = 41;
  s.height = 31;
  s.spp = 16;
  s.max_depth = max_depth;
  return s;
}

std::vector<std::string> names(const LightGroups& groups) {
  std::vector<std::string> list;
  for (const LightGroup& group : groups.list()) list.push_back(group.name);
  return list;
}

TEST(LightGroups, IncludeEveryLightThatShines) {
  const GroupedScene lit(lit_scene());
  EXPECT_EQ(names(lit.groups), (std::vector<std::string>{"key", "fill", "tube", "environment"}));
  EXPECT_EQ(lit.groups.list()[1].kind, EditedLight::kPunctual);
  EXPECT_EQ(lit.groups.list()[1].target.index, 2);
  EXPECT_EQ(lit.groups.list()[2].kind, EditedLight::kMaterial);
  EXPECT_EQ(lit.groups.list()[2].target.index, int(kTube));

  SceneEdits edits;
  light(edits, EditedLight::kPunctual, 0).on = false;
  material(edits, kRed).emission = Rgb(1.0f);
  const GroupedScene edited(lit_scene(), edits);
  EXPECT_EQ(names(edited.groups), (std::vector<std::string>{"fill", "red", "tube", "environment"}));
}

TEST(LightGroups, UnlitMaterialsShareTheLastGroup) {
  SceneDescription scene = lit_scene();
  scene.materials[kRed].unlit = true;
  const GroupedScene lit(scene);
  ASSERT_EQ(lit.groups.size(), 5);
  EXPECT_EQ(lit.groups.list().back().name, "others");
  EXPECT_FALSE(lit.groups.list().back().editable);
  EXPECT_EQ(lit.groups.of_material(kRed), 4u);
  SceneEdits edits;  // no effect on unlit materials
  light(edits, EditedLight::kMaterial, kRed).intensity = 3.0f;
  const std::optional<LightMix> mix = lit.groups.mix(edits);
  ASSERT_TRUE(mix);
  for (size_t g = 0; g < mix->size(); ++g) EXPECT_EQ(to_rgb(mix->data()[g]), Rgb(1.0f));
}

TEST(LightGroups, DarkSceneHasNone) {
  SceneDescription scene = lit_scene();
  scene.environment->strength = 0.0f;
  scene.lights.clear();
  scene.materials[kTube].emission = Rgb(0.0f);
  scene.may_be_dark = true;
  const GroupedScene dark(scene);
  EXPECT_EQ(dark.groups.size(), 0);
  RenderSettings s = settings();
  s.driver = "bisection";
  std::vector<float> rgba(4 * size_t(s.width * s.height), 1.0f);
  const RenderedImage image =
      render(dark.scene.scene(), lit_view(), s, &dark.groups, [&](const LivePicture* picture) {
        const std::optional<LightMix> mix = dark.groups.mix({});
        ASSERT_TRUE(mix);
        picture->resolve(rgba, &*mix);
      });
  for (size_t i = 0; i < rgba.size(); ++i) {
    EXPECT_EQ(rgba[i], i % 4 == 3 ? image.values[i / 4 * 5 + 3] : 0.0f);
  }
}

TEST(LightGroups, ExcessLightsShareTheLastGroup) {
  SceneDescription scene = lit_scene();
  for (int i = 0; i < 80; ++i) scene.lights.push_back(scene.lights[0]);
  const GroupedScene many(scene);
  ASSERT_EQ(many.groups.size(), kMaxLightGroups);
  EXPECT_FALSE(many.groups.list().back().editable);
  const auto others = uint32_t(kMaxLightGroups - 1);
  EXPECT_EQ(many.groups.of_point(62), 62u);  // first come lights 0 and 2, then the 80
  EXPECT_EQ(many.groups.of_point(63), others);
  EXPECT_EQ(many.groups.of_environment(), others);
  SceneEdits alone;
  light(alone, EditedLight::kPunctual, 20).intensity = 2.0f;
  EXPECT_TRUE(many.groups.mix(alone));
  light(alone, EditedLight::kPunctual, 82).intensity = 2.0f;
  EXPECT_FALSE(many.groups.mix(alone)) << "one of all others was edited";

  RenderSettings s = settings();
  s.spp = 1;
  const RenderedImage image = render(many.scene.scene(), lit_view(), s, &many.groups);
  Rgb sum(0.0f);
  for (int g = 0; g < image.light_groups; ++g) sum += image.light(600, g);
  EXPECT_NEAR(sum.x, rgb_of(image)[600].x, 1e-5f * sum.x);
}

struct Case {
  const char* name;
  SceneDescription (*scene)();
  CameraDescription (*view)();
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class Groups : public testing::TestWithParam<Case> {
 protected:
  const GroupedScene lit_{GetParam().scene()};
  RenderedImage image(const RenderSettings& s) const {
    return render(lit_.scene.scene(), GetParam().view(), s, &lit_.groups);
  }
  RenderedImage image_without(const RenderSettings& s) const {
    return render(lit_.scene.scene(), GetParam().view(), s);
  }
};

// Laws 2 and 3: light groups do not change the picture, and every driver gives the same groups. A
// short run takes every fifth combination, which still includes each value of each list.
TEST_P(Groups, ChangeNoBitOfThePicture) {
  int combination = 0;
  for (const char* integrator : {"path", "direct"}) {
    for (const char* filter : {"box", "mitchell"}) {
      for (const bool transparent : {false, true}) {
        RenderSettings s = settings();
        s.spp = 20;  // one batch and part of another
        s.integrator = integrator;
        s.filter = filter;
        s.transparent = transparent;
        s.threads = 1;
        s.aovs = "variance,albedo,N,Z,id";
        const RenderedImage expected = image_without(s);
        const RenderedImage first = image(s);
        expect_same_bits(first, expected, "with groups");
        EXPECT_EQ(first.counters.rays.total(), expected.counters.rays.total());
        for (const char* driver : {"bucket", "bisection", "adaptive"}) {
          for (const int threads : {1, 2, 5}) {
            if (combination++ % long_or_short(1, 5) != 0) continue;
            s.driver = driver;
            s.threads = threads;
            s.bucket_size = threads == 5 ? 7 : 16;
            s.adaptive.budget = s.adaptive.min_samples = s.adaptive.max_samples = s.spp;
            const RenderedImage other = image(s);
            const std::string what = std::string(integrator) + ", " + filter + ", " + driver +
                                     ", " + std::to_string(threads) + " threads";
            // The adaptive driver estimates the variance from sample halves.
            const bool adaptive = s.driver == "adaptive";
            expect_same_bits(other, adaptive ? image_without(s) : expected, what);
            EXPECT_EQ(other.lights, first.lights) << what;
          }
        }
      }
    }
  }
}

TEST_P(Groups, AddUpToThePicture) {
  for (const char* filter : {"box", "mitchell"}) {
    RenderSettings s = settings();
    s.filter = filter;
    s.light_samples = s.filter == "box" ? 3 : 1;
    const RenderedImage frame = image(s);
    const std::vector<Rgb> whole = rgb_of(frame);
    for (size_t i = 0; i < whole.size(); ++i) {
      Rgb sum(0.0f), size(0.0f);
      for (int g = 0; g < frame.light_groups; ++g) {
        sum += frame.light(i, g);
        for (int c = 0; c < 3; ++c) size[c] += std::abs(frame.light(i, g)[c]);
      }
      for (int c = 0; c < 3; ++c) {
        ASSERT_NEAR(sum[c], whole[i][c], 1e-5f * size[c]) << filter << ", pixel " << i;
      }
    }
  }
}

// There are 4 groups x 4 quarters x 3 channels. Each deviation must be below 4 standard errors,
// which raises a false alarm for one of 300 seeds.
TEST_P(Groups, EqualRendersOfEachLightAlone) {
  const RenderSettings s = settings();
  const RenderedImage together = image(s);
  for (int g = 0; g < lit_.groups.size(); ++g) {
    const LightGroup& group = lit_.groups.list()[size_t(g)];
    EditableScene alone(GetParam().scene());
    alone.set(all_off_except(lit_.groups, g));
    RenderSettings other = s;
    other.seed = 77;
    const std::vector<Rgb> expected = rgb_of(render(alone.scene(), GetParam().view(), other));
    EXPECT_GT(expected[600].x + expected[900].x, 0.0f) << group.name << " gives nothing";
    for (const double z : deviations(light_of(together, g), expected, s.width)) {
      EXPECT_LT(std::abs(z), 4.0) << group.name;
    }
  }
}

// There are 4 quarters x 3 channels x 2 drivers. Each deviation must be below 4 standard errors,
// which raises a false alarm for one of 600 seeds.
TEST_P(Groups, MixedAreAFrameOfEditedLights) {
  SceneEdits edits;
  light(edits, EditedLight::kPunctual, 0).color = {0.2f, 1.0f, 3.0f};
  edits.lights.back().intensity = 0.7f;
  light(edits, EditedLight::kPunctual, 2).on = false;
  light(edits, EditedLight::kMaterial, kTube).intensity = 2.5f;
  light(edits, EditedLight::kEnvironment, -1).color = {0.5f, 0.0f, 1.5f};
  edits.environment.strength = 0.6f;
  const std::optional<LightMix> mix = lit_.groups.mix(edits);
  ASSERT_TRUE(mix);
  EditableScene fresh(GetParam().scene());
  fresh.set(edits);
  for (const char* driver : {"bisection", "adaptive"}) {
    RenderSettings s = settings();
    s.driver = driver;
    s.adaptive.budget = s.adaptive.min_samples = s.adaptive.max_samples = s.spp;
    std::vector<float> rgba(4 * size_t(s.width * s.height));
    const RenderedImage unmixed =
        render(lit_.scene.scene(), GetParam().view(), s, &lit_.groups,
               [&](const LivePicture* picture) { picture->resolve(rgba, &*mix); });
    RenderSettings other = s;
    other.seed = 78;
    const RenderedImage expected = render(fresh.scene(), GetParam().view(), other);
    for (const double z : deviations(rgb_of(rgba), rgb_of(expected), s.width)) {
      EXPECT_LT(std::abs(z), 4.0) << driver;
    }
    for (size_t i = 0; i < rgba.size() / 4; ++i) {
      ASSERT_NEAR(rgba[4 * i + 3], unmixed.values[5 * i + 3], 1e-5) << "alpha";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, Groups,
                         testing::Values(Case{"matt", lit_scene, lit_view},
                                         Case{"glazed", glazed_scene, lit_view}),
                         [](const auto& test) { return std::string(test.param.name); });

// The scene has emissive textures, instances, coverage, and a lamp flush in another surface.
TEST(LightGroups, OfASceneWithEverything) {
  SceneDescription scene = edited_scene();
  add_variants(scene);
  SceneEdits plain, swapped;
  swapped.variant = EditTarget{"", kSwappedLamps, ""};
  for (const SceneEdits& edits : {plain, swapped}) {
    const GroupedScene lit(scene, edits);
    EXPECT_EQ(names(lit.groups), (std::vector<std::string>{"spot", "spot", "lamp", "environment"}));
    EXPECT_FALSE(lit.groups.mix(edits.variant ? plain : swapped)) << "another variant";
    const RenderSettings s = settings();
    const RenderedImage frame = render(lit.scene.scene(), edited_view(), s, &lit.groups);
    expect_same_bits(frame, render(lit.scene.scene(), edited_view(), s), "with groups");
    const std::vector<Rgb> whole = rgb_of(frame);
    for (size_t i = 0; i < whole.size(); ++i) {
      Rgb sum(0.0f);
      for (int g = 0; g < frame.light_groups; ++g) sum += frame.light(i, g);
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(sum[c], whole[i][c], 1e-5f * sum[c]) << i;
    }
  }
}

// A material variant's lamp is a light only while that variant is selected.
TEST(LightGroups, FollowTheVariant) {
  SceneDescription scene = lit_scene();
  scene.variants = {{"lit"}};
  scene.variants_read = true;
  scene.meshes[1].variant_materials = {{0, 3}};  // the red quad gets the stored material
  SceneEdits lit;
  lit.variant = EditTarget{"", 0, ""};
  const GroupedScene worn(scene, lit);
  ASSERT_EQ(worn.groups.size(), 5);
  EXPECT_EQ(worn.groups.list()[3].name, "stored away");
  EXPECT_EQ(worn.groups.of_material(3), 3u);
  SceneEdits brighter = lit;
  light(brighter, EditedLight::kMaterial, 3).intensity = 2.0f;
  const std::optional<LightMix> mix = worn.groups.mix(brighter);
  ASSERT_TRUE(mix);
  EXPECT_EQ(to_rgb(mix->data()[3]), Rgb(2.0f));
}

// A point light of intensity I is at height h over a matt plane of albedo a. Seen from above, at
// distance r from the lamp's foot, the radiance is a / pi x I h / (h^2 + r^2)^(3/2). Each lamp has
// its own group. There are 2 lamps x 12 deviations of at most 4 standard errors, which raises a
// false alarm for one of 600 seeds.
TEST(LightGroups, AreTheClosedFormOverAMattPlane) {
  SceneBuilderForTests b;
  b.add_floor(2, 0, b.add_material(lambert(Rgb(0.6f, 0.5f, 0.4f))));
  const Vec3d places[] = {{0.3, 1.0, 0.2}, {-0.5, 1.5, -0.4}};
  const Rgb intensities[] = {{3, 2, 1}, {1, 4, 9}};
  for (int i = 0; i < 2; ++i) b.add_point_light(places[i], intensities[i]);
  const GroupedScene lit(b.description);
  RenderSettings s = settings(1);
  s.width = s.height = 32;
  s.spp = 64;
  const RenderedImage frame =
      render(lit.scene.scene(), orthographic({0, 5, 0}, {0, 0, 1e-9}, 1.0), s, &lit.groups);
  ASSERT_EQ(frame.light_groups, 2);
  // The camera's rays give each pixel's point on the plane.
  const Camera camera(orthographic({0, 5, 0}, {0, 0, 1e-9}, 1.0), s.width, s.height,
                      lit.scene.scene().origin(), lit.scene.scene().scale());
  for (int g = 0; g < 2; ++g) {
    std::vector<Rgb> expected;
    for (int i = 0; i < s.width * s.height; ++i) {
      const Vec2f film(float(i % s.width) + 0.5f, float(i / s.width) + 0.5f);
      Ray ray;
      camera.rays({&film, 1}, &ray);
      const Vec3d foot = to_double(ray.origin) -
                         to_double(ray.direction) * (double(ray.origin.y) / ray.direction.y);
      const Vec3d to_light = places[g] - foot;
      const double form = to_light.y / std::pow(to_light.length2(), 1.5) / kPiD;
      expected.push_back(Rgb(0.6f, 0.5f, 0.4f) * intensities[g] * float(form));
    }
    for (const double z : deviations(light_of(frame, g), expected, s.width)) {
      EXPECT_LT(std::abs(z), 4.0) << "lamp " << g;
    }
    // The test is sharp because the noise itself is small.
    for (size_t i = 0; i < expected.size(); i += 97) {
      EXPECT_NEAR(frame.light(i, g).y, expected[i].y, 0.3f * expected[i].y);
    }
  }
}

TEST(LightGroups, DetectEditsThatNeedNewRays) {
  SceneEdits baseline;
  light(baseline, EditedLight::kPunctual, 0).on = false;
  light(baseline, EditedLight::kPunctual, 2).color = {1, 0, 1};
  const GroupedScene lit(lit_scene(), baseline);
  const auto mixes = [&](auto edit) {
    SceneEdits edits = baseline;
    edit(edits);
    return lit.groups.mix(edits).has_value();
  };
  EXPECT_TRUE(mixes([](SceneEdits&) {}));
  EXPECT_TRUE(mixes([](SceneEdits& e) { e.lights[1].intensity = 7.0f; }));
  EXPECT_TRUE(mixes([](SceneEdits& e) { e.lights[1].on = false; }));
  EXPECT_TRUE(mixes([](SceneEdits& e) { e.lights[0].color = Rgb(0.1f); })) << "it is off";
  EXPECT_TRUE(mixes([](SceneEdits& e) { e.environment.strength = 2.0f; }));
  EXPECT_TRUE(mixes([](SceneEdits& e) { e.environment.strength = 0.0f; }));
  EXPECT_TRUE(mixes([](SceneEdits& e) { light(e, EditedLight::kMaterial, kRed).intensity = 9; }))
      << "it does not emit";
  EXPECT_TRUE(mixes([](SceneEdits& e) { light(e, EditedLight::kPunctual, 1).intensity = 9; }))
      << "it is dark in the file";
  EXPECT_TRUE(mixes([](SceneEdits& e) { light(e, EditedLight::kMaterial, 3).intensity = 9; }))
      << "nothing wears it";
  EXPECT_FALSE(mixes([](SceneEdits& e) { e.lights[0].on = true; }));
  EXPECT_FALSE(mixes([](SceneEdits& e) { e.lights[1].color = Rgb(1.0f); })) << "green was 0";
  EXPECT_FALSE(mixes([](SceneEdits& e) { e.environment.rotation_degrees = 1.0f; }));
  EXPECT_FALSE(mixes([](SceneEdits& e) { e.environment.image = patterned_sky(2.0f); }));
  EXPECT_FALSE(mixes([](SceneEdits& e) { material(e, kRed).roughness = 0.2f; }));
  EXPECT_FALSE(mixes([](SceneEdits& e) { material(e, kTube).emission = Rgb(2.0f); }));
  EXPECT_FALSE(mixes([](SceneEdits& e) { e.camera.fov_y_degrees = 20.0; }));
  EXPECT_THROW(mixes([](SceneEdits& e) { light(e, EditedLight::kPunctual, 99); }), std::exception);
}

TEST(LightGroups, WeightsAreRatios) {
  SceneEdits baseline;
  light(baseline, EditedLight::kPunctual, 2).color = {1, 2, 4};
  baseline.environment.strength = 2.0f;
  const GroupedScene lit(lit_scene(), baseline);
  SceneEdits edits = baseline;
  edits.lights[0].intensity = 3.0f;
  edits.lights[0].color = {1, 1, 0};
  edits.environment.strength = 0.5f;
  light(edits, EditedLight::kEnvironment, -1).color = {1, 2, 3};
  const std::optional<LightMix> mix = lit.groups.mix(edits);
  ASSERT_TRUE(mix);
  EXPECT_EQ(to_rgb(mix->data()[0]), Rgb(1.0f));              // key
  EXPECT_EQ(to_rgb(mix->data()[1]), Rgb(3.0f, 1.5f, 0.0f));  // fill
  EXPECT_EQ(to_rgb(mix->data()[2]), Rgb(1.0f));              // tube
  EXPECT_EQ(to_rgb(mix->data()[3]), Rgb(0.25f, 0.5f, 0.75f));
}

// A neutral baseline turns every light on, and the mix then shows the requested dimming.
TEST(LightGroups, NeutralBaselineRestoresAllLights) {
  SceneEdits dim;
  light(dim, EditedLight::kPunctual, 0).on = false;
  dim.lights.back().intensity = 0.3f;
  light(dim, EditedLight::kPunctual, 2).intensity = 0.0f;
  light(dim, EditedLight::kMaterial, kTube).color = {0, 0.5f, 0};
  light(dim, EditedLight::kEnvironment, -1).color = Rgb(0.0f);
  dim.environment.strength = 0.0f;
  const SceneEdits baseline = neutral_baseline(dim);
  EXPECT_TRUE(baseline.lights[0].on);
  EXPECT_EQ(baseline.lights[0].intensity, 0.3f);
  EXPECT_EQ(baseline.lights[2].color, Rgb(0.5f));
  const GroupedScene lit(lit_scene(), baseline);
  EXPECT_EQ(lit.groups.size(), 4);
  const std::optional<LightMix> dimmed = lit.groups.mix(dim);
  ASSERT_TRUE(dimmed);
  EXPECT_EQ(to_rgb(dimmed->data()[0]), Rgb(0.0f));
  EXPECT_EQ(to_rgb(dimmed->data()[1]), Rgb(0.0f));
  EXPECT_EQ(to_rgb(dimmed->data()[2]), Rgb(0.0f, 1.0f, 0.0f));
  EXPECT_EQ(to_rgb(dimmed->data()[3]), Rgb(0.0f));
  EXPECT_TRUE(lit.groups.mix({})) << "the file's own lights";
  EXPECT_EQ(neutral_baseline({}), SceneEdits{});
}

// Checks every picture of a running frame. With all weights 1 the mixed picture equals the unmixed
// one, and with all weights 2 it is twice as bright. It is as complete as the unmixed picture.
class ObserverSink final : public RenderSink {
 public:
  ObserverSink(int groups, const Rect& crop)
      : same_(std::vector<Rgb>(size_t(groups), Rgb(1.0f))),
        twice_(std::vector<Rgb>(size_t(groups), Rgb(2.0f))),
        plain_(4 * size_t(crop.area())),
        mixed_(plain_) {}
  void tile_finished(const FilmTile&) override {}
  void picture_changed(const JobProgress& progress, const LivePicture& picture) override {
    ++pictures;
    picture.resolve(plain_);
    picture.resolve(mixed_, &same_);
    expect_factor(1.0f, progress.completion);
    picture.resolve(mixed_, &twice_);
    expect_factor(2.0f, progress.completion);
  }
  int pictures = 0;

 private:
  void expect_factor(float factor, double completion) {
    for (size_t i = 0; i < plain_.size(); ++i) {
      const float expected = plain_[i] * (i % 4 == 3 ? 1.0f : factor);
      ASSERT_NEAR(mixed_[i], expected, 1e-5f * expected + 1e-7f) << i << " at " << completion;
    }
  }
  LightMix same_, twice_;
  std::vector<float> plain_, mixed_;
};

TEST(LightGroups, MixIncompletePictures) {
  const GroupedScene lit(lit_scene());
  RenderSettings s = settings();
  const Scene& scene = lit.scene.scene();
  const Camera camera(lit_view(), s.width, s.height, scene.origin(), scene.scale());
  s.crop = {3, 2, s.width, s.height};
  s.spp = 4;
  s.max_depth = 3;
  const RenderPlan plan = plan_of(s);
  const Frame frame = plan.frame(scene, camera, {.light_groups = &lit.groups});
  for (const char* name : {"bisection", "adaptive"}) {
    for (const Reconstruction reconstruction :
         {Reconstruction::kDuplicate, Reconstruction::kLinear}) {
      DriverSettings how;
      how.reconstruction = reconstruction;
      how.adaptive.budget = 4;
      ObserverSink observer(lit.groups.size(), plan.crop);
      RenderJob(frame, driver_factory(name, how)).render(observer, {});
      EXPECT_GE(observer.pictures, 5) << name;
    }
  }
}

}  // namespace
}  // namespace emberline
