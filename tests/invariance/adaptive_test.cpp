// Tests adaptive frames that make real decisions. They are the same for any thread count and on
// every run, their sample counts are true, and they are complete whenever they are stopped.
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <bit>
#include <limits>

#include "renderer/drivers/adaptive/error_estimator.h"
#include "renderer/drivers/bucket_schedule.h"
#include "renderer/drivers/driver_table.h"
#include "renderer/engine/render_job.h"
#include "renderer/engine/render_worker.h"
#include "renderer/film/film.h"
#include "support/busy_scene.h"
#include "support/long_tests.h"
#include "support/render.h"
#include "support/stop_after.h"

namespace emberline {
namespace {

using namespace test;

RenderSettings settings_for(const EstimatorEntry& estimator) {
  RenderSettings s;
  s.driver = "adaptive";
  s.width = 53;
  s.height = 41;
  s.aovs = "variance,albedo,N,Z,velocity,id,stop";
  s.streams = estimator.streams;
  s.adaptive.estimator = estimator.name;
  s.adaptive.budget = 40;
  return s;
}

constexpr size_t kSamples = 4, kVariance = 5, kStop = 18;  // channels

class AdaptiveFrame : public testing::TestWithParam<std::string_view> {
 protected:
  static void SetUpTestSuite() { scene_ = busy_scene().release(); }
  static void TearDownTestSuite() {
    delete scene_;
    scene_ = nullptr;
  }
  static RenderSettings settings() { return settings_for(find_estimator(GetParam())); }
  static Scene* scene_;
};
Scene* AdaptiveFrame::scene_ = nullptr;

uint64_t sum_of_counts(const RenderedImage& image) {
  uint64_t total = 0;
  for (size_t i = 0; i < image.values.size(); i += image.channels.size()) {
    total += uint64_t(image.values[i + kSamples]);
  }
  return total;
}

TEST_P(AdaptiveFrame, AnyThreadsTwiceInARow) {
  for (const float threshold : {0.0f, 0.02f}) {
    RenderSettings s = settings();
    s.adaptive.threshold = threshold;
    s.threads = 1;
    const RenderedImage reference = render(*scene_, busy_view(), s);
    EXPECT_GT(reference.counters.max_samples, reference.counters.min_samples)
        << "nothing was decided";
    constexpr int kThreads[] = {7, 7, 1, 2};
    for (const int threads : std::span(kThreads).first(long_or_short(4, 2))) {
      s.threads = threads;
      const RenderedImage image = render(*scene_, busy_view(), s);
      expect_same_bits(image, reference, std::to_string(threads) + " threads");
      EXPECT_EQ(image.counters.samples, reference.counters.samples);
      EXPECT_EQ(image.counters.rays.total(), reference.counters.rays.total());
      EXPECT_EQ(image.error_estimate, reference.error_estimate);
    }
  }
}

TEST_P(AdaptiveFrame, CountsAddUp) {
  const RenderSettings s = settings();
  const RenderedImage image = render(*scene_, busy_view(), s);
  uint32_t least = 1u << 30, most = 0;
  for (int y = 0; y < s.height; ++y) {
    for (int x = 0; x < s.width; ++x) {
      const auto n = uint32_t(image.pixel(x, y)[kSamples]);
      least = std::min(least, n);
      most = std::max(most, n);
      ASSERT_EQ(image.pixel(x, y)[kStop], float(PixelStop::kBudget)) << x << "," << y;
    }
  }
  EXPECT_EQ(image.counters.samples, sum_of_counts(image));
  EXPECT_EQ(image.counters.rays.camera, image.counters.samples);
  EXPECT_EQ(image.counters.min_samples, least);
  EXPECT_EQ(image.counters.max_samples, most);
  EXPECT_NEAR(double(image.counters.samples) / double(image.crop.area()), 40.0, 0.4);
}

// A pixel's samples are the first ones of its sequence, no matter in which rounds they were taken.
// Replaying as many samples, in index order within each stream, gives the pixel bit for bit.
TEST_P(AdaptiveFrame, ReplayedFromTheSamplesChannel) {
  const RenderSettings s = settings();
  const RenderedImage image = render(*scene_, busy_view(), s);
  const Camera camera(busy_view(), s.width, s.height, scene_->origin(), scene_->scale());
  const RenderPlan plan = plan_of(s);
  const Frame frame = plan.frame(*scene_, camera);
  RenderWorker worker(frame);
  for (int y = 3; y < s.height; y += 11) {
    for (int x = 2; x < s.width; x += 13) {
      const auto count = uint32_t(image.pixel(x, y)[kSamples]);
      double sums[2][3] = {};
      for (uint32_t k = 0; k < count; ++k) {
        const Rgb value = worker.replay(x, y, k, nullptr).radiance;
        const uint32_t stream = s.streams == StreamCount::kTwo ? (k >> 3) & 1u : 0u;
        for (int c = 0; c < 3; ++c) sums[stream][c] += double(value[c]);
      }
      for (int c = 0; c < 3; ++c) {
        ASSERT_EQ(float((sums[0][c] + sums[1][c]) * (1.0 / count)), image.pixel(x, y)[c])
            << "emberline render --replay " << x << "," << y << ",0 to " << count - 1;
      }
    }
  }
}

// A crop knows neither the pixels beyond its edge, which estimators would pool, nor the whole
// frame's budget. So its sample counts may differ from the whole frame's. Where a count agrees, the
// bits agree.
TEST_P(AdaptiveFrame, CropHasTheSameSamplesAsTheFrame) {
  RenderSettings s = settings();
  const RenderedImage whole = render(*scene_, busy_view(), s);
  s.crop = {10, 8, 44, 33};
  const RenderedImage crop = render(*scene_, busy_view(), s);
  int agreeing = 0;
  for (int y = s.crop.y0; y < s.crop.y1; ++y) {
    for (int x = s.crop.x0; x < s.crop.x1; ++x) {
      if (crop.pixel(x, y)[kSamples] != whole.pixel(x, y)[kSamples]) continue;
      ++agreeing;
      for (int c = 0; c < 3; ++c) ASSERT_EQ(crop.pixel(x, y)[c], whole.pixel(x, y)[c]);
    }
  }
  EXPECT_GT(agreeing, 20);
}

// With one stream, each pixel equals that pixel in the uniform frame of the same sample count,
// whatever was decided. The counts are 8, 12, 16, 24, ...
uint32_t next_step(uint32_t count) {
  return std::has_single_bit(count) ? count / 2 * 3 : count / 3 * 4;
}

TEST(NestedFrame, PixelsEqualUniformFramesOfTheSameCount) {
  const auto scene = busy_scene();
  RenderSettings s = settings_for(find_estimator("nested"));
  s.aovs = "albedo,N,Z,id";
  s.width = long_or_short(53, 31);
  s.height = long_or_short(41, 23);
  const RenderedImage adaptive = render(*scene, busy_view(), s);
  s.driver = "bucket";
  size_t compared = 0;
  for (uint32_t spp = 8; spp <= adaptive.counters.max_samples; spp = next_step(spp)) {
    s.spp = spp;
    const RenderedImage uniform = render(*scene, busy_view(), s);
    for (int y = 0; y < s.height; ++y) {
      for (int x = 0; x < s.width; ++x) {
        const float* pixel = adaptive.pixel(x, y);
        if (pixel[kSamples] != float(spp)) continue;
        ASSERT_TRUE(std::equal(pixel, pixel + adaptive.channels.size(), uniform.pixel(x, y)))
            << x << "," << y << " of " << spp;
        ++compared;
      }
    }
  }
  EXPECT_EQ(compared, size_t(s.width) * size_t(s.height)) << "counts are steps";
}

// The variance channel makes the film keep the halves of the samples apart. That must not change
// the picture.
TEST(NestedFrame, VarianceDoesNotChangeThePicture) {
  const auto scene = busy_scene();
  RenderSettings s = settings_for(find_estimator("nested"));
  s.aovs = "";
  const RenderedImage without = render(*scene, busy_view(), s);
  s.aovs = "variance";
  const RenderedImage with = render(*scene, busy_view(), s);
  for (int y = 0; y < s.height; ++y) {
    for (int x = 0; x < s.width; ++x) {
      ASSERT_TRUE(std::equal(without.pixel(x, y), without.pixel(x, y) + 5, with.pixel(x, y)));
    }
  }
  EXPECT_EQ(without.error_estimate, with.error_estimate);
}

RenderedImage stop_after(const Scene& scene, const RenderSettings& s, uint64_t samples,
                         JobProgress* progress = nullptr) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(s.threads));
  const Camera camera(busy_view(), s.width, s.height, scene.origin(), scene.scale());
  RenderPlan plan = plan_of(s);
  plan.crop = {3, 2, s.width - 4, s.height};
  const Frame frame = plan.frame(scene, camera);
  RenderedImage image = blank_image(plan);
  MemorySink memory(image);
  StopAfter sink(memory, samples, image.crop, false);
  RenderJob job(frame, driver_factory("adaptive", plan.driver_settings));
  tbb::task_arena arena(s.threads);
  arena.execute([&] {
    image.counters = job.render(sink, sink.token()).counters;
    job.deliver(sink);
  });
  if (progress) *progress = sink.last();
  return image;
}

