// Checks a session's settings and prepares them for rendering frames. This is repeated only when
// the settings change.
#pragma once

#include "renderer/engine/render_plan.h"
#include "renderer/session/view_settings.h"

namespace emberline {

// Returns whether the driver is `live`, which runs the driver `bisection` and then `adaptive`.
bool is_live(const RenderOptions& options);

// Returns whether the main driver finishes one bucket after another. The main driver of `live` is
// adaptive.
bool is_main_driver_tiled(const RenderOptions& options);
// Returns whether the main driver allows this setting (renderer/engine/setting_rules.h).
bool main_driver_allows(const RenderOptions& options, std::string_view setting);
// Returns whether light groups can be recorded, so that light changes need no new samples.
bool can_relight(const RenderOptions& options);

// Returns the main driver's options for a session's settings. If the settings do not limit the
// samples, the limit is kViewSamples.
RenderOptions main_options(const ViewSettings& settings);

// Returns the channels that the settings need, including those of the overlay.
AovSet required_aovs(const ViewSettings& settings);

// Returns whether a frame rendered with the settings `a` has the same samples as a frame rendered
// with `b`, and all channels that `b` needs.
bool frame_satisfies(const ViewSettings& a, const ViewSettings& b);

struct PreparedSettings {
  // Throws UsageError for invalid settings.
  explicit PreparedSettings(const ViewSettings& settings);

  RenderOptions options;
  bool live;
  RenderPlan plan;
  bool light_groups;  // whether light groups are requested and possible
};

}  // namespace emberline
