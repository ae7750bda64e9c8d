// Laws 1 and 2: a sample is a pure function of its address, and equal sets of samples give equal
// bits, whatever the schedule.
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cstring>

#include "renderer/drivers/adaptive/error_estimator.h"
#include "renderer/drivers/bisection_schedule.h"
#include "renderer/drivers/bucket_schedule.h"
#include "renderer/engine/render_worker.h"
#include "support/busy_scene.h"
#include "support/long_tests.h"
#include "support/moving_scenes.h"
#include "support/render.h"

namespace emberline {
namespace {

using namespace test;

RenderSettings base_settings(const std::string& sampler) {
  RenderSettings s;
  s.sampler = sampler;
  s.width = 37;  // primes, so that no bucket size divides them
  s.height = 29;
  s.spp = 20;  // a full block of 16 and part of another
  for (const SamplerEntry& entry : sampler_table()) {
    if (entry.name == sampler && entry.counts == SampleCounts::kPowerOfTwo) s.spp = 32;
  }
  s.filter = "gaussian";
  s.aovs = "variance,albedo,N,Z,velocity,id";
  return s;
}

class SameSamples : public testing::TestWithParam<std::string> {
 protected:
  static void SetUpTestSuite() { scene_ = busy_scene().release(); }
  static void TearDownTestSuite() {
    delete scene_;
    scene_ = nullptr;
  }
  static Scene* scene_;
};
Scene* SameSamples::scene_ = nullptr;

// A short run takes every third combination, which still includes each value of threads, order and
// size.
TEST_P(SameSamples, AnyThreadsOrderBucketSize) {
  RenderSettings s = base_settings(GetParam());
  s.threads = 1;
  const RenderedImage reference = render(*scene_, busy_view(), s);
  EXPECT_GT(reference.mean, 0.05);
  int combination = 0;
  for (const int threads : {1, 2, 7}) {
    for (const NamedValue<BucketOrder>& order : bucket_order_table()) {
      for (const int size : {1, 7, 16, 64}) {
        if (combination++ % long_or_short(1, 3) != 0) continue;
        s.threads = threads;
        s.bucket_order = order.value;
        s.bucket_size = size;
        expect_same_bits(render(*scene_, busy_view(), s), reference,
                         std::to_string(threads) + " threads, " + std::string(order.name) +
                             ", buckets of " + std::to_string(size));
      }
    }
  }
}

TEST_P(SameSamples, AnyCrop) {
  RenderSettings s = base_settings(GetParam());
  const RenderedImage whole = render(*scene_, busy_view(), s);
  for (const Rect& crop : {Rect{0, 0, 5, 29}, Rect{11, 3, 30, 17}, Rect{36, 28, 37, 29}}) {
    s.crop = crop;
    expect_same_bits(render(*scene_, busy_view(), s), whole, "crop");
  }
}

TEST_P(SameSamples, EveryIntegrator) {
  for (const IntegratorEntry& integrator : integrator_table()) {
    RenderSettings s = base_settings(GetParam());
    s.integrator = std::string(integrator.name);
    s.threads = 1;
    const RenderedImage one = render(*scene_, busy_view(), s);
    s.threads = 3;
    s.bucket_order = BucketOrder::kRandom;
    s.bucket_size = 5;
    expect_same_bits(render(*scene_, busy_view(), s), one, s.integrator);
  }
}

TEST_P(SameSamples, AnotherBuildOfTheScene) {
  RenderSettings s = base_settings(GetParam());
  const auto again = busy_scene();
  expect_same_bits(render(*again, busy_view(), s), render(*scene_, busy_view(), s),
                   "rebuilt scene");
}

TEST_P(SameSamples, SeedsDiffer) {
  RenderSettings s = base_settings(GetParam());
  const RenderedImage a = render(*scene_, busy_view(), s);
  s.seed++;
  const RenderedImage b = render(*scene_, busy_view(), s);
  EXPECT_NE(0, std::memcmp(a.values.data(), b.values.data(), a.values.size() * sizeof(float)));
}

CameraDescription lens_view() {
  CameraDescription view = busy_view();
  view.lens_radius = 0.2;
  view.focus_distance = 3.0;
  return view;
}

// Expects the same bits for all thread counts, buckets, drivers and crops.
void expect_same_everywhere(const Scene& scene, const CameraDescription& view, RenderSettings s) {
  s.threads = 1;
  const RenderedImage reference = render(scene, view, s);
  for (const int threads : {2, 7}) {
    s.threads = threads;
    for (const int size : {1, 7, 64}) {
      s.driver = "bucket";
      s.bucket_size = size;
      expect_same_bits(render(scene, view, s), reference, "buckets of " + std::to_string(size));
    }
    s.driver = "bisection";
    expect_same_bits(render(scene, view, s), reference, "bisection");
  }
  s.crop = Rect{11, 3, 30, 17};
  expect_same_bits(render(scene, view, s), reference, "crop");
}

// Samples of the lens are also the same everywhere.
TEST_P(SameSamples, ThroughALens) {
  const RenderSettings s = base_settings(GetParam());
  EXPECT_NE(render(*scene_, lens_view(), s).values, render(*scene_, busy_view(), s).values);
  expect_same_everywhere(*scene_, lens_view(), s);
}

TEST_P(SameSamples, WithSeveralLightSamples) {
  RenderSettings s = base_settings(GetParam());
  const RenderedImage one = render(*scene_, busy_view(), s);
  s.light_samples = 3;
  EXPECT_NE(render(*scene_, busy_view(), s).values, one.values);
  expect_same_everywhere(*scene_, busy_view(), s);
}

// Samples of time are also the same everywhere. Instances, vertices, lamps, lights and the camera
// move.
TEST_P(SameSamples, InMotion) {
  const MovingScene moving;
  const auto scene = moving.at_all_times().build();
  ASSERT_TRUE(scene->moves());
  expect_same_everywhere(*scene, moving.view(), base_settings(GetParam()));
}

// A sample that is replayed alone equals the sample that the frame used, so the mean of the replays
// is the pixel.
TEST_P(SameSamples, ReplayedAlone) {
  const MovingScene moving;
  const auto moving_scene = moving.at_all_times().build();
  const std::pair<const Scene*, CameraDescription> views[] = {
      {scene_, busy_view()}, {scene_, lens_view()}, {moving_scene.get(), moving.view()}};
  for (const auto& [scene, view] : views) {
    RenderSettings s = base_settings(GetParam());
    const RenderedImage image = render(*scene, view, s);
    const Camera camera(view, s.width, s.height, scene->origin(), scene->scale());
    const RenderPlan plan = plan_of(s);
    const Frame frame = plan.frame(*scene, camera);
    RenderWorker worker(frame);
    for (const auto& [x, y] : {std::pair{3, 4}, std::pair{20, 14}, std::pair{30, 20}}) {
      double sum[3] = {0, 0, 0};
      for (uint32_t k = 0; k < s.spp; ++k) {
        const Rgb value = worker.replay(x, y, k, nullptr).radiance;
        for (int c = 0; c < 3; ++c) sum[c] += double(value[c]);
      }
      for (int c = 0; c < 3; ++c) {
        EXPECT_EQ(float(sum[c] * (1.0 / s.spp)), image.pixel(x, y)[c]) << x << "," << y;
      }
    }
  }
}

// Bisection and bucket give the same samples, although their orders differ.
TEST_P(SameSamples, BisectionAndBucket) {
  RenderSettings s = base_settings(GetParam());
  s.aovs = "variance,albedo,N,Z,id,stop";
  // Some samplers require a sample count that is a power of two.
  const auto counts =
      std::has_single_bit(s.spp) ? std::array{1u, 4u, 16u, 32u} : std::array{1u, 3u, 16u, 37u};
  int combination = 0;
  for (const StreamCount streams : {StreamCount::kOne, StreamCount::kTwo}) {
    for (const uint32_t spp : counts) {
      for (const Rect& crop : {Rect{}, Rect{11, 3, 30, 17}, Rect{36, 2, 37, 29}}) {
        s.streams = streams;
        s.spp = spp;
        s.crop = crop;
        s.driver = "bucket";
        s.threads = 2;
        const RenderedImage bucket = render(*scene_, busy_view(), s);
        s.driver = "bisection";
        for (const NamedValue<BisectionAxis>& axis : bisection_axis_table()) {
          for (const int threads : {1, 4}) {
            if (combination++ % long_or_short(1, 5) != 0) continue;
            s.bisection_axis = axis.value;
            s.threads = threads;
            const RenderedImage image = render(*scene_, busy_view(), s);
            expect_same_bits(image, bucket,
                             std::string(axis.name) + ", " + std::to_string(threads) +
                                 " threads, " + std::to_string(spp) + " spp, streams " +
                                 std::to_string(int(streams)));
            EXPECT_EQ(image.counters.samples, bucket.counters.samples);
            EXPECT_EQ(image.counters.rays.total(), bucket.counters.rays.total());
            EXPECT_EQ(image.counters.min_samples, spp);
            EXPECT_EQ(image.counters.max_samples, spp);
            EXPECT_FALSE(image.counters.stopped);
          }
        }
      }
    }
  }
}

// Sets the variance to 0. Drivers that keep sample halves estimate it better than others (film.h).
RenderedImage without_variance(RenderedImage image) {
  for (size_t c = 0; c < image.channels.size(); ++c) {
    if (!image.channels[c].starts_with("variance.")) continue;
    for (size_t i = c; i < image.values.size(); i += image.channels.size()) image.values[i] = 0.0f;
  }
  return image;
}

// Adaptive sampling with nothing to decide gives the same samples as the bucket driver. It rejects
// samplers whose points depend on the total count. A sampler whose weights depend on the count
// weights all points equally if the count is a power of two.
class AdaptiveSameSamples : public SameSamples {};
TEST_P(AdaptiveSameSamples, AdaptiveAndBucket) {
  const bool weighs = create_sampler(GetParam(), {})->integration_weight(0, 3) != 1.0f;
  const auto counts = weighs ? std::array{1u, 4u, 16u, 32u} : std::array{1u, 3u, 16u, 37u};
  RenderSettings s = base_settings(GetParam());
  s.aovs = "variance,albedo,N,Z,id";
  int combination = 0;
  for (const StreamCount streams : {StreamCount::kOne, StreamCount::kTwo}) {
    for (const uint32_t spp : counts) {
      for (const Rect& crop : {Rect{}, Rect{11, 3, 30, 17}, Rect{36, 2, 37, 29}}) {
        s.streams = streams;
        s.spp = spp;
        s.crop = crop;
        s.driver = "bucket";
        s.threads = 2;
        const RenderedImage bucket = render(*scene_, busy_view(), s);
        s.driver = "adaptive";
        s.adaptive.budget = s.adaptive.min_samples = s.adaptive.max_samples = spp;
        for (const EstimatorEntry& estimator : estimator_table()) {
          s.adaptive.estimator = estimator.name;
          for (const int threads : {1, 4}) {
            if (combination++ % long_or_short(1, 5) != 0) continue;
            s.threads = threads;
            const RenderedImage image = render(*scene_, busy_view(), s);
            const auto compared = [&](const RenderedImage& of) {
              return estimator.halves ? without_variance(of) : of;
            };
            expect_same_bits(compared(image), compared(bucket),
                             std::string(estimator.name) + ", " + std::to_string(threads) +
                                 " threads, " + std::to_string(spp) + " spp, streams " +
                                 std::to_string(int(streams)));
            EXPECT_EQ(image.counters.samples, bucket.counters.samples);
            EXPECT_EQ(image.counters.rays.total(), bucket.counters.rays.total());
            EXPECT_EQ(image.counters.min_samples, spp);
            EXPECT_EQ(image.counters.max_samples, spp);
            EXPECT_FALSE(image.counters.stopped);
          }
        }
      }
    }
  }
}

TEST_P(AdaptiveSameSamples, ThroughALens) {
  RenderSettings s = base_settings(GetParam());
  s.spp = 16;
  const RenderedImage bucket = render(*scene_, lens_view(), s);
  s.driver = "adaptive";
  s.adaptive.budget = s.adaptive.min_samples = s.adaptive.max_samples = s.spp;
  s.threads = 4;
  expect_same_bits(without_variance(render(*scene_, lens_view(), s)), without_variance(bucket),
                   "adaptive");
}

std::vector<std::string> sampler_names() {
  std::vector<std::string> names;
  for (const SamplerEntry& entry : sampler_table()) names.emplace_back(entry.name);
  return names;
}
std::vector<std::string> samplers_of_any_count() {
  std::vector<std::string> names;
  for (const SamplerEntry& entry : sampler_table()) {
    if (entry.counts == SampleCounts::kAny) names.emplace_back(entry.name);
  }
  return names;
}
INSTANTIATE_TEST_SUITE_P(EverySampler, AdaptiveSameSamples,
                         testing::ValuesIn(samplers_of_any_count()),
                         [](const auto& p) { return p.param; });
INSTANTIATE_TEST_SUITE_P(EverySampler, SameSamples, testing::ValuesIn(sampler_names()),
                         [](const auto& p) { return p.param; });

// The light is so faint that its sums are denormal floats.
TEST(FaintLight, BisectionAndBucket) {
  SceneBuilderForTests b;
  b.add_floor(4, 0, b.add_material(lambert(Rgb(0.5f, 0.1f, 0.9f))));
  b.set_environment(Rgb(1.5e-38f));
  const auto scene = b.build();
  const CameraDescription view = perspective({0.4, 2.0, 5.0}, {0, 0.5, 0}, 40);
  RenderSettings s;
  s.width = 24;
  s.height = 18;
  s.spp = 16;
  const RenderedImage expected = render(*scene, view, s);
  for (const char* driver : {"bisection", "adaptive"}) {
    s.driver = driver;
    s.adaptive.budget = s.adaptive.min_samples = s.adaptive.max_samples = s.spp;
    expect_same_bits(render(*scene, view, s), expected, driver);
  }
}

// The counters keep the first non-finite samples in pixel order, whichever worker meets them.
TEST(NonFiniteSamples, TheFirstAreKept) {
  RenderCounters one, other;
  for (int i = 99; i >= 0; --i) (i % 3 == 0 ? one : other).locate({i % 10, i / 10, 7, 1});
  one.merge(other);
  ASSERT_EQ(one.located.size(), RenderCounters::kMaxLocated);
  for (int i = 0; i < int(one.located.size()); ++i) {
    EXPECT_EQ(one.located[size_t(i)].x + 10 * one.located[size_t(i)].y, i);
  }
}

}  // namespace
}  // namespace emberline
