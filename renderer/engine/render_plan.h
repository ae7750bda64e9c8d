// Checked settings of a frame, and the one place where they become a frame.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string_view>

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

// Choices of a client that are no settings.
struct PrepareOptions {
  // Replaces the channels that the settings request.
  std::optional<AovSet> aovs = {};
  // Takes some 20 ms of one thread per 10^5 triangles before the frame begins (EmptyPixels). The
  // bits are the same; clients that wait for the first picture do without.
  bool find_empty_pixels = true;
  std::optional<Vec2i> explained = {};  // the pixel for RenderJob::explain()
  bool keep_tree = false;               // RenderJob::facts() has the refinement tree
  bool extending = false;               // RenderJob::extend() will be called
};

// A frame in part or in advance: some of its pixels, with fewer samples each or by another driver.
struct StageOptions {
  std::string_view driver;
  Rect crop;
  uint32_t samples_per_pixel = 0;
  std::optional<Vec2i> explained = {};        // as in PrepareOptions
  const LightGroups* light_groups = nullptr;  // kept apart in its film
};

struct RenderPlan {
  // Looks up names, and checks ranges and combinations. Throws UsageError that names the setting,
  // the reason and the valid values.
  explicit RenderPlan(const FrameSettings& settings, const PrepareOptions& options = {});

  // The plan, scene and camera must outlive the job. May survey the lights first
  // (renderer/scene/light_survey.h), until a stop is requested; such a job must not render.
  std::unique_ptr<RenderJob> prepare(const OpenScene& scene, const Camera& camera,
                                     const std::stop_token& stop) const;
  // With these parts in place of the open scene's.
  std::unique_ptr<RenderJob> prepare(const OpenScene& scene, const Camera& camera,
                                     const SceneParts& parts, const std::stop_token& stop) const;
  // A job for a stage, without roles and mattes. Its samples are those of the frame, unless the
  // sampler weighs them by their number.
  std::unique_ptr<RenderJob> prepare_stage(const OpenScene& scene, const Camera& camera,
                                           const StageOptions& stage) const;
  // The frame alone. A shutter that an edits file has is not in it: prepare() knows the scene's.
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
  uint32_t samples_per_pixel = 0;  // of each pixel, or on average; 0: until the threshold is met
  bool even = true;                // every pixel gets as many
  uint32_t seed;
  StreamCount streams = StreamCount::kOne;
  static constexpr uint32_t kStreamBlock = 8;
  uint32_t half_block = kStreamBlock;  // Frame::half_block
  AovSet aovs;
  double shutter_frames;
  float clamp_indirect;  // 0: nothing is clamped
  bool find_empty_pixels;
  bool guides_lights = false;  // if the light survey finds that it pays
  SceneBuildOptions build;
  PixelFilter filter;
  std::unique_ptr<Integrator> integrator;
  std::unique_ptr<Sampler> sampler;
};

// Whether every pixel gets the same number of samples. Throws UsageError for an unknown driver.
bool shares_evenly(const FrameSettings& settings);

// Whether the driver finishes one tile after another and shows no picture of the whole frame
// before.
bool finishes_tiles(const FrameSettings& settings);

// The name of the error by which samples are shared out. Empty where the frame shares evenly or its
// estimator says only which pixels are not finished.
std::string_view allocation_of(const FrameSettings& settings);

// Whether the settings request a denoised picture, directly or for `allocation` denoised.
bool denoises(const FrameSettings& settings);

// The channels that the settings request, directly or because another setting needs them.
AovSet aovs_of(const FrameSettings& settings);

// Below this number of samples a pixel cannot have blocks of eight for each of two streams: its
// halves are then the first and the second half of its samples.
inline constexpr uint32_t kLeastStreamSamples = 16;

// The crop, or the whole frame.
Rect crop_of(const FrameSettings& settings);

}  // namespace emberline
