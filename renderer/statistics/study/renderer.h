// Renders the frame of a study again and again, by one method after another, into memory.
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

// R G B A samples, of a picture on its way; a finished frame may have more behind them.
inline constexpr size_t kStudyPictureChannels = 5;

// The side of the tiles in which a frame is denoised.
inline constexpr int kStudyTile = 64;

// A frame as it was at some moment, not measured yet: interleaved channels, of the crop.
struct StudyPicture : StudyCheckpoint {
  std::vector<float> values;        // R G B A samples; of a whole frame all of film_channels()
  uint64_t non_finite_samples = 0;  // of a whole frame
};

// The error that a driver claimed for the picture at the end of a round, and that picture.
struct ClaimedError {
  uint64_t samples = 0;
  double estimate = 0;
  RgbImage picture;
};

struct ProgressiveFrame {
  std::vector<StudyPicture> pictures;  // one for each budget that was reached
  std::vector<ClaimedError> claims;
  uint64_t non_finite_samples = 0;
  bool stopped = false;  // by the user
};

class StudyRenderer {
 public:
  // Loads and builds. Enters what the scene reads. Throws what the render command would.
  StudyRenderer(const RenderOptions& frame, const LoadLimits& limits, FileRegister& files);

  const Rect& crop() const { return crop_; }
  uint64_t pixels() const { return uint64_t(crop_.area()); }

  // What a frame takes while it is rendered and measured, but for the pictures of claims: as many
  // as an adaptive frame has rounds.
  uint64_t frame_bytes(const RenderOptions& options, size_t budgets) const;

  // Called from any thread for every some samples.
  void on_samples(std::function<void(uint64_t)> callback) { on_samples_ = std::move(callback); }

  // A whole frame with the driver, sampler, samples and seed of the options; nothing if a stop was
  // requested. Samples that are not finite are warned of, with what replays the first. On the
  // calling thread's arena, as is the other.
  std::optional<StudyPicture> render(const RenderOptions& options, const AovSet& aovs,
                                     const std::stop_token& stop) const;

  // One frame of a progressive driver, with a picture at the first pause at which each of the
  // budgets is spent: samples per pixel, or seconds. The last picture is the finished frame; but
  // uniform sampling whose budgets are seconds ends with the last of them. A frame that finishes
  // sooner is the picture of all further budgets.
  ProgressiveFrame render_progressive(const RenderOptions& options, std::span<const double> budgets,
                                      bool by_time, const std::stop_token& stop) const;

 private:
  Rect crop_;
  std::unique_ptr<OpenScene> scene_;
  Camera camera_;
  std::function<void(uint64_t)> on_samples_;
};

// Filters a denoised method's frame, a whole one with the channels of `denoising`: leaves R G B A
// samples of the denoised picture, and the error that the filter expects of it; adds the filter's
// time. On the calling thread's arena.
void denoise_picture(const Rect& crop, StudyPicture* picture);

}  // namespace emberline
