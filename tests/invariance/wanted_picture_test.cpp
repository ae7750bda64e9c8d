// A picture that somebody waits for comes sooner, and changes nothing of what is rendered.
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "support/render.h"
#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

class Impatient final : public FrameObserver {
 public:
  Impatient(RenderedImage& image, bool always) : memory_(image), always_(always) {}
  void tile_finished(const FilmTile& tile) override { memory_.tile_finished(tile); }
  bool picture_wanted() const override { return always_; }
  void picture_changed(const FrameProgress& progress, const FramePicture& /*picture*/) override {
    EXPECT_GE(progress.samples, samples_);
    most_between_ = std::max(most_between_, progress.samples - samples_);
    samples_ = progress.samples;
  }
  // Samples from one pause to the next.
  uint64_t most_between() const { return most_between_; }

 private:
  MemoryObserver memory_;
  const bool always_;
  uint64_t samples_ = 0, most_between_ = 0;
};

class WantedPicture : public testing::TestWithParam<const char*> {
 protected:
  RenderedImage render(bool wanted, int threads, uint64_t* most_between) const {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(threads));
    const Camera camera(perspective({0, 2, 2}, {0, 0, 0}, 40), kWidth, kHeight, scene_->origin(),
                        scene_->scale());
    RenderedImage image;
    image.window = {0, 0, kWidth, kHeight};
    for (const FilmChannel& c : film_channels(AovSet())) image.channels.push_back(c.name);
    image.values.assign(size_t(image.window.area()) * image.channels.size(), 0.0f);
    const Frame frame{*scene_, camera,       *integrator_, *sampler_, filter_,           kWidth,
                      kHeight, image.window, kSpp,         1,         StreamCount::kTwo, {},
                      false};
    Impatient observer(image, wanted);
    DriverSettings settings;
    settings.adaptive.budget = kSpp;
    const std::unique_ptr<FrameDriver> driver = create_driver(GetParam(), settings);
    tbb::task_arena arena(threads);
    arena.execute([&] {
      image.counters = driver->render(frame, observer, {});
      driver->deliver(observer);
    });
    *most_between = observer.most_between();
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
  std::unique_ptr<Integrator> integrator_ = create_integrator("path", {});
  std::unique_ptr<Sampler> sampler_ = create_sampler("sobol", {});
  PixelFilter filter_ = PixelFilter::create("box");
};

TEST_P(WantedPicture, ComesSoonerWithTheSameSamples) {
  constexpr uint64_t kPart = 4096;
  for (const int threads : {1, 2}) {
    SCOPED_TRACE(threads);
    uint64_t patient = 0, wanted = 0;
    const RenderedImage expected = render(false, threads, &patient);
    const RenderedImage image = render(true, threads, &wanted);
    EXPECT_FALSE(image.counters.stopped);
    EXPECT_EQ(image.counters.samples, expected.counters.samples);
    EXPECT_EQ(image.values, expected.values);
    EXPECT_GE(patient, uint64_t(threads) * 16 * kPart - kPart) << "a slice of parts";
    EXPECT_LE(wanted, uint64_t(threads) * 2 * kPart) << "a part for each thread, or little more";
  }
}

INSTANTIATE_TEST_SUITE_P(ProgressiveDrivers, WantedPicture,
                         testing::Values("bisection", "adaptive"),
                         [](const auto& driver) { return std::string(driver.param); });

}  // namespace
}  // namespace emberline