TEST_P(AdaptiveFrame, StoppedAtAnyMomentThePictureIsCompleteAndTheCountsTrue) {
  RenderSettings s = settings();
  JobProgress progress;
  const RenderedImage whole = stop_after(*scene_, s, uint64_t(1) << 40, &progress);
  EXPECT_FALSE(whole.counters.stopped);
  EXPECT_EQ(progress.samples, whole.counters.samples);
  EXPECT_EQ(progress.completion, 1.0);
  EXPECT_TRUE(progress.pass_finished);
  for (const int threads : {1, 3}) {
    s.threads = threads;
    for (uint64_t samples = 1; samples < whole.counters.samples;
         samples += 400 + samples / long_or_short(2, 1)) {
      SCOPED_TRACE(std::to_string(threads) + " threads, after " + std::to_string(samples));
      const RenderedImage image = stop_after(*scene_, s, samples);
      uint32_t least = 1u << 30, most = 0;
      for (int y = image.crop.y0; y < image.crop.y1; ++y) {
        for (int x = image.crop.x0; x < image.crop.x1; ++x) {
          const float* p = image.pixel(x, y);
          const auto count = uint32_t(p[kSamples]);
          least = std::min(least, count);
          most = std::max(most, count);
          if (count == 0) {
            ASSERT_EQ(p[kStop], float(PixelStop::kNone));
          } else {
            ASSERT_TRUE(p[kStop] == float(PixelStop::kTimeLimit) ||
                        p[kStop] == float(PixelStop::kBudget))
                << p[kStop];
          }
          for (size_t c = kVariance; c < kVariance + 3; ++c) {
            ASSERT_TRUE(std::isfinite(p[c]) && p[c] >= 0.0f) << p[c] << " of " << count;
          }
          // The frame is lit everywhere, and a pixel without samples shows its neighbours.
          if (image.counters.samples >= uint64_t(image.crop.area())) {
            ASSERT_GT(p[3], 0.0f) << x << "," << y;
          }
          if (p[kSamples] == whole.pixel(x, y)[kSamples]) {
            ASSERT_EQ(p[0], whole.pixel(x, y)[0]);
          }
        }
      }
      EXPECT_EQ(image.counters.samples, sum_of_counts(image));
      EXPECT_EQ(image.counters.min_samples, least);
      EXPECT_EQ(image.counters.max_samples, most);
      EXPECT_TRUE(image.counters.stopped);
    }
  }
}

