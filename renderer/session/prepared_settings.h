// Settings of a session's frames, prepared again only when they change.
#pragma once

#include "renderer/engine/render_plan.h"
#include "renderer/session/view_settings.h"

namespace emberline {

// Whether the driver is `live`: bisection first, then adaptive.
bool is_live(const RenderOptions& options);

// Whether the driver that does the main work, which for `live` is the adaptive one, finishes bucket
// after bucket.
bool renders_buckets(const RenderOptions& options);
// Whether it allows this setting (renderer/engine/setting_rules.h).
bool is_allowed(const RenderOptions& options, std::string_view setting);
// Whether light groups can be kept apart, so that other lights need no new samples.
bool can_relight(const RenderOptions& options);

// The options of the main driver for a session's settings, with a budget for as long as it is open.
RenderOptions main_options(const ViewSettings& settings);

// The channels that the settings request, including the overlay's.
AovSet wanted_aovs(const ViewSettings& settings);

// Whether a frame rendered by the settings `a` has the samples, and at least the channels, of the
// settings `b`.
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
