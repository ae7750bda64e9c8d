// The ray counters are exact: they equal the calls that arrive at Embree, except for camera rays
// that are known to hit nothing. The linker puts the functions below between the renderer and
// Embree (-Wl,--wrap).
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "renderer/engine/render_sink.h"
#include "renderer/engine/render_worker.h"
#include "renderer/film/film.h"
#include "renderer/scene/embree_api.h"
#include "renderer/scene/empty_pixels.h"
#include "support/busy_scene.h"
#include "support/edited_scene.h"
#include "support/glass_scenes.h"
#include "support/grouped_scene.h"
#include "support/render.h"

namespace {

std::atomic<uint64_t> intersections{0}, occlusions{0};

}  // namespace

extern "C" {
#if EMBERLINE_EMBREE_MAJOR >= 4
void __real_rtcIntersect1(RTCScene, RTCRayHit*, RTCIntersectArguments*);
void __real_rtcOccluded1(RTCScene, RTCRay*, RTCOccludedArguments*);
void __wrap_rtcIntersect1(RTCScene scene, RTCRayHit* ray, RTCIntersectArguments* arguments) {
  intersections++;
  __real_rtcIntersect1(scene, ray, arguments);
}
void __wrap_rtcOccluded1(RTCScene scene, RTCRay* ray, RTCOccludedArguments* arguments) {
  occlusions++;
  __real_rtcOccluded1(scene, ray, arguments);
}
#else
void __real_rtcIntersect1(RTCScene, RTCIntersectContext*, RTCRayHit*);
void __real_rtcOccluded1(RTCScene, RTCIntersectContext*, RTCRay*);
void __wrap_rtcIntersect1(RTCScene scene, RTCIntersectContext* context, RTCRayHit* ray) {
  intersections++;
  __real_rtcIntersect1(scene, context, ray);
}
void __wrap_rtcOccluded1(RTCScene scene, RTCIntersectContext* context, RTCRay* ray) {
  occlusions++;
  __real_rtcOccluded1(scene, context, ray);
}
#endif
}

