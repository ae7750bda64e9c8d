// Renders a frame in a test: into memory, through the same driver as the command.
#pragma once

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "renderer/drivers/driver_table.h"
#include "renderer/engine/frame_plan.h"
#include "renderer/engine/render_job.h"
#include "renderer/scene/camera.h"
#include "renderer/scene/light_groups.h"
#include "renderer/scene/scene.h"

namespace emberline::test {

// A frame's settings, with defaults for tests. Three of them in the form that tests reckon with.
struct RenderSettings : FrameSettings {
  RenderSettings() {
    width = height = 16;
    seed = 1;
    bucket_size = 8;
    filter = "box";
  }
  Rect crop;  // empty: the whole frame
  uint32_t spp = 16;
  StreamCount streams = StreamCount::kOne;
  AdaptiveSettings adaptive;      // of the adaptive driver, which looks at no spp; with a threshold
                                  // also of the bucket driver
  bool find_empty_pixels = true;  // FramePlan's
  int threads = 2;
};

// The frame's channels over its crop, as the EXR would hold them.
struct RenderedImage {
  Rect crop;
  std::vector<std::string> channels;
  std::vector<float> values;
  FrameCounters counters;
  std::optional<double> error_estimate;  // the driver's own
  int light_groups = 0;
  std::vector<Rgb> lights;  // mean of each light group, by pixel, then by group

  const float* pixel(int x, int y) const {
    return &values[(size_t(y - crop.y0) * size_t(crop.width()) + size_t(x - crop.x0)) *
                   channels.size()];
  }
  const Rgb& light(size_t pixel, int group) const {
    return lights[pixel * size_t(light_groups) + size_t(group)];
  }
  Rgb rgb(int x, int y) const { return {pixel(x, y)[0], pixel(x, y)[1], pixel(x, y)[2]}; }

  // Mean of R, G and B over the crop, and the standard error of that mean taking pixels as
  // independent (they are: every pixel has its own randomisation).
  double mean = 0, standard_error = 0;
};

class MemoryObserver final : public FrameObserver {
 public:
  MemoryObserver(RenderedImage& image) : image_(image) {}
  void tile_finished(const FilmTile& tile) override {
    std::vector<float> pixels;
    tile.resolve(pixels);
    const size_t channels = image_.channels.size();
    const Rect& r = tile.rect();
    const std::lock_guard lock(mutex_);
    for (int y = r.y0; y < r.y1; ++y) {
      const size_t from = size_t(y - r.y0) * size_t(r.width()) * channels;
      const size_t to = (size_t(y - image_.crop.y0) * size_t(image_.crop.width()) +
                         size_t(r.x0 - image_.crop.x0)) *
                        channels;
      std::copy_n(&pixels[from], size_t(r.width()) * channels, &image_.values[to]);
      for (int x = r.x0; x < r.x1 && image_.light_groups > 0; ++x) keep_lights(tile, x, y);
    }
  }

 private:
  void keep_lights(const FilmTile& tile, int x, int y) {
    const auto groups = size_t(image_.light_groups);
    for (size_t g = 0; g < groups; ++g) {
      image_.lights[image_.crop.index_of(x, y) * groups + g] =
          tile.light_groups().mean(tile.rect().index_of(x, y), int(g));
    }
  }

  RenderedImage& image_;
  std::mutex mutex_;
};

// The numbers and names as they are, without the checks that the command makes of them together.
inline FramePlan plan_of(const RenderSettings& s) {
  FrameSettings settings = s;
  settings.driver = "bucket";
  settings.spp = s.spp;
  settings.streams = int(s.streams);
  if (!s.crop.empty()) settings.crop = s.crop;
  FramePlan plan(settings);
  plan.driver = &find_driver(s.driver);
  plan.driver_settings.adaptive = s.adaptive;
  plan.even = s.driver != "adaptive" && s.adaptive.threshold <= 0.0f;
  plan.find_empty_pixels = s.find_empty_pixels;
  if (!plan.even) plan.samples_per_pixel = s.adaptive.budget;
  return plan;
}

// Black pixels of the plan's frame.
inline RenderedImage blank_image(const FramePlan& plan) {
  RenderedImage image;
  image.crop = plan.crop;
  for (const FilmChannel& c : film_channels(plan.aovs)) image.channels.push_back(c.name);
  image.values.assign(size_t(image.crop.area()) * image.channels.size(), 0.0f);
  return image;
}

// With `groups`, what each light gave is kept apart. `look`, if given, sees the driver's picture in
// the end; a driver that keeps none has null.
inline RenderedImage render(const Scene& scene, const CameraDescription& view,
                            const RenderSettings& s, const LightGroups* groups = nullptr,
                            const std::function<void(const FramePicture*)>& look = {},
                            const SurfaceRoles* roles = nullptr) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(s.threads));
  const Camera camera(view, s.width, s.height, scene.origin(), scene.scale());
  const FramePlan plan = plan_of(s);
  const Frame frame = plan.frame(scene, camera, {.light_groups = groups, .roles = roles});
  RenderedImage image = blank_image(plan);
  if (groups) {
    image.light_groups = groups->size();
    image.lights.resize(size_t(image.crop.area()) * size_t(groups->size()));
  }
  MemoryObserver observer(image);
  // An arena makes as many workers as asked for, on a machine with fewer cores too.
  tbb::task_arena arena(s.threads);
  RenderJob job(frame, driver_factory(s.driver, plan.driver_settings));
  arena.execute([&] {
    image.counters = job.render(observer, {}).counters;
    job.deliver(observer);
    image.error_estimate = job.error_estimate();
    if (look) look(job.picture());
  });

  double sum = 0, sum2 = 0;
  const double n = double(image.crop.area());
  for (size_t i = 0; i < image.values.size(); i += image.channels.size()) {
    const double v = (double(image.values[i]) + image.values[i + 1] + image.values[i + 2]) / 3;
    sum += v;
    sum2 += v * v;
  }
  image.mean = sum / n;
  image.standard_error =
      n > 1 ? std::sqrt(std::max(0.0, sum2 / n - image.mean * image.mean) / (n - 1)) : 0;
  return image;
}

// Where both have pixels, these have the same bits in every channel.
inline void expect_same_bits(const RenderedImage& a, const RenderedImage& b,
                             const std::string& what) {
  ASSERT_EQ(a.channels, b.channels);
  const Rect common = a.crop.intersect(b.crop);
  ASSERT_FALSE(common.empty());
  size_t different = 0;
  for (int y = common.y0; y < common.y1; ++y) {
    for (int x = common.x0; x < common.x1; ++x) {
      if (std::memcmp(a.pixel(x, y), b.pixel(x, y), a.channels.size() * sizeof(float)) != 0) {
        if (different++ == 0) {
          ADD_FAILURE() << what << ": pixel " << x << "," << y << " differs: R " << a.pixel(x, y)[0]
                        << " against " << b.pixel(x, y)[0];
        }
      }
    }
  }
  EXPECT_EQ(different, 0u) << what;
}

}  // namespace emberline::test
