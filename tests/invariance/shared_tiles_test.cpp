// At the end of a frame of tiles, a thread without a tile helps another thread with its tile
// (render_loop.h).
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <set>
#include <thread>

#include "renderer/drivers/driver_table.h"
#include "renderer/engine/render_job.h"
#include "renderer/film/film.h"
#include "support/busy_scene.h"
#include "support/render.h"

namespace emberline {
namespace {

using namespace test;

constexpr int kThreads = 3;

// Each thread waits at its first report until all threads have reported, or a minute has passed.
class BarrierSink : public RenderSink {
 public:
  void tile_finished(const FilmTile& tile) override {
    for (const Rect r = tile.rect(); const int y : {r.y0, r.y1 - 1}) {
      min_count_ = std::min(min_count_, tile.sample_count(r.x0, y));
    }
    ++tiles_;
  }
  void samples_finished(uint64_t count) override {
    std::unique_lock lock(mutex_);
    samples_ += count;
    threads_.insert(std::this_thread::get_id());
    all_arrived_.notify_all();
    all_arrived_.wait_for(lock, std::chrono::minutes(1),
                          [&] { return threads_.size() == kThreads; });
    reported(lock);
  }

  size_t threads() const { return threads_.size(); }
  uint64_t samples() const { return samples_; }
  uint32_t min_count() const { return min_count_; }
  int tiles() const { return tiles_; }

 private:
  virtual void reported(std::unique_lock<std::mutex>& /*lock*/) {}

  std::mutex mutex_;
  std::condition_variable all_arrived_;
  std::set<std::thread::id> threads_;
  uint64_t samples_ = 0;
  uint32_t min_count_ = UINT32_MAX;
  int tiles_ = 0;
};

class SharedTile : public testing::Test {
 protected:
  SharedTile() : scene_(busy_scene()) {
    settings_.width = 37;
    settings_.height = 29;
    settings_.bucket_size = 64;  // one tile
    settings_.spp = 32;
    settings_.threads = kThreads;
  }

  RenderCounters render_for(RenderSink& sink, const std::stop_token& stop = {}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, kThreads);
    const Camera camera(busy_view(), settings_.width, settings_.height, scene_->origin(),
                        scene_->scale());
    const RenderPlan plan = plan_of(settings_);
    const Frame frame = plan.frame(*scene_, camera);
    RenderJob job(frame, driver_factory(settings_.driver, plan.driver_settings));
    tbb::task_arena arena(kThreads);
    return arena.execute([&] { return job.render(sink, stop).counters; });
  }

  const std::unique_ptr<Scene> scene_;
  RenderSettings settings_;
};

TEST_F(SharedTile, IsRenderedByAllThreads) {
  BarrierSink sink;
  const RenderCounters counters = render_for(sink);
  EXPECT_EQ(sink.threads(), size_t(kThreads));
  EXPECT_EQ(sink.tiles(), 1);
  EXPECT_EQ(sink.min_count(), settings_.spp);
  const uint64_t samples = 37 * 29 * settings_.spp;
  EXPECT_EQ(counters.samples, samples);
  EXPECT_EQ(sink.samples(), samples);
  EXPECT_EQ(counters.min_samples, settings_.spp);
  EXPECT_EQ(counters.max_samples, settings_.spp);
  EXPECT_FALSE(counters.stopped);
  settings_.threads = 1;
  EXPECT_EQ(counters.rays.total(), render(*scene_, busy_view(), settings_).counters.rays.total());
}

// The same with decisions between rounds. The helpers come back for each round.
TEST_F(SharedTile, OfManyRoundsHasTheBitsOfOneThread) {
  settings_.adaptive.threshold = 0.05f;
  settings_.adaptive.budget = settings_.adaptive.max_samples = 128;
  settings_.aovs = "variance,albedo";
  settings_.threads = 1;
  const RenderedImage one = render(*scene_, busy_view(), settings_);
  EXPECT_GT(one.counters.max_samples, one.counters.min_samples);
  settings_.threads = kThreads;
  const RenderedImage three = render(*scene_, busy_view(), settings_);
  expect_same_bits(three, one, "three threads");
  EXPECT_EQ(three.counters.samples, one.counters.samples);
  EXPECT_EQ(three.counters.rays.total(), one.counters.rays.total());
  BarrierSink sink;
  EXPECT_EQ(render_for(sink).samples, one.counters.samples);
  EXPECT_EQ(sink.threads(), size_t(kThreads));
}

// Whichever thread throws, the frame ends soon and the exception reaches the caller.
TEST_F(SharedTile, AnExceptionEndsTheFrame) {
  struct Throws final : BarrierSink {
    explicit Throws(int the_thrower) : thrower(the_thrower) {}
    void reported(std::unique_lock<std::mutex>& lock) override {
      if (reports++ == thrower) throw RenderError("the sink had enough");
      // Unwinding a stack takes longer than rendering a part, so the other threads wait.
      if (lock.unlock(); reports > thrower)
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    const int thrower;
    std::atomic<int> reports = 0;
  };
  for (const int thrower : {0, 1, 2, 20}) {
    Throws sink(thrower);
    EXPECT_THROW(render_for(sink), RenderError) << thrower;
    EXPECT_EQ(sink.tiles(), 0);
    EXPECT_LE(sink.reports, thrower + 3 * kThreads);  // of 27 reports
  }
}

TEST_F(SharedTile, StopsSoonAndCountsItsSamples) {
  struct Stops final : BarrierSink {
    void reported(std::unique_lock<std::mutex>&) override { source.request_stop(); }
    std::stop_source source;
  } sink;
  const RenderCounters counters = render_for(sink, sink.source.get_token());
  EXPECT_TRUE(counters.stopped);
  EXPECT_EQ(sink.samples(), counters.samples);
  EXPECT_LT(counters.samples, 37 * 29 * settings_.spp);
  EXPECT_GT(counters.samples, 0u);
  EXPECT_EQ(counters.min_samples, 0u);
}

}  // namespace
}  // namespace emberline
