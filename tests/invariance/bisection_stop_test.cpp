// A bisection frame that is stopped at any moment ends soon, with a complete picture and true
// counts.
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <thread>

#include "renderer/drivers/bisection_schedule.h"
#include "renderer/drivers/driver_table.h"
#include "renderer/engine/render_job.h"
#include "renderer/film/film.h"
#include "samplers/pixel_samples.h"
#include "support/long_tests.h"
#include "support/processor_time.h"
#include "support/render.h"
#include "support/scenes.h"
#include "support/stop_after.h"

namespace emberline {
namespace {

using namespace test;

// Returns a scene that is bright everywhere, a grey floor under a white sky.
std::unique_ptr<Scene> bright_scene() {
  SceneBuilderForTests b;
  b.add_floor(1, 0, b.add_material(lambert(Rgb(0.5f))));
  b.set_environment(Rgb(1.0f));
  return b.build();
}

class BisectionStop : public testing::Test {
 protected:
  // Renders until `samples` samples are done, and returns the image as delivered.
  RenderedImage stop_after(uint64_t samples, BisectionAxis axis, int threads, uint32_t spp,
                           JobProgress* progress = nullptr) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(threads));
    const Camera camera(perspective({0, 2, 2}, {0, 0, 0}, 40), kWidth, kHeight, scene_->origin(),
                        scene_->scale());
    RenderSettings settings;
    settings.width = kWidth;
    settings.height = kHeight;
    settings.crop = {3, 2, kWidth - 4, kHeight};
    settings.spp = spp;
    settings.driver = "bisection";
    settings.bisection_axis = axis;
    settings.bucket_size = 16;
    settings.aovs = "stop";
    const RenderPlan plan = plan_of(settings);
    const Frame frame = plan.frame(*scene_, camera);
    RenderedImage image = blank_image(plan);
    MemorySink memory(image);
    StopAfter sink(memory, samples, image.crop, true);
    RenderJob job(frame, driver_factory("bisection", plan.driver_settings));
    tbb::task_arena arena(threads);
    arena.execute([&] {
      image.counters = job.render(sink, sink.token()).counters;
      job.deliver(sink);
    });
    if (progress) *progress = sink.last();
    return image;
  }

  static constexpr int kWidth = 83, kHeight = 61;
  std::unique_ptr<Scene> scene_ = bright_scene();
};

TEST_F(BisectionStop, AtAnyMomentThePictureIsCompleteAndTheCountsTrue) {
  constexpr uint32_t kSpp = 7;  // passes of 1, 1, 2, 3
  const RenderedImage whole = stop_after(uint64_t(1) << 40, BisectionAxis::kBoth, 2, kSpp);
  EXPECT_FALSE(whole.counters.stopped);
  const auto pixels = uint64_t(whole.crop.area());
  for (const NamedValue<BisectionAxis>& axis : bisection_axis_table()) {
    for (const int threads : {1, 3}) {
      for (uint64_t samples = 1; samples < kSpp * pixels;
           samples += 1 + samples / long_or_short(3, 1)) {
        SCOPED_TRACE(std::string(axis.name) + ", " + std::to_string(threads) + " threads, after " +
                     std::to_string(samples) + " samples");
        const RenderedImage image = stop_after(samples, axis.value, threads, kSpp);
        uint64_t total = 0;
        uint32_t least = kSpp, most = 0;
        for (int y = image.crop.y0; y < image.crop.y1; ++y) {
          for (int x = image.crop.x0; x < image.crop.x1; ++x) {
            const float* p = image.pixel(x, y);
            for (int c = 0; c < 4; ++c) ASSERT_GT(p[c], 0.0f) << x << "," << y;
            const auto count = uint32_t(p[4]);
            total += count;
            least = std::min(least, count);
            most = std::max(most, count);
            const PixelStop stop = count == 0      ? PixelStop::kNone
                                   : count == kSpp ? PixelStop::kBudget
                                                   : PixelStop::kTimeLimit;
            ASSERT_EQ(p[5], float(stop)) << x << "," << y << " with " << count << " samples";
            // A finished pixel equals the same pixel of the whole frame.
            if (count == kSpp) {
              ASSERT_EQ(p[0], whole.pixel(x, y)[0]);
            }
          }
        }
        EXPECT_EQ(image.counters.samples, total);
        EXPECT_EQ(image.counters.min_samples, least);
        EXPECT_EQ(image.counters.max_samples, most);
        EXPECT_EQ(image.counters.stopped, total < kSpp * pixels);
        EXPECT_GE(total, std::min(samples, kSpp * pixels));
      }
    }
  }
}

TEST_F(BisectionStop, BeforeTheFirstSample) {
  const RenderedImage image = stop_after(0, BisectionAxis::kBoth, 1, 4);
  EXPECT_TRUE(image.counters.stopped);
  EXPECT_EQ(image.counters.min_samples, 0u);
}

