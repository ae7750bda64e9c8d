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

// The channels R G B A samples of an intermediate picture. A finished frame may have more channels
// after them.
inline constexpr size_t kStudyPictureChannels = 5;

// Side of the tiles in which a frame is denoised.
inline constexpr int kStudyTile = 64;

// A picture that has not been measured yet, taken during or at the end of a frame.
struct StudyPicture : StudyCheckpoint {
  std::vector<float> values;        // of the crop: R G B A samples; at the end all film_channels()
  uint64_t non_finite_samples = 0;  // at the end
};

// A driver's error estimate for the picture at the end of a round, and that picture.
struct RoundEstimate {
  uint64_t samples = 0;
  double estimate = 0;
  RgbImage picture;
};

struct ProgressiveFrame {
  std::vector<StudyPicture> pictures;  // one for each budget that was reached
  std::vector<RoundEstimate> estimates;
  uint64_t non_finite_samples = 0;
  bool stopped = false;  // whether the user stopped it
};

class StudyRenderer {
 public:
  // Loads and builds the scene. Registers the files that it reads. Throws what the render command
  // throws.
  StudyRenderer(const RenderOptions& frame, const LoadLimits& limits, FileRegister& files);

  const Rect& crop() const { return crop_; }
  uint64_t pixels() const { return uint64_t(crop_.area()); }

  // Memory of a frame while it is rendered and measured, except for the pictures of RoundEstimates;
  // an adaptive frame has one for each round.
  uint64_t frame_bytes(const RenderOptions& options, size_t budgets) const;

  // `callback` receives the number of new samples; any thread may call it.
  void on_samples(std::function<void(uint64_t)> callback) { on_samples_ = std::move(callback); }

  // Renders a whole frame with the driver, sampler, samples and seed of the options; returns
  // nothing if a stop was requested. Warns of non-finite samples, with a command that replays the
  // first one. Uses the calling thread's TBB arena, as does render_progressive().
  std::optional<StudyPicture> render(const RenderOptions& options, const AovSet& aovs,
                                     const std::stop_token& stop) const;

  // Renders one frame of a progressive driver. For each budget (samples per pixel, or seconds), it
  // takes a picture at the first pause at which the budget is spent. The last picture is the
  // finished frame; but uniform sampling with budgets in seconds stops at the last budget. If the
  // frame finishes early, it is the picture for all remaining budgets.
  ProgressiveFrame render_progressive(const RenderOptions& options, std::span<const double> budgets,
                                      bool by_time, const std::stop_token& stop) const;

 private:
  Rect crop_;
  std::unique_ptr<OpenScene> scene_;
  Camera camera_;
  std::function<void(uint64_t)> on_samples_;
};

// Denoises a whole frame that has the channels of Aov::kDenoising. Replaces its values with R G B A
// samples of the denoised picture, sets the error that the filter expects, and adds the filter's
// time. Uses the calling thread's TBB arena.
void denoise_picture(const Rect& crop, StudyPicture* picture);

}  // namespace emberline
