// How a RenderSession renders and shows: plain values, of which the window changes a copy.
#pragma once

#include <cstdint>
#include <optional>

#include "renderer/core/rect.h"
#include "renderer/output/render_options.h"

namespace emberline {

// A heatmap instead of the picture, or the refinement tree over it. Heatmaps show channels of the
// film (renderer/statistics/heatmap_quantity.h); stop reasons are also available for unfinished
// pixels.
enum class ViewOverlay : uint8_t { kNone, kSamples, kError, kStop, kTime, kNonFinite, kTree };

// Samples per pixel if neither RenderOptions::spp nor a threshold ends the frame, so that an open
// picture keeps improving. Bucket frames use the default of `render` instead, since they finish
// bucket by bucket.
inline constexpr uint32_t kViewSamples = 4096;

// How the picture shows a frame's film.
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
  // As for `render`: driver, integrator, sampler, filter, estimator, limits, threads, seed, size,
  // environment. Outputs, reports, snapshots, `scene`, `edits` and `display` are ignored: open()
  // takes the scene and edits, and the next member is the display.
  RenderOptions render;
  DisplaySettings display;
  const DisplayMode& display_mode() const { return *this; }
  // Records every light's contribution, so that changes of its intensity, colour, switch and solo
  // need no new samples. Not for buckets or integrators that cannot separate lights. Lights that
  // are off are also sampled, so the noise differs from `render`.
  bool light_groups = false;
  // The rendered part of the frame, instead of `render.crop`; pictures have its size.
  std::optional<Rect> crop;
  std::optional<Rect> region;  // part of the frame that is sampled first
  bool paused = false;         // rendering waits; samples are kept
};

}  // namespace emberline