TEST_F(BisectionStop, ProgressEndsWithTheWholeFrame) {
  JobProgress progress;
  const RenderedImage image = stop_after(uint64_t(1) << 40, BisectionAxis::kRows, 2, 12, &progress);
  EXPECT_EQ(progress.pass, 5);  // passes of 1, 1, 2, 4 and 4 samples
  EXPECT_EQ(progress.completion, 1.0);
  EXPECT_TRUE(progress.pass_finished);
  EXPECT_EQ(progress.samples, 12 * uint64_t(image.crop.area()));
}

// Requests a stop during batch number `batch`.
class StopsInBatch final : public Integrator {
 public:
  StopsInBatch(const Integrator& inner, int batch) : inner_(inner), batch_(batch) {}
  void estimate(const SampleBatch& batch, PixelSamples& samples,
                std::span<SampleValue> values) const override {
    inner_.estimate(batch, samples, values);
    if (++done_ == batch_) stop_.request_stop();
  }
  std::stop_token token() const { return stop_.get_token(); }
  int done() const { return done_; }

 private:
  const Integrator& inner_;
  int batch_;
  mutable std::atomic<int> done_{0};
  mutable std::stop_source stop_;
};

// In the last pass, the lowest sample count may change after any batch. A stop in the very last
// batch leaves nothing undone.
TEST_F(BisectionStop, WithinTheLastPass) {
  constexpr uint32_t kSpp = 64;  // the last pass has two batches for each pixel
  RenderSettings settings;
  settings.width = 9;
  settings.height = 7;
  settings.spp = kSpp;
  RenderPlan plan = plan_of(settings);
  const auto path = create_integrator("path", {});
  const Camera camera(perspective({0, 2, 2}, {0, 0, 0}, 40), 9, 7, scene_->origin(),
                      scene_->scale());
  int all = 1 << 30;
  for (int left = -1; left < 130; ++left) {  // the first run counts the batches
    auto stops = std::make_unique<StopsInBatch>(*path, left < 0 ? all : all - left);
    const StopsInBatch& integrator = *stops;
    plan.integrator = std::move(stops);
    const Frame frame = plan.frame(*scene_, camera);
    RenderedImage image = blank_image(plan);
    MemorySink sink(image);
    RenderJob job(frame, driver_factory("bisection", {}));
    tbb::task_arena arena(1);
    RenderCounters counters;
    arena.execute([&] {
      counters = job.render(sink, integrator.token()).counters;
      job.deliver(sink);
    });
    if (left < 0) {
      all = integrator.done();
      continue;
    }
    uint32_t least = kSpp;
    for (int y = 0; y < 7; ++y) {
      for (int x = 0; x < 9; ++x) least = std::min(least, uint32_t(image.pixel(x, y)[4]));
    }
    ASSERT_EQ(counters.min_samples, least) << left << " batches before the end";
    ASSERT_EQ(counters.stopped, left > 0) << left << " batches before the end";
  }
}

// Paths have hundreds of bounces, so a round takes a second.
TEST_F(BisectionStop, IsSoonInAHeavyScene) {
  SceneBuilderForTests b;
  b.place(b.add_mesh(
      SceneBuilderForTests::sphere(5.0f, 24, b.add_material(lambert(Rgb(0.999f))), true)));
  b.place(b.add_mesh(SceneBuilderForTests::sphere(0.2f, 6, b.add_material(emitter(Rgb(5.0f))))),
          translation(0, 3, 0));
  scene_ = b.build();
  const Camera camera(perspective({0, 0, 2}, {0, 0, 0}, 60), 256, 256, scene_->origin(),
                      scene_->scale());
  RenderSettings settings;
  settings.width = settings.height = 256;
  settings.spp = 1 << 16;
  settings.max_depth = 1000;
  const RenderPlan plan = plan_of(settings);
  const Frame frame = plan.frame(*scene_, camera);
  class SilentSink final : public RenderSink {
    void tile_finished(const FilmTile&) override {}
  } silent_sink;
  // Measures how many rays all threads trace after the request: the share of the CPU time after it,
  // times all rays. Other programs lengthen both times. The result is the minimum of several runs.
  double least = 1e9;
  for (const double work : {0.04, 0.1, 0.18, 0.28, 0.4}) {
    std::stop_source stop;
    double requested = 0;
    const double began = test::processor_seconds();
    std::thread timer([&] {
      test::wait_for_work(work);
      requested = test::processor_seconds();
      stop.request_stop();
    });
    RenderJob job(frame, driver_factory("bisection", {}));
    const RenderCounters counters = job.render(silent_sink, stop.get_token()).counters;
    const double returned = test::processor_seconds();
    timer.join();
    EXPECT_TRUE(counters.stopped);
    const double share = (returned - requested) / (returned - began);
    least = std::min(least, share * double(counters.rays.total()));
  }
  // A round has a million rays.
  EXPECT_LT(least, std::min(1.5e4 * std::thread::hardware_concurrency(), 2e5));
}

}  // namespace
}  // namespace emberline
