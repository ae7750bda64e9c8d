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
  // If true, pixels that see no surface (EmptyPixels) are found before the frame begins. This takes
  // one thread about 20 ms per 10^5 triangles. It does not change the bits of the picture, so
  // clients that need the first picture soon turn it off.
  bool find_empty_pixels = true;
  std::optional<Vec2i> explained = {};  // the pixel for RenderJob::explain()
  bool keep_tree = false;               // RenderJob::facts() has the refinement tree
  bool is_extension = false;            // RenderJob::extend() will be called
  // The sample counts in the file of the setting `plan`. A frame with that setting needs them.
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
  // (renderer/scene/light_survey.h, integrators/indirect_survey.h). After a stop request the survey
  // is incomplete, so the job must not be rendered. Throws LimitError if the survey needs more
  // memory than the scene's budget has left.
  std::unique_ptr<RenderJob> prepare(const OpenScene& scene, const Camera& camera,
                                     const std::stop_token& stop) const;
  // Like the function above, but uses `parts` instead of the open scene's parts (scene_parts.h).
  std::unique_ptr<RenderJob> prepare(const OpenScene& scene, const Camera& camera,
                                     const SceneParts& parts, const std::stop_token& stop) const;
  // Prepares a stage, without catchers, holdouts and Cryptomattes. The stage computes the same
  // samples as the frame, unless the sampler's weights depend on the sample count.
  std::unique_ptr<RenderJob> prepare_stage(const OpenScene& scene, const Camera& camera,
                                           const StageOptions& stage) const;
  // Returns the frame without creating a job. Ignores a shutter that the edits set; only prepare()
  // reads it, from the open scene. `memory` is for the surveys; null: no limit.
  Frame frame(const Scene& scene, const Camera& camera, const SceneParts& parts = {},
              const std::stop_token& stop = {},
              const std::shared_ptr<MemoryBudget>& memory = nullptr) const;
  DriverFactory drivers() const { return driver_factory(*driver, driver_settings); }
  // Returns the number of buckets in the crop. The setting `part` divides them among jobs. Throws
  // UsageError if there are too many buckets.
  size_t buckets() const;

  const DriverEntry* driver;
  DriverSettings driver_settings;
  int width, height;
  Rect crop;  // the whole frame by default
  uint32_t first_sample = 0;
  uint32_t samples_per_pixel = 0;  // an average if not is_uniform; 0: until the threshold is met
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
  Guiding guiding = Guiding::kOff;  // guide paths to indirect light
  int max_depth = 0;                // IntegratorSettings::max_depth
  bool guides_lights = false;       // guide light samples if the survey finds that useful
  SceneBuildOptions build;
  PixelFilter filter;
  std::unique_ptr<Integrator> integrator;
  std::unique_ptr<Sampler> sampler;
};

// Returns the number of the frame in its animation: the setting `frame`, rounded down. If `frame`
// is not given, returns the turntable's frame (by default 1), or 0 without a turntable.
int64_t frame_number(const FrameSettings& settings);

// Returns the seed of all samples. Without `static-noise`, each frame of an animation or turntable
// has another seed, so that the frames' noise is independent. For frame 0, the seed is the setting
// `seed`, unless the turntable is at another frame.
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
// Returns the time limit or the time budget, whichever ends first. A time budget does not stop a
// tiled frame, because buckets would be left without samples.
std::optional<TimeLimit> time_limit_of(const FrameSettings& settings);

// Returns the error metric by which samples are allocated. The text is empty if every pixel gets
// the same number of samples, or if the error estimate only decides which pixels are finished.
std::string_view allocation_of(const FrameSettings& settings);

// With this value, `judge` means all channels that the frame delivers.
inline constexpr std::string_view kJudgeDelivered = "delivered";
// Returns the channels whose error decides how many samples a pixel gets. Empty if only the error
// of R G B decides this.
std::vector<JudgedChannel> judged_channels_of(const FrameSettings& settings);
// Replaces `judge` by a list of these channels.
void set_judged_channels(std::span<const JudgedChannel> channels, FrameSettings& settings);

// Returns the channels that the settings request or need.
AovSet aovs_of(const FrameSettings& settings);

// From this many samples per pixel on, each half of the film has at least one block of eight
// samples, because the halves get blocks in turn. With fewer samples, the blocks are shorter: each
// half gets one.
inline constexpr uint32_t kMinStreamSamples = 16;

// Returns the crop, which is the whole frame by default.
Rect crop_of(const FrameSettings& settings);

}  // namespace emberline
