// What a session's frames need beside scene and camera, made anew only when the settings change.
#pragma once

#include "renderer/engine/render_plan.h"
#include "renderer/session/view_settings.h"

namespace emberline {

// Whether the driver is a window's own: bisection first, then adaptive.
bool is_live(const RenderOptions& options);

// Whether the driver that does the main work, which for `live` is the adaptive one, finishes bucket
// after bucket.
bool renders_buckets(const RenderOptions& options);
// Whether it allows this setting (renderer/engine/setting_rules.h).
bool is_allowed(const RenderOptions& options, std::string_view setting);
// Whether light groups can be kept apart, so that other lights need no new samples.
bool can_relight(const RenderOptions& options);

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
  bool light_groups;  // requested, and possible
};

}  // namespace emberline
