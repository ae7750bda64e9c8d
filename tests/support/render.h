// Renders a frame into memory with the same drivers as the command.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "renderer/drivers/driver_table.h"
#include "renderer/engine/render_job.h"
#include "renderer/engine/render_plan.h"
#include "renderer/scene/camera.h"
#include "renderer/scene/light_groups.h"
#include "renderer/scene/scene.h"

namespace emberline::test {

// The settings of a frame, with defaults for tests. crop, spp and streams have types that are
// convenient for tests.
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
  // For the adaptive driver, which ignores spp. With a threshold, also for the bucket driver.
  AdaptiveSettings adaptive;
  bool find_empty_pixels = true;  // see PrepareOptions (renderer/engine/render_plan.h)
  int threads = 2;
};

// The channels of a frame's crop, as an EXR file would contain them.
struct RenderedImage {
  Rect crop;
  std::vector<std::string> channels;
  std::vector<float> values;
  RenderCounters counters;
  std::optional<double> error_estimate;  // the driver's estimate
  int light_groups = 0;
  std::vector<Rgb> lights;  // the mean of each light group in each pixel; groups vary fastest

  const float* pixel(int x, int y) const {
    return &values[(size_t(y - crop.y0) * size_t(crop.width()) + size_t(x - crop.x0)) *
                   channels.size()];
  }
  const Rgb& light(size_t pixel, int group) const {
    return lights[pixel * size_t(light_groups) + size_t(group)];
  }
  Rgb rgb(int x, int y) const { return {pixel(x, y)[0], pixel(x, y)[1], pixel(x, y)[2]}; }

  // The mean of R, G and B over the crop, and the standard error of that mean. The standard error
  // is valid because pixels are independent: every pixel is randomised separately.
  double mean = 0, standard_error = 0;
};

class MemorySink final : public RenderSink {
 public:
  MemorySink(RenderedImage& image) : image_(image) {}
  void tile_finished(const FilmTile& tile) override;

 private:
  void store_lights(const FilmTile& tile, int x, int y);

  RenderedImage& image_;
  std::mutex mutex_;
};

// Prepares a render plan from the settings. Unlike the command, it does not check numbers, names or
// their combinations.
RenderPlan plan_of(const RenderSettings& s);

// Returns an image with the crop and the channels of the plan. Its pixels are black.
RenderedImage blank_image(const RenderPlan& plan);

// Renders a frame. With `groups`, it stores the light of each group separately. `on_picture`, if
// given, is called with the final picture of the driver, or with null if the driver keeps none.
RenderedImage render(const Scene& scene, const CameraDescription& view, const RenderSettings& s,
                     const LightGroups* groups = nullptr,
                     const std::function<void(const LivePicture*)>& on_picture = {},
                     const SurfaceRoles* roles = nullptr);

// Expects that pixels that are in both images have the same bits in every channel.
void expect_same_bits(const RenderedImage& a, const RenderedImage& b, const std::string& what);

}  // namespace emberline::test
