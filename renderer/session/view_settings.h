// Settings for how a RenderSession renders and shows a scene. They are plain values: the window
// changes a copy and passes it to the session.
#pragma once

#include <cstdint>
#include <optional>

#include "renderer/core/rect.h"
#include "renderer/output/render_options.h"

namespace emberline {

// A heatmap that replaces the picture, or the refinement tree drawn over it. Heatmaps show channels
// of the film (renderer/statistics/heatmap_quantity.h); stop reasons are also known for unfinished
// pixels.
enum class ViewOverlay : uint8_t { kNone, kSamples, kError, kStop, kTime, kNonFinite, kTree };

// The number of samples per pixel if the options do not limit it. It is so large that a picture
// that stays open keeps improving. Bucket frames instead use the default of `render`, because they
// finish one bucket after another.
inline constexpr uint32_t kViewSamples = 4096;

// How a frame's film is shown as a picture.
struct alignas(4) DisplayMode {
  ViewOverlay overlay = ViewOverlay::kNone;
  // Denoises the picture (renderer/reconstruction/fast_filter.h) unless a heatmap replaces it, and
  // adds channels to the film. Saved files and pixel values stay unfiltered.
  bool denoise = false;
  bool include_raw = false;  // adds the unfiltered picture as SessionPicture::raw8
  bool filtered() const {
    return denoise && (overlay == ViewOverlay::kNone || overlay == ViewOverlay::kTree);
  }
  bool operator==(const DisplayMode&) const = default;
};

struct ViewSettings : DisplayMode {
  // The same options as for `render`: driver, integrator, sampler, filter, estimator, limits,
  // threads, seed, size, environment. Outputs, reports and snapshots are ignored. So are `scene`
  // and `edits`, which are arguments of open(), and `display`, which the member below replaces.
  RenderOptions render;
  DisplaySettings display;
  const DisplayMode& display_mode() const { return *this; }
  // Records each light's contribution separately, so that changes of intensity, colour, on/off and
  // solo need no new samples. Ignored for buckets and for integrators that cannot separate lights.
  // Lights that are off are also sampled, so the noise differs from that of `render`.
  bool light_groups = false;
  // The part of the frame that is rendered. It replaces `render.crop`, and pictures have its size.
  std::optional<Rect> crop;
  std::optional<Rect> region;  // part of the frame that is sampled first
  bool paused = false;         // rendering waits; samples are kept
};

}  // namespace emberline
