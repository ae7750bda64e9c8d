// What the settings of a frame come to before there is a scene, and the one place where a frame is
// made of them.
#pragma once

#include <memory>
#include <stop_token>

#include "integrators/integrator.h"
#include "renderer/core/rect.h"
#include "renderer/drivers/driver_table.h"
#include "renderer/drivers/frame.h"
#include "renderer/engine/frame_settings.h"
#include "renderer/film/filter.h"
#include "renderer/scene/build_scene.h"
#include "samplers/sampler.h"

namespace emberline {

// What a frame needs besides, where it has it.
struct FrameInputs {
  const LightGroups* groups = nullptr;
  const CryptomatteIds* cryptomattes = nullptr;
  const SurfaceRoles* roles = nullptr;
  // The lights are looked for until it is requested (renderer/scene/light_survey.h): no sample of
  // the frame may be made then, as FrameRender makes none.
  std::stop_token stop = {};
};

struct FramePlan {
  // Looks all names up, and checks ranges and combinations. Throws UsageError that names the
  // option, the reason and what is valid.
  explicit FramePlan(const FrameSettings& settings);

  // Refers to the plan, the scene, the camera and what is in `inputs`.
  Frame frame(const Scene& scene, const Camera& camera, const FrameInputs& inputs = {}) const;

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
  // Before a frame begins, some 20 ms of one thread for 10^5 triangles (EmptyPixels). The bits are
  // the same: those who wait for the first picture do without.
  bool find_empty_pixels = true;
  bool guides_lights = false;  // where that pays (renderer/scene/light_survey.h)
  SceneBuildOptions build;     // what the settings want of the scene
  PixelFilter filter;
  std::unique_ptr<Integrator> integrator;
  std::unique_ptr<Sampler> sampler;
};

// Every pixel gets the same number of samples. Throws UsageError for a driver that there is not.
bool shares_evenly(const FrameSettings& settings);

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
