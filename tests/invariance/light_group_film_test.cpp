// The film's sums by light group are precise in long and large frames. They can be copied, their
// memory is counted, and they stay finite.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "renderer/drivers/driver_table.h"
#include "renderer/engine/render_job.h"
#include "renderer/film/film.h"
#include "renderer/film/light_mix.h"
#include "samplers/pixel_samples.h"
#include "support/grouped_scene.h"
#include "support/lit_scenes.h"

namespace emberline {
namespace {

using namespace test;

FilmTile film_of(int groups, int width = 1) {
  FilmTile film(AovSet{}, {.light_groups = groups});
  film.reset({0, 0, width, 1});
  return film;
}

// Adds a sample with the groups' contributions.
void add(FilmTile& film, int x, float weight, const SampleValue& value,
         const LightGroupValues& values, int lane = 0) {
  film.add(x, 0, {.value = value, .filter_weight = weight, .lights = &values, .lane = lane});
}

// If samples of .1 were summed in float, the sum would be off by 1e-4 after 10,000 samples, and by
// a third after 2^25.
TEST(LightGroupFilm, LongAccumulation) {
  FilmTile film = film_of(2);
  LightGroupValues values(2);
  values.add(0, 1, Rgb(1.0f), Rgb(0.1f));
  for (uint32_t i = 0; i < 1u << long_or_short(24, 22); ++i)
    add(film, 0, 1.0f, {.alpha = 0.25f}, values);
  EXPECT_NEAR(film.lights(0).mean(1).y, 0.1f, 0.1e-6f);
  EXPECT_EQ(film.lights(0).mean(0), Rgb(0.0f));
  float rgba[4];
  relight(film, LightMix(std::vector<Rgb>{Rgb(5.0f), Rgb(1.0f, 2.0f, 0.0f)}), rgba);
  EXPECT_NEAR(rgba[0], 0.1f, 1e-6f);
  EXPECT_NEAR(rgba[1], 0.2f, 1e-6f);
  EXPECT_EQ(rgba[2], 0.0f);
  EXPECT_NEAR(rgba[3], 0.25f, 1e-6f);
}

TEST(LightGroupFilm, StaysFinite) {
  FilmTile film = film_of(1, 2);
  LightGroupValues values(1);
  values.add(0, 0, Rgb(1.0f), Rgb(3e38f, 1.0f, 0.0f));
  for (int i = 0; i < 3; ++i) add(film, 1, 1.0f, {.alpha = 1.0f}, values);
  float rgba[8];
  relight(film, LightMix(std::vector<Rgb>{Rgb(100.0f)}), rgba);
  for (const float value : rgba) EXPECT_TRUE(std::isfinite(value));
  EXPECT_FLOAT_EQ(rgba[5], 100.0f);
  EXPECT_EQ(rgba[0], 0.0f) << "no sample";
  EXPECT_EQ(rgba[3], 0.0f);
}

TEST(LightGroupFilm, IsCopiedAndCounted) {
  const FilmTile none(AovSet{});
  FilmTile from = film_of(2, 3), to(AovSet{}, from.extras());
  to.reset({1, 0, 3, 1});
  LightGroupValues values(2);
  values.add(3, 0, Rgb(2.0f), Rgb(1, 2, 3));
  values.add(3, 0, Rgb(1.0f), Rgb(1, 0, 0));
  add(from, 2, 0.5f, {Rgb(3, 4, 6), 1.0f, {}, {}}, values, 3);
  to.copy_pixel(from, 2, 0);
  EXPECT_EQ(to.lights(1).mean(0), Rgb(1.5f, 2, 3));
  EXPECT_EQ(to.lights(0).mean(0), Rgb(0.0f));
  // Each pixel takes 24 bytes for each of two groups, and 24 for the sample count.
  EXPECT_EQ(film_of(2, 1000).bytes() - film_of(-1, 1000).bytes(), 72000u + 4u);
}

// Law 4: a NaN or infinite sample is black in all groups, and is counted. Every fourth sample of
// this integrator is NaN.
class NanIntegrator final : public Integrator {
 public:
  void estimate(const SampleBatch& batch, PixelSamples&,
                std::span<SampleValue> values) const override {
    for (size_t i = 0; i < batch.rays.size(); ++i) {
      const bool bad = i % 4 == 1;
      values[i].radiance = Rgb(bad ? std::numeric_limits<float>::quiet_NaN() : 3.0f);
      values[i].alpha = 1.0f;
      batch.light_values->add(int(i), 0, Rgb(1.0f), Rgb(1.0f));
      batch.light_values->add(int(i), 1, Rgb(1.0f), values[i].radiance - Rgb(1.0f));
    }
  }
};

TEST(LightGroupFilm, ABadSampleIsBlackInAllGroups) {
  const GroupedScene lit(lit_scene());
  const Scene& scene = lit.scene.scene();
  const Camera camera(lit_view(), 8, 8, scene.origin(), scene.scale());
  RenderSettings settings;
  settings.width = settings.height = 8;
  RenderPlan plan = plan_of(settings);
  plan.integrator = std::make_unique<NanIntegrator>();
  const Frame frame = plan.frame(scene, camera, {.light_groups = &lit.groups});
  class CaptureSink final : public RenderSink {
    void tile_finished(const FilmTile& tile) override {
      EXPECT_EQ(tile.non_finite(3, 3), 4u);
      const size_t i = tile.rect().index_of(3, 3);
      EXPECT_FLOAT_EQ(tile.lights(i).mean(0).x, 0.75f);
      EXPECT_FLOAT_EQ(tile.lights(i).mean(1).x, 1.5f);
      float rgba[4 * 64];
      relight(tile, LightMix(std::vector<Rgb>(4, Rgb(1.0f))), rgba);
      EXPECT_FLOAT_EQ(rgba[4 * i], tile.mean(3, 3).x);
      EXPECT_FLOAT_EQ(rgba[4 * i + 3], 0.75f);
    }
  } look;
  RenderJob(frame, driver_factory("bucket", {})).render(look, {});
}

}  // namespace
}  // namespace emberline
