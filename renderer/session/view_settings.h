// How a RenderSession renders and shows: plain values, of which the window changes a copy.
#pragma once

#include <cstdint>
#include <optional>

#include "renderer/core/rect.h"
#include "renderer/output/render_options.h"

namespace emberline {

// A heatmap instead of the picture, or the refinement tree over it. Heatmaps come from channels of
// the film (renderer/statistics/heatmap_quantity.h); stop reasons are also known while pixels go
// on.
enum class ViewOverlay : uint8_t { kNone, kSamples, kError, kStop, kTime, kNonFinite, kTree };

// Samples per pixel if neither RenderOptions::spp nor a threshold ends the frame, so that the
// picture keeps improving while it is open. Buckets, which finish one after another, get what
// `render` gives.
inline constexpr uint32_t kViewSamples = 4096;

// How the picture shows a frame's film.
struct alignas(4) ShownAs {
  ViewOverlay overlay = ViewOverlay::kNone;
  // Filtered (renderer/reconstruction/fast_filter.h), where nothing lies over it, which adds
  // channels to the film; files and values of pixels stay unfiltered.
  bool denoise = false;
  bool raw_beside = false;  // each filtered picture with the one that it was made of, raw8
  bool filtered() const {
    return denoise && (overlay == ViewOverlay::kNone || overlay == ViewOverlay::kTree);
  }
  bool operator==(const ShownAs&) const = default;
};

struct ViewSettings : ShownAs {
  // Driver, integrator, sampler, filter, estimator, limits, threads, seed, size, environment: as
  // for `render`. Outputs, reports, snapshots, `scene`, `edits` and `display` are ignored: open()
  // has the scene and its edits, the next member the display.
  RenderOptions render;
  DisplaySettings display;
  const ShownAs& shown_as() const { return *this; }
  // Keeps every light's contribution apart, so that edits of its intensity or colour, its switch
  // and solo need no new samples. Not for buckets, nor for integrators that cannot separate lights.
  // Lights that are off are sampled too, so the noise differs from that of `render`.
  bool light_groups = false;
  // The rendered part of the frame, in place of `render.crop`; pictures have its size.
  std::optional<Rect> crop;
  std::optional<Rect> region;  // of the frame: gets its samples first
  bool paused = false;         // the frame stands still; what it has is kept
};

}  // namespace emberline