TEST_P(AdaptiveFrame, StoppedBeforeTheFirstSample) {
  const RenderedImage image = stop_after(*scene_, settings(), 0);
  EXPECT_TRUE(image.counters.stopped);
  EXPECT_EQ(image.counters.samples, sum_of_counts(image));
}

// One sample in 8192 is NaN, chosen by its own random number.
class SometimesNan final : public Integrator {
 public:
  void estimate(const SampleBatch& /*batch*/, PixelSamples& samples,
                std::span<SampleValue> values) const override {
    for (size_t i = 0; i < values.size(); ++i) {
      samples.resume_sample(int(i));
      samples.start_slot(1);
      const float u = samples.get(0);
      values[i].radiance = Rgb(u < 0x1p-13f ? std::numeric_limits<float>::quiet_NaN() : u);
    }
  }
};

class NullSink final : public RenderSink {
  void tile_finished(const FilmTile& /*tile*/) override {}
};

// Law 4 with --unbiased, where each round has its own seed: the report on a non-finite sample is
// enough to compute that sample again.
TEST(AdaptiveUnbiased, ALaterRoundsNanIsReplayedFromItsSeed) {
  const auto scene = busy_scene();
  RenderSettings s = settings_for(find_estimator(kDefaultEstimator));
  s.adaptive.unbiased = true;
  const Camera camera(busy_view(), s.width, s.height, scene->origin(), scene->scale());
  RenderPlan plan = plan_of(s);
  plan.integrator = std::make_unique<SometimesNan>();
  const Frame frame = plan.frame(*scene, camera);
  NullSink null_sink;
  const RenderCounters counters = RenderJob(frame, driver_factory("adaptive", plan.driver_settings))
                                      .render(null_sink, {})
                                      .counters;
  ASSERT_FALSE(counters.located.empty());
  size_t of_later_rounds = 0;
  for (const NonFiniteSample& at : counters.located) {
    RenderWorker worker(frame);
    worker.set_seed(at.seed);
    EXPECT_TRUE(std::isnan(worker.replay(at.x, at.y, at.sample, nullptr).radiance.x));
    of_later_rounds += at.seed != s.seed;
    if (at.seed == s.seed) continue;
    worker.set_seed(s.seed);
    EXPECT_FALSE(std::isnan(worker.replay(at.x, at.y, at.sample, nullptr).radiance.x));
  }
  EXPECT_GT(of_later_rounds, 0u);
}

