// What the settings of a frame come to before there is a scene, and the one place where a frame is
// made of them.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>

#include "integrators/integrator.h"
#include "renderer/core/rect.h"
#include "renderer/drivers/driver_table.h"
#include "renderer/drivers/frame.h"
#include "renderer/engine/frame_settings.h"
#include "renderer/engine/render_job.h"
#include "renderer/engine/scene_parts.h"
#include "renderer/film/filter.h"
#include "renderer/scene/build_scene.h"
#include "samplers/sampler.h"

namespace emberline {

class OpenScene;

// What a client wants of its frames beside what the settings say.
struct PrepareOptions {
  // The channels, in place of those that the settings ask for.
  std::optional<AovSet> aovs = {};
  // Before a frame begins, some 20 ms of one thread for 10^5 triangles (EmptyPixels). The bits are
  // the same: clients that wait for the first picture do without.
  bool find_empty_pixels = true;
  std::optional<Vec2i> explained = {};  // the pixel that RenderJob::explain is asked about
  bool keep_tree = false;               // RenderJob::facts() is asked for the refinement tree
  bool extending = false;               // RenderJob::extend() is called
};

struct RenderPlan {
  // Looks all names up, and checks ranges and combinations. Throws UsageError that names the
  // option, the reason and what is valid.
  explicit RenderPlan(const FrameSettings& settings, const PrepareOptions& options = {});

  // A job refers to the plan, the scene and its parts, and the camera. The lights are looked for
  // until a stop is requested (renderer/scene/light_survey.h); no sample may be made then, as
  // RenderJob makes none.
  std::unique_ptr<RenderJob> prepare(const OpenScene& scene, const Camera& camera,
                                     const std::stop_token& stop) const;
  Frame frame(const Scene& scene, const Camera& camera, const SceneParts& parts = {},
              const std::stop_token& stop = {}) const;
  DriverFactory drivers() const { return driver_factory(driver->name, driver_settings); }
  // How many buckets there are for the frame's parts to share. Throws UsageError for too many.
  size_t buckets() const;

  const DriverEntry* driver;
  DriverSettings driver_settings;
  int width, height;
  Rect crop;  // the whole frame, if it is not cropped
  uint32_t first_sample = 0;
  uint32_t samples_per_pixel = 0;  // of every pixel, or on average; 0: until the threshold is met
  bool even = true;                // every pixel gets as many
  uint32_t seed;
  StreamCount streams = StreamCount::kOne;
  static constexpr uint32_t kStreamBlock = 8;
  uint32_t half_block = kStreamBlock;  // Frame::half_block
  AovSet aovs;
  double shutter_frames;
  float clamp_indirect;  // 0: nothing is clamped
  bool find_empty_pixels;
  bool guides_lights = false;  // where that pays (renderer/scene/light_survey.h)
  SceneBuildOptions build;     // what the settings want of the scene
  PixelFilter filter;
  std::unique_ptr<Integrator> integrator;
  std::unique_ptr<Sampler> sampler;
};

// Every pixel gets the same number of samples. Throws UsageError for a driver that there is not.
bool shares_evenly(const FrameSettings& settings);

// The driver finishes one tile after another and shows no picture of the whole frame before.
bool finishes_tiles(const FrameSettings& settings);

// The name of the error that samples are shared out by; empty where the frame shares evenly or its
// estimator says only which pixels are not finished.
std::string_view allocation_of(const FrameSettings& settings);

// The settings ask for a denoised picture, by name or because samples are to go where it gains.
bool denoises(const FrameSettings& settings);

// The channels that the settings ask for, by name or because something needs them.
AovSet aovs_of(const FrameSettings& settings);

// A frame whose pixels have fewer samples, all of them or the least, has no eight for each of two
// streams: its halves are the first and the second half of so many samples, and so on.
inline constexpr uint32_t kLeastStreamSamples = 16;

// The crop, or the whole frame.
Rect crop_of(const FrameSettings& settings);

}  // namespace emberline
