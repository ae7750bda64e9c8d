#include "support/render.h"
#include "renderer/film/film.h"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace emberline::test {

void MemorySink::tile_finished(const FilmTile& tile) {
  std::vector<float> pixels;
  tile.resolve(pixels);
  const size_t channels = image_.channels.size();
  const Rect& r = tile.rect();
  const std::lock_guard lock(mutex_);
  for (int y = r.y0; y < r.y1; ++y) {
    const size_t from = size_t(y - r.y0) * size_t(r.width()) * channels;
    const size_t to =
        (size_t(y - image_.crop.y0) * size_t(image_.crop.width()) + size_t(r.x0 - image_.crop.x0)) *
        channels;
    std::copy_n(&pixels[from], size_t(r.width()) * channels, &image_.values[to]);
    for (int x = r.x0; x < r.x1 && image_.light_groups > 0; ++x) store_lights(tile, x, y);
  }
}

void MemorySink::store_lights(const FilmTile& tile, int x, int y) {
  const auto groups = size_t(image_.light_groups);
  for (size_t g = 0; g < groups; ++g) {
    image_.lights[image_.crop.index_of(x, y) * groups + g] =
        tile.lights(tile.rect().index_of(x, y)).mean(int(g));
  }
}

RenderPlan plan_of(const RenderSettings& s) {
  FrameSettings settings = s;
  settings.driver = "bucket";
  settings.spp = s.spp;
  settings.streams = int(s.streams);
  if (!s.crop.empty()) settings.crop = s.crop;
  RenderPlan plan(settings);
  plan.driver = &find_driver(s.driver);
  plan.driver_settings.adaptive = s.adaptive;
  plan.is_uniform = s.driver != "adaptive" && s.adaptive.threshold <= 0.0f;
  plan.find_empty_pixels = s.find_empty_pixels;
  if (!plan.is_uniform) plan.samples_per_pixel = s.adaptive.budget;
  return plan;
}

RenderedImage blank_image(const RenderPlan& plan) {
  RenderedImage image;
  image.crop = plan.crop;
  for (const PictureChannel& c : film_channels(plan.aovs)) image.channels.push_back(c.name);
  image.values.assign(size_t(image.crop.area()) * image.channels.size(), 0.0f);
  return image;
}

RenderedImage render(const Scene& scene, const CameraDescription& view, const RenderSettings& s,
                     const LightGroups* groups,
                     const std::function<void(const LivePicture*)>& on_picture,
                     const SurfaceRoles* roles) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(s.threads));
  const Camera camera(view, s.width, s.height, scene.origin(), scene.scale());
  const RenderPlan plan = plan_of(s);
  const Frame frame = plan.frame(scene, camera, {.light_groups = groups, .roles = roles});
  RenderedImage image = blank_image(plan);
  if (groups) {
    image.light_groups = groups->size();
    image.lights.resize(size_t(image.crop.area()) * size_t(groups->size()));
  }
  MemorySink sink(image);
  // A TBB arena runs as many threads as requested, even if there are fewer cores.
  tbb::task_arena arena(s.threads);
  RenderJob job(frame, driver_factory(s.driver, plan.driver_settings));
  arena.execute([&] {
    image.counters = job.render(sink, {}).counters;
    job.deliver(sink);
    image.error_estimate = job.error_estimate();
    if (on_picture) on_picture(job.picture());
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

void expect_same_bits(const RenderedImage& a, const RenderedImage& b, const std::string& what) {
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
