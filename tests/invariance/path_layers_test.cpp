// Layers by light path add up to the picture and do not change its bits. They are the same for
// every schedule, and light is in the documented layer.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "renderer/core/errors.h"
#include "renderer/drivers/driver_table.h"
#include "renderer/engine/render_job.h"
#include "renderer/film/film.h"
#include "renderer/film/light_group_values.h"
#include "support/busy_scene.h"
#include "support/grouped_scene.h"
#include "support/lit_scenes.h"
#include "support/render.h"
#include "support/schedules.h"

namespace emberline {
namespace {

using namespace test;

const std::vector<std::string> kLayers = {"direct",       "indirect",   "emission",
                                          "transmission", "reflection", "environment"};
constexpr const char* kAll = "direct,indirect,emission,transmission,reflection,environment";

RenderSettings settings(const char* layers = kAll) {
  RenderSettings s;
  s.width = 33;
  s.height = 25;
  s.spp = 16;
  s.max_depth = 6;
  s.aovs = layers;
  return s;
}

Rgb layer_at(const RenderedImage& image, const std::string& layer, int x, int y) {
  const auto first = std::ranges::find(image.channels, layer + ".R") - image.channels.begin();
  const float* p = image.pixel(x, y) + first;
  return {p[0], p[1], p[2]};
}

Rgb mean_of(const RenderedImage& image, const std::string& layer) {
  Rgb sum(0.0f);
  for (int y = image.crop.y0; y < image.crop.y1; ++y) {
    for (int x = image.crop.x0; x < image.crop.x1; ++x) sum += layer_at(image, layer, x, y);
  }
  return sum * (1.0f / float(image.crop.area()));
}

void expect_sums(const RenderedImage& image, const std::string& what) {
  for (int y = image.crop.y0; y < image.crop.y1; ++y) {
    for (int x = image.crop.x0; x < image.crop.x1; ++x) {
      Rgb sum(0.0f), size(0.0f);
      for (const std::string& layer : kLayers) {
        const Rgb value = layer_at(image, layer, x, y);
        sum += value;
        for (int c = 0; c < 3; ++c) size[c] += std::abs(value[c]);
      }
      for (int c = 0; c < 3; ++c) {
        ASSERT_NEAR(sum[c], image.rgb(x, y)[c], 1e-5f * size[c])
            << what << ", pixel " << x << "," << y << ", channel " << c;
      }
    }
  }
}

// Expects that `with` has all channels of `without`, with equal bits.
void expect_same_channels(const RenderedImage& with, const RenderedImage& without,
                          const std::string& what) {
  for (size_t c = 0; c < without.channels.size(); ++c) {
    const auto at =
        size_t(std::ranges::find(with.channels, without.channels[c]) - with.channels.begin());
    ASSERT_LT(at, with.channels.size());
    for (size_t i = 0; i < size_t(without.crop.area()); ++i) {
      ASSERT_EQ(with.values[i * with.channels.size() + at],
                without.values[i * without.channels.size() + c])
          << what << ", " << without.channels[c] << ", pixel " << i;
    }
  }
}

struct Case {
  const char* name;
  std::unique_ptr<Scene> (*scene)();
  CameraDescription (*view)();
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

std::unique_ptr<Scene> lit() {
  SceneBuilderForTests b;
  b.description = lit_scene();
  return b.build();
}
std::unique_ptr<Scene> glazed() {
  SceneBuilderForTests b;
  b.description = glazed_scene();
  return b.build();
}
// A scene with a coat, sheen, an anisotropic highlight, and a translucent surface.
std::unique_ptr<Scene> layered() {
  SceneBuilderForTests b;
  b.description = lit_scene();
  MaterialDescription coated = b.description.materials[kMatt];
  coated.clearcoat = 0.8f;
  coated.specular = 1.0f;
  coated.sheen_color = Rgb(0.5f, 0.2f, 0.4f);
  coated.anisotropy = 0.6f;
  coated.roughness = 0.5f;
  b.description.materials[kMatt] = coated;
  b.description.materials[kRed].diffuse_transmission = 0.4f;
  b.description.materials[kRed].double_sided = true;
  return b.build();
}

class PathLayersOf : public testing::TestWithParam<Case> {
 protected:
  const std::unique_ptr<Scene> scene_ = GetParam().scene();
  RenderedImage image(const RenderSettings& s) const {
    return render(*scene_, GetParam().view(), s);
  }
};

TEST_P(PathLayersOf, AddUpAndChangeNoBit) {
  for (const char* filter : {"box", "mitchell"}) {
    for (const bool transparent : {false, true}) {
      for (const bool clamped : {false, true}) {
        RenderSettings s = settings();
        s.spp = 20;  // one batch and part of another
        s.filter = filter;
        s.transparent = transparent;
        if (clamped) s.clamp_indirect = 0.05f;
        s.light_samples = transparent ? 3 : 1;
        const std::string what = fmt::format("{}, {}, {}", filter, transparent, clamped);
        const RenderedImage first = image(s);
        expect_sums(first, what);
        RenderSettings plain = s;
        plain.aovs = "";
        const RenderedImage without = image(plain);
        expect_same_channels(first, without, what);
        EXPECT_EQ(first.counters.rays.total(), without.counters.rays.total());
      }
    }
  }
}

TEST_P(PathLayersOf, DoNotDependOnTheDriver) {
  expect_same_bits_with_every_driver(settings(), {5, 3, 20, 17},
                                     [&](const RenderSettings& s) { return image(s); });
}

TEST_P(PathLayersOf, AddUpWhereSamplesAreAdaptive) {
  RenderSettings s = settings();
  s.driver = "adaptive";
  s.streams = StreamCount::kTwo;
  s.adaptive.budget = 40;
  expect_sums(image(s), "adaptive");
  s.adaptive.unbiased = true;
  expect_sums(image(s), "unbiased");
}

TEST_P(PathLayersOf, SubsetEqualsTheSameLayersOfAll) {
  const RenderedImage all = image(settings());
  expect_same_channels(all, image(settings("environment,reflection")), "two of them");
  EXPECT_EQ(image(settings("reflection,environment,reflection")).channels.size(), 5u + 6);
}

INSTANTIATE_TEST_SUITE_P(Scenes, PathLayersOf,
                         testing::Values(Case{"matt", lit, lit_view},
                                         Case{"glazed", glazed, lit_view},
                                         Case{"layered", layered, lit_view},
                                         Case{"busy", busy_scene, busy_view}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(PathLayers, GoWithLightGroups) {
  const GroupedScene lit(glazed_scene());
  const RenderedImage both = render(lit.scene.scene(), lit_view(), settings(), &lit.groups);
  expect_sums(both, "with groups");
  expect_same_bits(both, render(lit.scene.scene(), lit_view(), settings()), "without groups");
  EXPECT_EQ(both.lights, render(lit.scene.scene(), lit_view(), settings(""), &lit.groups).lights);
}

// Renders a floor of `material` from above, under a sky of radiance 1.
RenderedImage of_floor(const MaterialDescription& material, int max_depth) {
  SceneBuilderForTests b;
  b.add_floor(100, 0, b.add_material(material));
  b.set_environment(Rgb(1.0f));
  RenderSettings s = settings();
  s.max_depth = max_depth;
  s.spp = 64;
  return render(*b.build(), orthographic({0, 3, 0}, {0, 0, 1e-9}, 1.0), s);
}

void expect_only(const RenderedImage& image, const std::string& layer, float value,
                 float tolerance) {
  for (const std::string& name : kLayers) {
    const Rgb mean = mean_of(image, name);
    EXPECT_NEAR(mean.y, name == layer ? value : 0.0f, name == layer ? tolerance : 0.0f) << name;
  }
}

// The expected values are closed forms, since a white furnace shows the albedo.
TEST(PathLayers, OfOneSurface) {
  expect_only(of_floor(lambert(Rgb(0.6f)), 1), "direct", 0.6f, 0.006f);
  expect_only(of_floor(lambert(Rgb(0.6f)), 8), "direct", 0.6f, 0.006f);
  expect_only(of_floor(metal(Rgb(0.7f), 0.0f), 8), "reflection", 0.7f, 1e-5f);
  expect_only(of_floor(metal(Rgb(1.0f), 0.6f), 8), "reflection", 1.0f, 0.01f);
  expect_only(of_floor(emitter(Rgb(3.0f)), 0), "emission", 3.0f, 1e-5f);
  MaterialDescription unlit = lambert(Rgb(0.3f));
  unlit.unlit = true;
  expect_only(of_floor(unlit, 8), "emission", 0.3f, 1e-5f);
  // A pane of index 1.5 reflects 0.04 at normal incidence.
  const RenderedImage pane = of_floor(glass(1.5f, 0.0f, false), 8);
  EXPECT_NEAR(mean_of(pane, "transmission").y + mean_of(pane, "reflection").y, 1.0f, 1e-4f);
  EXPECT_GT(mean_of(pane, "reflection").y, 0.02f);
  EXPECT_LT(mean_of(pane, "reflection").y, 0.1f);
  EXPECT_EQ(mean_of(pane, "environment").y, 0.0f);
}

TEST(PathLayers, OfNoSurfaceIsTheEnvironment) {
  SceneBuilderForTests b;
  b.set_environment(Rgb(0.5f));
  b.add_floor(1, -100, b.add_material(lambert(Rgb(0.5f))));
  const RenderedImage image =
      render(*b.build(), perspective({0, 0, 0}, {0, 1, 0.01}, 40), settings());
  expect_only(image, "environment", 0.5f, 1e-6f);
}

// A dielectric's highlight does not depend on the base colour, and the diffuse part is proportional
// to that colour. Standard errors are about 0.001.
TEST(PathLayers, SeparateAHighlightFromTheColourBelow) {
  MaterialDescription white = lambert(Rgb(0.8f)), grey = lambert(Rgb(0.2f));
  white.specular = grey.specular = 1.0f;
  white.roughness = grey.roughness = 0.4f;
  const RenderedImage a = of_floor(white, 1), b = of_floor(grey, 1);
  EXPECT_GT(mean_of(a, "reflection").y, 0.03f);
  EXPECT_NEAR(mean_of(a, "reflection").y, mean_of(b, "reflection").y, 0.002f);
  EXPECT_NEAR(mean_of(a, "direct").y, 4 * mean_of(b, "direct").y, 0.01f);
}

// In a closed emissive sphere of albedo a, the radiance is 1 + a + a^2 ..., with a term for each
// number of reflections. The first term is emission, the second is direct, and the rest is
// indirect.
TEST(PathLayers, CountReflections) {
  SceneBuilderForTests b;
  MaterialDescription wall = lambert(Rgb(0.5f));
  wall.emission = Rgb(1.0f);
  b.place(b.add_mesh(SceneBuilderForTests::sphere(1.0f, 24, b.add_material(wall), true)),
          translation(0, 0, 0));
  RenderSettings s = settings();
  s.spp = 256;
  s.max_depth = 3;
  s.show_backfaces = true;
  const RenderedImage image = render(*b.build(), perspective({0, 0, 0}, {0, 0, 1}, 60), s);
  EXPECT_NEAR(mean_of(image, "emission").y, 1.0f, 1e-5f);
  EXPECT_NEAR(mean_of(image, "direct").y, 0.5f, 0.005f);
  EXPECT_NEAR(mean_of(image, "indirect").y, 0.25f + 0.125f, 0.005f);
  EXPECT_EQ(mean_of(image, "reflection").y, 0.0f);
}

// Checks every picture of a running frame. The layers are as complete as the picture.
class ObserverSink final : public RenderSink {
 public:
  explicit ObserverSink(const Rect& crop)
      : all_(std::vector<Rgb>(kPathLayers, Rgb(1.0f)), LightMix::Source::kPaths),
        plain_(4 * size_t(crop.area())),
        sum_(plain_) {}
  void tile_finished(const FilmTile&) override {}
  void picture_changed(const JobProgress& progress, const LivePicture& picture) override {
    ++pictures;
    picture.resolve(plain_);
    picture.resolve(sum_, &all_);
    for (size_t i = 0; i < plain_.size(); ++i) {
      ASSERT_NEAR(sum_[i], plain_[i], 1e-5f * plain_[i] + 1e-7f)
          << i << " at " << progress.completion;
    }
  }
  int pictures = 0;

 private:
  const LightMix all_;
  std::vector<float> plain_, sum_;
};

TEST(PathLayers, AddUpInIncompletePictures) {
  const std::unique_ptr<Scene> scene = glazed();
  RenderSettings s = settings();
  const Camera camera(lit_view(), s.width, s.height, scene->origin(), scene->scale());
  s.crop = {3, 2, s.width, s.height};
  s.spp = 4;
  const RenderPlan plan = plan_of(s);
  const Frame frame = plan.frame(*scene, camera);
  for (const char* name : {"bisection", "adaptive"}) {
    for (const Reconstruction reconstruction :
         {Reconstruction::kDuplicate, Reconstruction::kLinear}) {
      DriverSettings how;
      how.reconstruction = reconstruction;
      how.adaptive.budget = 4;
      ObserverSink observer(plan.crop);
      RenderJob(frame, driver_factory(name, how)).render(observer, {});
      EXPECT_GE(observer.pictures, 5) << name;
    }
  }
}

// A film can save, load and add its layers.
TEST(PathLayers, OfAFilm) {
  const AovSet aovs = AovSet::parse("indirect,direct");
  const PathLayers layers(aovs);
  EXPECT_EQ(layers.index_of(PathLayer::kIndirect), 1u);
  LightGroupValues values(layers.size());
  values.add(0, layers.index_of(PathLayer::kIndirect), Rgb(2.0f), Rgb(1, 2, 3));
  values.add(0, layers.index_of(PathLayer::kReflection), Rgb(1.0f), Rgb(9.0f));  // not requested
  FilmTile film(aovs), other(aovs), read(aovs);
  for (FilmTile* tile : {&film, &other, &read}) tile->reset({0, 0, 2, 1});
  const SampleValue lit{Rgb(2, 4, 6), 1.0f, {}, {}}, black{Rgb(0.0f), 1.0f, {}, {}};
  film.add(0, 0, {.value = lit, .layers = &values});
  std::vector<std::byte> state;
  Archive saving(state);
  film.archive(saving);
  Archive loading{std::span<const std::byte>(state)};
  read.archive(loading);
  loading.end();
  values.clear(0);
  other.add(0, 0, {.value = black, .layers = &values});
  read.add_film(other);
  std::vector<float> pixels;
  read.resolve(pixels);
  EXPECT_EQ(pixels, (std::vector<float>{1, 2, 3, 1, 2, 0, 0, 0, 1, 2, 3,  //
                                        0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}));
  // Each of the two pixels takes 24 bytes for each layer, and 24 for the sample count.
  FilmTile without{AovSet()};
  without.reset({0, 0, 2, 1});
  EXPECT_EQ(film.bytes(), without.bytes() + 2 * 72 + 4);
}

TEST(PathLayers, RequireAPathIntegrator) {
  RenderSettings s = settings();
  s.integrator = "ambient_occlusion";
  EXPECT_THROW(plan_of(s), UsageError);
  s.integrator = "direct";
  const std::unique_ptr<Scene> scene = lit();
  const RenderedImage image = render(*scene, lit_view(), s);
  expect_sums(image, "direct");
  EXPECT_EQ(mean_of(image, "indirect"), Rgb(0.0f));
}

}  // namespace
}  // namespace emberline
