// Checks a frame's settings and creates the job that renders the frame.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
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

// Choices that a client makes in addition to the settings.
struct PrepareOptions {
  // Channels that replace those that the settings request.
  std::optional<AovSet> aovs = {};
  // If true, empty pixels (EmptyPixels) are found before the frame begins, which takes one thread
  // about 20 ms per 10^5 triangles. This does not change the bits, so clients that need the first
  // picture soon turn it off.
  bool find_empty_pixels = true;
  std::optional<Vec2i> explained = {};  // the pixel for RenderJob::explain()
  bool keep_tree = false;               // RenderJob::facts() has the refinement tree
  bool is_extension = false;            // RenderJob::extend() will be called
  // The counts in the file of the setting `plan`. Without it, no job of a planned frame can be
  // prepared.
  std::shared_ptr<const SamplePlan> sample_plan = {};
};

// A stage is a preliminary or partial frame, with only some of the pixels, fewer samples or another
// driver.
struct StageOptions {
  std::string_view driver;
  Rect crop;
  uint32_t samples_per_pixel = 0;
  std::optional<Vec2i> explained = {};        // as in PrepareOptions
  const LightGroups* light_groups = nullptr;  // the groups to record in the stage's film
};

struct RenderPlan {
  // Looks up names and checks ranges and combinations of settings. Throws a UsageError that names
  // the setting, the reason and the valid values.
  explicit RenderPlan(const FrameSettings& settings, const PrepareOptions& options = {});

  // Creates the job. The plan, scene and camera must outlive the job. May survey the lights first
  // (renderer/scene/light_survey.h). After a stop request the survey is incomplete, so the job must
  // not be rendered.
  std::unique_ptr<RenderJob> prepare(const OpenScene& scene, const Camera& camera,
                                     const std::stop_token& stop) const;
  // Like the function above, but with `parts` instead of the open scene's parts.
  std::unique_ptr<RenderJob> prepare(const OpenScene& scene, const Camera& camera,
                                     const SceneParts& parts, const std::stop_token& stop) const;
  // Prepares a stage, without roles and mattes. The stage computes the same samples as the frame,
  // unless the sampler's weights depend on the sample count.
  std::unique_ptr<RenderJob> prepare_stage(const OpenScene& scene, const Camera& camera,
                                           const StageOptions& stage) const;
  // Returns the frame without creating a job. Ignores a shutter that the edits set, because only
  // prepare() takes it from the open scene.
  Frame frame(const Scene& scene, const Camera& camera, const SceneParts& parts = {},
              const std::stop_token& stop = {}) const;
  DriverFactory drivers() const { return driver_factory(*driver, driver_settings); }
  // Returns the number of buckets that are divided among the parts of the frame. Throws UsageError
  // if there are too many buckets.
  size_t buckets() const;

  const DriverEntry* driver;
  DriverSettings driver_settings;
  int width, height;
  Rect crop;  // the whole frame by default
  uint32_t first_sample = 0;
  uint32_t samples_per_pixel = 0;  // of each pixel, or on average; 0: until the threshold is met
  bool is_uniform = true;          // every pixel gets the same number of samples
  double time_budget_s = 0;        // as in Frame
  uint32_t seed;                   // sampling_seed()
  StreamCount streams = StreamCount::kOne;
  static constexpr uint32_t kStreamBlock = 8;
  uint32_t half_block = kStreamBlock;  // Frame::half_block
  AovSet aovs;
  double shutter_frames;
  float clamp_indirect;  // 0: no clamping
  bool find_empty_pixels;
  bool guides_lights = false;  // guide light samples if the survey finds that useful
  SceneBuildOptions build;
  PixelFilter filter;
  std::unique_ptr<Integrator> integrator;
  std::unique_ptr<Sampler> sampler;
};

// Returns the number of the frame in its animation: `frame` rounded down, or else the frame of the
// turntable, which is 1 if it has none. Returns 0 if there is neither.
int64_t frame_number(const FrameSettings& settings);

// Returns the seed of all samples. It differs between the frames of an animation, except with
// `static-noise`, so that their noise is independent. It is `seed` for frame 0 without another
// frame of a turntable.
uint32_t sampling_seed(const FrameSettings& settings);

// Returns the driver of frames with these settings. Throws UsageError for an unknown name.
const DriverEntry& driver_of(const FrameSettings& settings);

// Returns whether every pixel gets the same number of samples. Throws UsageError for an unknown
// driver.
bool samples_uniformly(const FrameSettings& settings);

// Returns whether the driver finishes tile by tile and has no picture of the whole frame before the
// end.
bool is_tiled(const FrameSettings& settings);

// The time after which a frame is stopped, and the cause that it is stopped with.
struct TimeLimit {
  double seconds;
  PixelStop cause;
};
// A frame with a time budget is stopped at its end, unless that would leave buckets without
// samples.
std::optional<TimeLimit> time_limit_of(const FrameSettings& settings);

// Returns the error metric by which samples are allocated. The text is empty if every pixel gets
// the same number of samples, or if the error estimate only decides which pixels are finished.
std::string_view allocation_of(const FrameSettings& settings);

// This value of `judge` means all delivered channels.
inline constexpr std::string_view kJudgeDelivered = "delivered";
// Returns the channels that decide about samples; empty if R G B alone do.
std::vector<JudgedChannel> judged_channels_of(const FrameSettings& settings);
// Replaces `judge` by a list of these channels.
void set_judged_channels(std::span<const JudgedChannel> channels, FrameSettings& settings);

// Returns the channels that the settings request or need.
AovSet aovs_of(const FrameSettings& settings);

// Minimum samples per pixel for which each stream gets a block of eight. With fewer samples, the
// halves are the first and the second half of the samples.
inline constexpr uint32_t kMinStreamSamples = 16;

// Returns the crop, which is the whole frame by default.
Rect crop_of(const FrameSettings& settings);

}  // namespace emberline
