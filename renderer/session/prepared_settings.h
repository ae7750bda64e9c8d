// What a session's frames need beside scene and camera, made anew only when the settings change.
#pragma once

#include "renderer/engine/render_plan.h"
#include "renderer/session/view_settings.h"

namespace emberline {

// Whether the driver is a window's own: bisection first, then adaptive.
bool is_live(const RenderOptions& options);

// That does the main work: of `live`, the adaptive one.
const DriverEntry& main_driver(const RenderOptions& options);

// The options that a window's settings come to: those of the driver that does the main work, with
// a budget that lasts as long as somebody looks.
RenderOptions main_options(const ViewSettings& settings);

// The channels that the settings ask for, the overlay's included.
AovSet wanted_aovs(const ViewSettings& settings);

// Whether a frame rendered by the settings `a` has the samples and, among others, the channels that
// the settings `b` ask for.
bool frames_serve(const ViewSettings& a, const ViewSettings& b);

struct PreparedSettings {
  // Throws UsageError for settings that make no sense.
  explicit PreparedSettings(const ViewSettings& settings);

  RenderOptions options;
  bool live;
  RenderPlan plan;
  bool light_groups;  // asked for, and possible
};

}  // namespace emberline
