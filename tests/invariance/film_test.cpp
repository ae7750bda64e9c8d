// Guarantees of the film: exact sums, honest counts, no NaN.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <stop_token>

#include "renderer/core/errors.h"
#include "renderer/drivers/driver_table.h"
#include "renderer/engine/render_job.h"
#include "renderer/film/film.h"
#include "support/chi_square.h"
#include "support/processor_time.h"
#include "support/render.h"
#include "support/scenes.h"

namespace emberline {
namespace {

SampleValue grey(float v) { return {Rgb(v), 1.0f, {}, {}}; }

// If samples of .1 were summed in float, the sum would be off by a third after 2^25 samples, and by
// more than 1e-6 after 2^20.
TEST(Film, LongAccumulation) {
  const uint32_t samples = 1u << long_or_short(25, 22);
  FilmTile tile{AovSet{}};
  tile.reset({0, 0, 1, 1});
  for (uint32_t i = 0; i < samples; ++i) tile.add(0, 0, {grey(0.1f), 1.0f, 0});
  EXPECT_NEAR(tile.mean(0, 0).x, 0.1, 0.1 * 1e-6);
  EXPECT_EQ(tile.sample_count(0, 0), samples);
}

// Law 4: non-finite samples are counted, and are never part of the mean. The caller locates them.
TEST(Film, NonFiniteSamples) {
  FilmTile tile(AovSet::parse("variance,non_finite"));
  tile.reset({2, 3, 4, 5});
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(tile.add(3, 4, {grey(1.0f), 1.0f, 0}));
  EXPECT_FALSE(tile.add(3, 4, {{Rgb(1.0f, nan, 1.0f), 1.0f, {}, {}}, 1.0f, 0}));
  EXPECT_FALSE(tile.add(3, 4, {{Rgb(inf, 0.0f, 0.0f), 1.0f, {}, {}}, 1.0f, 0}));
  EXPECT_TRUE(tile.add(3, 4, {grey(2.0f), 1.0f, 0}));
  EXPECT_EQ(tile.non_finite(3, 4), 2u);
  EXPECT_EQ(tile.sample_count(3, 4), 4u);
  EXPECT_FLOAT_EQ(tile.mean(3, 4).x, 3.0f / 4);
  std::vector<float> out;
  tile.resolve(out);
  for (const float v : out) EXPECT_TRUE(std::isfinite(v));
  // The film has nine channels, of which non_finite is the last. The pixels are (2,3), (3,3),
  // (2,4), (3,4).
  ASSERT_EQ(out.size(), 4u * 9);
  EXPECT_EQ(out[3 * 9 + 8], 2.0f);
  EXPECT_EQ(out[2 * 9 + 8], 0.0f);
}

TEST(Film, NanFirstHitsAreIgnored) {
  FilmTile tile(AovSet::parse("roughness,metallic"));
  tile.reset({0, 0, 1, 1});
  for (float FirstHit::*member : {&FirstHit::roughness, &FirstHit::metallic}) {
    SampleValue value = grey(1.0f);
    value.first_hit.hit = true;
    value.first_hit.*member = std::numeric_limits<float>::quiet_NaN();
    EXPECT_FALSE(tile.add(0, 0, {value}));
  }
  EXPECT_EQ(tile.non_finite(0, 0), 2u);
}

TEST(Film, VarianceOfTheMean) {
  FilmTile tile(AovSet::parse("variance"));
  tile.reset({0, 0, 1, 1});
  for (const float v : {1.0f, 2.0f, 4.0f, 9.0f}) tile.add(0, 0, {grey(v), 1.0f, 0});
  std::vector<float> out;
  tile.resolve(out);
  // The mean is 4. The squared deviations are 9 + 4 + 0 + 25 = 38, divided by n (n - 1) = 12.
  EXPECT_NEAR(out[5], 38.0 / 12, 1e-6);
}

TEST(Film, VarianceFromTwoStreams) {
  FilmTile tile(AovSet::parse("variance"));
  tile.reset({0, 0, 1, 1});
  for (const float v : {1.0f, 3.0f}) tile.add(0, 0, {grey(v), 1.0f, 0});
  for (const float v : {5.0f, 7.0f}) tile.add(0, 0, {grey(v), 1.0f, 1});
  std::vector<float> out;
  tile.resolve(out);
  EXPECT_FLOAT_EQ(out[0], 4.0f);
  EXPECT_FLOAT_EQ(out[5], 4.0f);  // (2 - 6)^2 / 4
}

// A variance set by the driver replaces the film's own for that pixel until the film is cleared.
// The film divides it by the current sample count.
TEST(Film, VarianceGivenByTheDriver) {
  FilmTile tile(AovSet::parse("variance"), {.sample_variance = true});
  tile.reset({0, 0, 2, 1});
  for (int x = 0; x < 2; ++x) {
    for (const float v : {1.0f, 2.0f, 4.0f, 9.0f}) tile.add(x, 0, {grey(v), 1.0f, 0});
  }
  tile.set_sample_variance(1, {8, 2, 0});
  EXPECT_NEAR(tile.variance(0, 0)->x, 38.0 / 12, 1e-6);
  EXPECT_EQ(*tile.variance(1, 0), Rgb(2, 0.5f, 0));
  for (int i = 0; i < 4; ++i) tile.add(1, 0, {grey(4), 1.0f, 0});
  EXPECT_EQ(*tile.variance(1, 0), Rgb(1, 0.25f, 0));
  EXPECT_EQ(tile.mean(1, 0), Rgb(4));

  FilmTile copy(AovSet::parse("variance"), tile.extras());
  copy.reset({1, 0, 2, 1});
  copy.copy_pixel(tile, 1, 0);
  EXPECT_EQ(copy.variance(1, 0), tile.variance(1, 0));
  std::vector<float> out;
  copy.resolve(out);
  EXPECT_EQ(Rgb(out[5], out[6], out[7]), Rgb(1, 0.25f, 0));

  tile.reset({0, 0, 2, 1});
  EXPECT_FALSE(tile.variance(1, 0).has_value());
}

// Law 3: variances take memory only if the channel is requested and the driver sets variances.
TEST(Film, AllocatesVariancesOnlyIfTheDriverGivesThem) {
  const auto bytes = [](const char* aovs, bool told) {
    FilmTile tile(AovSet::parse(aovs), {.sample_variance = told});
    tile.reset({0, 0, 100, 10});
    tile.set_sample_variance(7, Rgb(1));
    return tile.bytes();
  };
  EXPECT_EQ(bytes("", true), bytes("", false));
  EXPECT_EQ(bytes("variance", true) - bytes("variance", false), 16u * 1000);
}

// Law 4 for the output: the variance stays finite, although the square of a large radiance
// overflows float.
TEST(Film, VarianceStaysFinite) {
  FilmTile tile(AovSet::parse("variance"));
  tile.reset({0, 0, 1, 1});
  for (const float v : {0.0f, 1e25f}) tile.add(0, 0, {grey(v), 1.0f, 0});
  std::vector<float> out;
  tile.resolve(out);
  for (const float v : out) EXPECT_TRUE(std::isfinite(v));
}

TEST(Film, HalvesAddUpToTheWhole) {
  FilmTile split{AovSet{}}, whole{AovSet{}};
  split.reset({0, 0, 1, 1});
  whole.reset({0, 0, 1, 1});
  for (int i = 0; i < 32; ++i) {
    split.add(0, 0, {grey(float(i)), 1.0f, (i >> 3) & 1});
    whole.add(0, 0, {grey(float(i)), 1.0f, 0});
  }
  EXPECT_FLOAT_EQ(split.mean(0, 0).x, whole.mean(0, 0).x);
  EXPECT_FLOAT_EQ(whole.mean(0, 0).x, 15.5f);
}

SampleValue moving(bool hit, float x, float y) {
  SampleValue value = grey(1.0f);
  value.first_hit.hit = hit;
  value.first_hit.velocity = {x, y};
  return value;
}

// A pixel's velocity is the velocity of its surfaces. The velocity of the background counts only in
// a pixel without surfaces.
TEST(Film, VelocityIsMeasuredOnSurfaces) {
  const std::vector<SampleValue> samples = {moving(false, 8, 8), moving(true, 1, -2),
                                            moving(false, 8, 8), moving(true, 4, -6)};
  for (size_t first_film = 0; first_film <= samples.size(); ++first_film) {
    FilmTile film(AovSet::parse("velocity")), more(AovSet::parse("velocity"));
    film.reset({0, 0, 2, 1});
    more.reset({0, 0, 2, 1});
    for (size_t i = 0; i < samples.size(); ++i) {
      FilmTile& to = i < first_film ? film : more;
      to.add(0, 0, {samples[i], 1.0f, 0});
      if (!samples[i].first_hit.hit) to.add(1, 0, {samples[i], 1.0f, 0});
    }
    film.add_film(more);
    std::vector<std::byte> bytes;
    Archive saving(bytes);
    film.archive(saving);
    saving.end();
    FilmTile loaded(AovSet::parse("velocity"));
    loaded.reset({0, 0, 2, 1});
    Archive loading{std::span<const std::byte>(bytes)};
    loaded.archive(loading);
    loading.end();
    FilmTile copy(AovSet::parse("velocity"));
    copy.reset({0, 0, 2, 1});
    for (const int x : {0, 1}) copy.copy_pixel(loaded, x, 0);
    std::vector<float> out;
    copy.resolve(out);
    EXPECT_EQ(out[5], 2.5f) << first_film;
    EXPECT_EQ(out[6], -4.0f) << first_film;
    EXPECT_EQ(out[12], 8.0f) << first_film;
  }
}

// Law 4 for a film loaded from a file: every state that is accepted resolves to finite values. The
// test tries sums that are beyond float's range, beyond double's range when added, or denormal.
TEST(Film, SumsFromAnyFileStayFinite) {
  const AovSet aovs = AovSet::parse(
      "variance,albedo,N,Z,P,UV,velocity,clamped,direct,indirect,emission,transmission,reflection,"
      "environment,shadow,denoising,id,time,stop,non_finite");
  const FilmExtras extras = {
      .squares = true, .rays = true, .sample_variance = true, .light_groups = 2};
  FilmTile film(aovs, extras);
  film.reset({0, 0, 2, 1});
  const DenoiserFeatures seen = {Rgb(0.5f), Vec3f(0.0f, 0.0f, 1.0f), 1.0f, 1.0f};
  for (int i = 0; i < 4; ++i) film.add(0, 0, {moving(true, 1, 2), 1.0f, i & 1, &seen});
  std::vector<std::byte> state;
  Archive saving(state);
  film.archive(saving);
  saving.end();
  int accepted = 0;
  for (uint64_t round = 0; round < long_or_short(20000u, 5000u); ++round) {
    test::TestRandom random(round, 0);
    std::vector<std::byte> bytes = state;
    for (int k = 0; k < 3; ++k) {
      const double wide = std::array{1e300, -1e300, 1.7e308, -1.7e308, 1e-310}[random.bits() % 5];
      const float narrow = std::array{3e38f, -3e38f, 1e-38f}[random.bits() % 3];
      const bool is_wide = random.bits() % 2 == 0;
      const size_t size = is_wide ? sizeof wide : sizeof narrow;
      const size_t place = random.bits() % (bytes.size() / size) * size;
      std::memcpy(&bytes[place], is_wide ? static_cast<const void*>(&wide) : &narrow, size);
    }
    FilmTile loaded(aovs, extras);
    loaded.reset({0, 0, 2, 1});
    try {
      Archive loading{std::span<const std::byte>(bytes)};
      loaded.archive(loading);
      loading.end();
    } catch (const InputError&) {
      continue;
    }
    ++accepted;
    FilmTile twice(aovs, extras);
    twice.reset({0, 0, 2, 1});
    for (int k = 0; k < 2; ++k) twice.add_film(loaded);
    for (const FilmTile* tile : {&loaded, &twice}) {
      std::vector<float> out;
      tile->resolve(out);
      for (size_t i = 0; i < out.size(); ++i) {
        ASSERT_TRUE(std::isfinite(out[i]))
            << "round " << round << ": " << film_channel_names(aovs)[i % (out.size() / 2)];
      }
      for (int group = 0; group < 2; ++group) {
        ASSERT_TRUE(is_finite(tile->lights(0).mean(group))) << round;
      }
      const FilmTile::Surface surface = tile->surface(0, 0);
      ASSERT_TRUE(std::isfinite(surface.albedo[0]) && std::isfinite(surface.nearness)) << round;
    }
  }
  EXPECT_GT(accepted, long_or_short(5000, 1250));
}

TEST(Film, UnknownChannelSuggestsTheNearest) {
  try {
    AovSet::parse("albedo,depht");
    FAIL();
  } catch (const UsageError& e) {
    EXPECT_NE(std::string(e.what()).find("did you mean 'depth', 'direct' or 'depth_variance'?"),
              std::string::npos);
  }
}

// A stopped frame ends soon, and leaves a readable film with true counts.
TEST(Film, StoppedFrameHasTrueCounts) {
  using namespace test;
  SceneBuilderForTests b;
  b.add_floor(1, 0, b.add_material(lambert(Rgb(0.5f))));
  b.set_environment(Rgb(1.0f));
  const auto scene = b.build();
  const CameraDescription view = perspective({0, 2, 2}, {0, 0, 0}, 40);
  const Camera camera(view, 64, 64, scene->origin(), scene->scale());
  RenderSettings settings;
  settings.width = settings.height = 64;
  settings.spp = 1 << 23;  // takes more than 30 ms for one empty pixel
  const RenderPlan plan = plan_of(settings);
  const Frame frame = plan.frame(*scene, camera);

  class StoppingSink final : public RenderSink {
   public:
    explicit StoppingSink(std::stop_source stop) : stop_(std::move(stop)) {}
    void tile_finished(const FilmTile& tile) override {
      for (int y = tile.rect().y0; y < tile.rect().y1; ++y) {
        for (int x = tile.rect().x0; x < tile.rect().x1; ++x) counted += tile.sample_count(x, y);
      }
    }
    void samples_finished(uint64_t) override { stop_.request_stop(); }
    std::atomic<uint64_t> counted{0};

   private:
    std::stop_source stop_;
  };
  std::stop_source stop;
  std::thread timer([&] {
    test::wait_for_work(0.06);
    stop.request_stop();
  });
  StoppingSink sink(stop);
  const RenderCounters counters =
      RenderJob(frame, driver_factory("bucket", {16, BucketOrder::kScanline}))
          .render(sink, stop.get_token())
          .counters;
  timer.join();
  EXPECT_TRUE(counters.stopped);
  EXPECT_GT(counters.samples, 0u);
  EXPECT_EQ(counters.samples, sink.counted.load());
  EXPECT_EQ(counters.min_samples, 0u);
  EXPECT_LT(counters.max_samples, 1u << 23);
}

}  // namespace
}  // namespace emberline
