// A picture that a client waits for comes sooner, and what is rendered does not change.
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "renderer/drivers/driver_table.h"
#include "renderer/engine/render_job.h"
#include "renderer/film/film.h"
#include "support/render.h"
#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

struct PictureRequests {
  bool always = false;
  std::vector<uint64_t> at = {};
};

class RequestingSink final : public RenderSink {
 public:
  RequestingSink(RenderedImage& image, const PictureRequests& requests)
      : memory_(image), requests_(requests) {}
  void tile_finished(const FilmTile& tile) override { memory_.tile_finished(tile); }
  bool needs_picture() const override { return requests_.always; }
  std::optional<uint64_t> next_picture_at() const override {
    if (arrived_.size() == requests_.at.size()) return std::nullopt;
    return requests_.at[arrived_.size()];
  }
  void picture_changed(const JobProgress& progress, const LivePicture& /*picture*/) override {
    EXPECT_GE(progress.samples, samples_);
    max_interval_ = std::max(max_interval_, progress.samples - samples_);
    samples_ = progress.samples;
    while (arrived_.size() < requests_.at.size() && samples_ >= requests_.at[arrived_.size()]) {
      arrived_.push_back(samples_);
    }
  }
  // The largest number of samples between two pictures.
  uint64_t max_interval() const { return max_interval_; }
  // Sample counts at which the requested pictures arrived.
  const std::vector<uint64_t>& arrived() const { return arrived_; }

 private:
  MemorySink memory_;
  const PictureRequests requests_;
  uint64_t samples_ = 0, max_interval_ = 0;
  std::vector<uint64_t> arrived_;
};

class WantedPicture : public testing::TestWithParam<const char*> {
 protected:
  RenderedImage render(const PictureRequests& requests, int threads, uint64_t* max_interval,
                       std::vector<uint64_t>* arrived = nullptr) const {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(threads));
    const Camera camera(perspective({0, 2, 2}, {0, 0, 0}, 40), kWidth, kHeight, scene_->origin(),
                        scene_->scale());
    RenderSettings settings;
    settings.width = kWidth;
    settings.height = kHeight;
    settings.spp = settings.adaptive.budget = kSpp;
    settings.streams = StreamCount::kTwo;
    settings.driver = GetParam();
    settings.bucket_size = 64;
    RenderPlan plan = plan_of(settings);
    plan.is_uniform = false;
    RenderedImage image = blank_image(plan);
    const Frame frame = plan.frame(*scene_, camera);
    RequestingSink sink(image, requests);
    RenderJob job(frame, driver_factory(GetParam(), plan.driver_settings));
    tbb::task_arena arena(threads);
    arena.execute([&] {
      image.counters = job.render(sink, {}).counters;
      job.deliver(sink);
    });
    *max_interval = sink.max_interval();
    if (arrived) *arrived = sink.arrived();
    return image;
  }

  static std::unique_ptr<Scene> floor_under_a_sky() {
    SceneBuilderForTests b;
    b.add_floor(1, 0, b.add_material(lambert(Rgb(0.5f))));
    b.set_environment(Rgb(1.0f));
    return b.build();
  }

  static constexpr int kWidth = 167, kHeight = 121;
  static constexpr uint32_t kSpp = 64;
  std::unique_ptr<Scene> scene_ = floor_under_a_sky();
};

constexpr uint64_t kPart = 4096;

TEST_P(WantedPicture, ArrivesSoonerWithTheSameSamples) {
  for (const int threads : {1, 2}) {
    SCOPED_TRACE(threads);
    uint64_t patient = 0, wanted = 0;
    const RenderedImage expected = render({}, threads, &patient);
    const RenderedImage image = render({.always = true}, threads, &wanted);
    EXPECT_FALSE(image.counters.stopped);
    EXPECT_EQ(image.counters.samples, expected.counters.samples);
    EXPECT_EQ(image.values, expected.values);
    EXPECT_GE(patient, 16u * kWidth * kHeight) << "a pass, or a round";
    EXPECT_LE(wanted, uint64_t(threads) * 2 * kPart) << "a part for each thread, or little more";
  }
}

TEST_P(WantedPicture, ArrivesWithThePartThatAddsTheSamples) {
  PictureRequests requests;
  for (uint64_t samples = 500; samples < 60u * kWidth * kHeight; samples += 500 + samples / 3) {
    requests.at.push_back(samples);
  }
  uint64_t max_interval = 0;
  std::vector<uint64_t> one, arrived;
  const RenderedImage expected = render({}, 1, &max_interval);
  render(requests, 1, &max_interval, &one);
  const RenderedImage image = render(requests, 2, &max_interval, &arrived);
  EXPECT_EQ(image.values, expected.values);
  EXPECT_EQ(arrived, one) << "whatever the threads";
  ASSERT_EQ(arrived.size(), requests.at.size());
  for (size_t i = 0; i < arrived.size(); ++i) {
    EXPECT_LT(arrived[i], requests.at[i] + kPart + 4 * kSpp)
        << "a part, whose last pixel is not cut";
  }
}

INSTANTIATE_TEST_SUITE_P(ProgressiveDrivers, WantedPicture,
                         testing::Values("bisection", "adaptive"),
                         [](const auto& driver) { return std::string(driver.param); });

}  // namespace
}  // namespace emberline
