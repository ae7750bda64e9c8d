// How a RenderSession renders and shows: plain values, of which the window changes a copy.
#pragma once

#include <cstdint>
#include <optional>

#include "renderer/core/rect.h"
#include "renderer/output/render_options.h"

namespace emberline {

// What is drawn instead of, or over, the picture. All but the tree come from channels of the film
// (renderer/statistics/heatmap_quantity.h); why pixels have ended is told while others go on.
enum class ViewOverlay : uint8_t { kNone, kSamples, kError, kStop, kTime, kNonFinite, kTree };

// Samples a pixel where RenderOptions::spp says nothing and no threshold ends the frame: the
// picture goes on getting better while somebody looks at it. Buckets, of which each is brought to
// its end before the next begins, keep to what `render` gives them.
inline constexpr uint32_t kViewSamples = 4096;

// What becomes of a frame's film in the picture.
struct alignas(4) ShownAs {
  ViewOverlay overlay = ViewOverlay::kNone;
  bool denoise =
      false;  // filtered (renderer/reconstruction/fast_filter.h), where nothing lies over it
  bool raw_beside = false;  // ShownPicture::raw8 as well
  bool filtered() const {
    return denoise && (overlay == ViewOverlay::kNone || overlay == ViewOverlay::kTree);
  }
  bool operator==(const ShownAs&) const = default;
};

struct ViewSettings {
  // Driver, integrator, sampler, filter, estimator, limits, threads, seed, size, surroundings: as
  // `render` takes them. What it says of outputs, reports and snapshots means nothing here, nor do
  // `scene` and `edits`, which are open()'s; `display` is the next member's.
  RenderOptions render;
  DisplaySettings display;
  ViewOverlay overlay = ViewOverlay::kNone;
  // Pictures are filtered, and frames have the channels for that; files and single values stay
  // those of the film.
  bool denoise = false;
  bool raw_beside = false;  // each filtered picture comes with the one that it was made of
  ShownAs shown_as() const { return {overlay, denoise, raw_beside}; }
  // Every light's contribution is kept apart, so that an edit of its intensity or colour, its
  // switch and solo need no new ray. Not of buckets, nor with integrators that do not tell lights
  // apart. Lights that are off are sampled all the same; a picture mixed so has other noise than
  // `render`.
  bool light_groups = false;
  // What is rendered of the frame, in place of `render.crop`: pictures are as large.
  std::optional<Rect> crop;
  std::optional<Rect> region;  // of the frame: gets its samples first
  bool paused = false;         // the frame stands still; what it has is kept
};

}  // namespace emberline