namespace emberline {
namespace {

using namespace test;

RenderSettings settings_of(const std::string& driver) {
  RenderSettings s;
  s.driver = driver;
  s.width = 37;
  s.height = 29;
  s.crop = {2, 1, 35, 28};
  s.spp = 20;
  s.find_empty_pixels = false;  // it saves camera rays, but still counts them: see EmptyPixelCounts
  s.environment_sampling = EnvironmentSampling::kByLight;  // a survey's rays belong to no sample
  s.adaptive.budget = 20;
  if (driver == "adaptive") s.streams = StreamCount::kTwo;
  return s;
}

RenderedImage counted(const Scene& scene, const RenderSettings& s) {
  intersections = occlusions = 0;
  return render(scene, busy_view(), s);
}

uint64_t sum_of_samples(const RenderedImage& image) {
  const auto channel =
      size_t(std::ranges::find(image.channels, "samples") - image.channels.begin());
  uint64_t sum = 0;
  for (size_t i = channel; i < image.values.size(); i += image.channels.size()) {
    sum += uint64_t(image.values[i]);
  }
  return sum;
}

class Counts : public testing::TestWithParam<std::string> {};

TEST_P(Counts, RaysMatchEmbreesQueries) {
  const auto scene = busy_scene();
  const RenderedImage image = counted(*scene, settings_of(GetParam()));
  const RayCounters& rays = image.counters.rays;
  EXPECT_GT(rays.scatter, 0u);
  EXPECT_EQ(rays.camera + rays.scatter, intersections);
  EXPECT_EQ(rays.shadow, occlusions);
  EXPECT_EQ(rays.camera, image.counters.samples);
  EXPECT_EQ(image.counters.samples, sum_of_samples(image));
}

// Shadow rays through panes are traced as intersections, since they need the hit.
TEST_P(Counts, ThroughPanesToo) {
  SceneBuilderForTests b;
  b.add_floor(4, 0, b.add_material(lambert(Rgb(0.5f))));
  b.add_floor(4, 1.5f, b.add_material(glass(1.5f, 0.0f, false)));
  b.add_point_light({0.5, 3, 0.2}, Rgb(10.0f));
  const auto scene = b.build();
  const RenderedImage image = counted(*scene, settings_of(GetParam()));
  const RayCounters& rays = image.counters.rays;
  EXPECT_GT(rays.camera + rays.scatter, 0u);
  EXPECT_GT(rays.shadow, occlusions) << "no pane was looked through";
  EXPECT_EQ(rays.total(), intersections + occlusions);
}

// Relighting by intensity and colour traces no ray, neither to test whether relighting is possible
// nor to show the result. Keeping the lights apart traces no ray either.
TEST_P(Counts, RelightingNeedsNoRays) {
  const GroupedScene lit(edited_scene());
  const RenderSettings s = settings_of(GetParam());
  const RenderedImage plain = counted(lit.scene.scene(), s);
  const uint64_t asked = intersections + occlusions;
  EXPECT_GT(asked, 0u);
  intersections = occlusions = 0;
  render(lit.scene.scene(), busy_view(), s, &lit.groups, [&](const LivePicture* picture) {
    EXPECT_EQ(intersections + occlusions, asked);
    if (!picture) return;  // the driver keeps no sums by light group
    std::vector<float> rgba(4 * size_t(s.crop.area()));
    SceneEdits edits;
    for (int i = 0; i < 20; ++i) {
      light(edits, EditedLight::kPunctual, 0).intensity = float(i);
      const std::optional<LightMix> mix = lit.groups.mix(edits);
      ASSERT_TRUE(mix);
      picture->resolve(rgba, &*mix);
      edits.lights.clear();
    }
  });
  EXPECT_EQ(intersections + occlusions, asked);
}

// With an integrator that traces one ray per sample, the counter of samples equals the number of
// intersections.
TEST_P(Counts, SamplesMatchTheTracedOnes) {
  const auto scene = busy_scene();
  RenderSettings s = settings_of(GetParam());
  s.integrator = "normal";
  const RenderedImage image = counted(*scene, s);
  EXPECT_EQ(image.counters.samples, intersections);
  EXPECT_EQ(image.counters.samples, sum_of_samples(image));
  EXPECT_EQ(occlusions, 0u);
}

// A camera ray of a pixel that no surface comes near is counted but not traced. Each whole batch of
// such a pixel saves its rays, and nothing else changes.
TEST(EmptyPixelCounts, OnlyTheirCameraRaysAreSaved) {
  const auto scene = busy_scene();
  RenderSettings s = settings_of("bucket");
  s.spp = 16;
  const RenderedImage all = counted(*scene, s);
  const uint64_t asked = intersections, shadows = occlusions;
  s.find_empty_pixels = true;
  const RenderedImage image = counted(*scene, s);
  const Camera camera(busy_view(), s.width, s.height, scene->origin(), scene->scale());
  const RenderPlan plan = plan_of(s);
  const Frame frame = plan.frame(*scene, camera);
  ASSERT_TRUE(frame.empty_pixels);
  uint64_t empty = 0;
  for (int y = s.crop.y0; y < s.crop.y1; ++y) {
    for (int x = s.crop.x0; x < s.crop.x1; ++x) empty += frame.empty_pixels->contains(x, y);
  }
  EXPECT_GT(empty, 0u);
  EXPECT_EQ(intersections + 16 * empty, asked);
  EXPECT_EQ(occlusions, shadows);
  EXPECT_EQ(image.values, all.values);
  EXPECT_EQ(image.counters.rays.camera, all.counters.rays.camera);
  EXPECT_EQ(image.counters.rays.total(), all.counters.rays.total());
}

class NullSink final : public RenderSink {
  void tile_finished(const FilmTile& /*tile*/) override {}
};

// A pixel's cost decides how many samples the pixel gets (law 2), so the cost must not depend on
// the batch. When the samples of 16 pixels share a batch, each pixel costs as much as it does
// alone.
TEST(PixelCosts, CountOnlyThePixelsOwnWork) {
  const auto scene = busy_scene();
  const RenderSettings s = settings_of("adaptive");
  const Camera camera(busy_view(), s.width, s.height, scene->origin(), scene->scale());
  const RenderPlan plan = plan_of(s);
  const Frame frame = plan.frame(*scene, camera);
  std::vector<PixelWork> all;
  for (int y = s.crop.y0; y < s.crop.y1; ++y) {
    for (int x = s.crop.x0; x < s.crop.x1; ++x) all.push_back({x, y, 3, 2});
  }
  FilmTile film(AovSet{}, {.rays = true});
  film.reset(s.crop);
  NullSink null_sink;
  RenderWorker worker(frame);
  worker.render(all, film, null_sink, {});
  uint64_t least = all.size(), most = 0;
  for (const PixelWork& pixel : all) {
    FilmTile alone(AovSet{}, {.rays = true});
    alone.reset({pixel.x, pixel.y, pixel.x + 1, pixel.y + 1});
    intersections = occlusions = 0;
    worker.render({&pixel, 1}, alone, null_sink, {});
    const uint64_t asked = intersections + occlusions;
    EXPECT_EQ(film.rays(s.crop.index_of(pixel.x, pixel.y)), asked) << pixel.x << "," << pixel.y;
    EXPECT_EQ(alone.rays(0), asked);
    least = std::min(least, asked);
    most = std::max(most, asked);
  }
  EXPECT_GT(most, least + 10);
}

INSTANTIATE_TEST_SUITE_P(Drivers, Counts, testing::Values("bucket", "bisection", "adaptive"),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace emberline
