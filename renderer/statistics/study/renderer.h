// Renders the frame of a study repeatedly, by different methods, into memory.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "io/files/register.h"
#include "renderer/engine/open_scene.h"
#include "renderer/output/render_options.h"
#include "renderer/scene/camera.h"
#include "renderer/statistics/error_metrics.h"
#include "renderer/statistics/study_results.h"

namespace emberline {

class AovSet;
struct RenderCounters;
struct SamplePlan;

// The number of channels of an intermediate picture: R, G, B, A and samples. A finished frame may
// have more channels after these five.
inline constexpr size_t kStudyPictureChannels = 5;

// Samples per pixel of the motion that is saved with the reference.
inline constexpr uint32_t kMotionSamples = 16;

// Side of the tiles in which a frame is denoised.
inline constexpr int kStudyTile = 64;

// A picture that was taken while a frame was rendered or at its end. `error` has not been measured
// yet.
struct StudyPicture : StudyCheckpoint {
  std::vector<float> values;        // R, G, B, A, samples; if finished, film_channels()
  uint64_t non_finite_samples = 0;  // only for a finished frame
};

// A driver's error estimate for the picture at the end of a round, together with this picture.
struct RoundEstimate {
  uint64_t samples = 0;
  double estimate = 0;
  RgbImage picture;
};

struct ProgressiveFrame {
  std::vector<StudyPicture> pictures;  // one for each budget that the frame reached
  std::vector<RoundEstimate> estimates;
  uint64_t non_finite_samples = 0;
  bool stopped = false;  // by the user
};

class StudyRenderer {
 public:
  // Loads and builds the scene, with its motion if render_motion() will be called. Registers the
  // files that the scene reads. Throws what the render command throws.
  StudyRenderer(const RenderOptions& frame, bool has_motion, const LoadLimits& limits,
                FileRegister& files);

  const Rect& crop() const { return crop_; }
  uint64_t pixels() const { return uint64_t(crop_.area()); }

  // Returns the memory that a frame needs while it is rendered and measured. Does not include the
  // pictures in RoundEstimates; an adaptive frame has one for each round.
  uint64_t frame_bytes(const RenderOptions& options, size_t budgets) const;

  // `callback` receives the number of new samples; any thread may call it.
  void on_samples(std::function<void(uint64_t)> callback) { on_samples_ = std::move(callback); }

  // Renders a whole frame with the driver, sampler, number of samples (or time) and seed of the
  // options. If they have a plan, renders the pilot first and plans the frame by it. Returns
  // nothing if a stop was requested. Warns about non-finite samples, with a command that replays
  // the first one. Uses the calling thread's TBB arena, as does render_progressive().
  std::optional<StudyPicture> render(const RenderOptions& options, const AovSet& aovs,
                                     const std::stop_token& stop) const;

  // Returns the motion of each pixel to the next frame, in pixels to the right and up, interleaved.
  // Returns nothing if a stop was requested.
  std::optional<std::vector<float>> render_motion(const RenderOptions& frame,
                                                  const std::stop_token& stop) const;

  // Renders one frame of a progressive driver. For each budget, in samples per pixel or in seconds,
  // takes a picture at the driver's first pause after the budget is spent. The last picture is the
  // finished frame. There is one exception: uniform sampling with budgets in seconds stops once the
  // last budget is spent. If the frame finishes early, the finished frame is the picture for all
  // remaining budgets.
  ProgressiveFrame render_progressive(const RenderOptions& options, std::span<const double> budgets,
                                      bool by_time, const std::stop_token& stop) const;

 private:
  // Returns nothing if a stop was requested. Sets the pilot's counters.
  std::shared_ptr<const SamplePlan> plan_samples(const RenderOptions& planned,
                                                 const std::stop_token& stop,
                                                 RenderCounters* counters) const;

  Rect crop_;
  std::unique_ptr<OpenScene> scene_;
  Camera camera_;
  std::function<void(uint64_t)> on_samples_;
};

// Denoises a picture of a whole frame that has the channels of Aov::kDenoising. Replaces the
// picture's values with those of the denoised picture (channels R, G, B, A, samples), sets
// `estimate` to the error that the filter expects, and adds the filter's time. Uses the calling
// thread's TBB arena.
void denoise_picture(const Rect& crop, StudyPicture* picture);

}  // namespace emberline