// Each bucket decides from its own pixels, so the threads and the bucket order change nothing.
TEST(BucketUnderAThreshold, AnyThreadsAndOrder) {
  const auto scene = busy_scene();
  for (const char* estimator : {"two-stream", "kajiya"}) {
    RenderSettings s = settings_for(find_estimator(estimator));
    s.driver = "bucket";
    s.adaptive.budget = 0;
    s.adaptive.threshold = 0.04f;
    s.adaptive.max_samples = 200;
    s.threads = 1;
    const RenderedImage reference = render(*scene, busy_view(), s);
    EXPECT_GT(reference.counters.max_samples, 2 * reference.counters.min_samples) << estimator;
    EXPECT_EQ(reference.counters.samples, sum_of_counts(reference));
    for (const NamedValue<BucketOrder>& order : bucket_order_table()) {
      s.bucket_order = order.value;
      s.threads = 3;
      const RenderedImage image = render(*scene, busy_view(), s);
      expect_same_bits(image, reference, std::string(order.name) + ", " + estimator);
      // The buckets' errors are added in the order in which the buckets finish, so the sum may
      // differ in rounding.
      ASSERT_TRUE(image.error_estimate && reference.error_estimate);
      EXPECT_NEAR(*image.error_estimate, *reference.error_estimate,
                  1e-12 * *reference.error_estimate);
    }
  }
}

std::vector<std::string_view> estimator_names() {
  std::vector<std::string_view> names;
  for (const EstimatorEntry& entry : estimator_table()) names.push_back(entry.name);
  return names;
}
INSTANTIATE_TEST_SUITE_P(EveryEstimator, AdaptiveFrame, testing::ValuesIn(estimator_names()),
                         [](const auto& p) {
                           std::string name(p.param);
                           std::ranges::replace(name, '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace emberline
