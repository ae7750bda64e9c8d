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
  AdaptiveSettings adaptive;      // for the adaptive driver, which ignores spp; with a threshold
                                  // also for the bucket driver
  bool find_empty_pixels = true;  // see RenderPlan
  int threads = 2;
};

// The channels of the frame's crop, as an EXR file would contain them.
struct RenderedImage {
  Rect crop;
  std::vector<std::string> channels;
  std::vector<float> values;
  RenderCounters counters;
  std::optional<double> error_estimate;  // by the driver
  int light_groups = 0;
  std::vector<Rgb> lights;  // means of the light groups, by pixel, then by group

  const float* pixel(int x, int y) const {
    return &values[(size_t(y - crop.y0) * size_t(crop.width()) + size_t(x - crop.x0)) *
                   channels.size()];
  }
  const Rgb& light(size_t pixel, int group) const {
    return lights[pixel * size_t(light_groups) + size_t(group)];
  }
  Rgb rgb(int x, int y) const { return {pixel(x, y)[0], pixel(x, y)[1], pixel(x, y)[2]}; }

  // Mean of R, G and B over the crop, and the standard error of that mean. It assumes independent
  // pixels, which holds because every pixel is randomised separately.
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

// Does not check numbers and names, unlike the command, which also checks their combinations.
RenderPlan plan_of(const RenderSettings& s);

// An image with the frame and channels of the plan, and black pixels.
RenderedImage blank_image(const RenderPlan& plan);

// With `groups`, the light of each group is stored separately. `on_picture`, if given, receives the
// final picture of the driver, or null if the driver keeps none.
RenderedImage render(const Scene& scene, const CameraDescription& view, const RenderSettings& s,
                     const LightGroups* groups = nullptr,
                     const std::function<void(const LivePicture*)>& on_picture = {},
                     const SurfaceRoles* roles = nullptr);

// Expects that the pixels which both images contain have the same bits in every channel.
void expect_same_bits(const RenderedImage& a, const RenderedImage& b, const std::string& what);

}  // namespace emberline::test
