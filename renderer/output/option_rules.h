// Which options of `render` go together, beside the rules for the settings of a frame.
#pragma once

#include <span>

#include "renderer/engine/setting_rules.h"
#include "renderer/output/render_options.h"

namespace emberline {

std::span<const SettingRule> option_rules();

// Whether a condition on an option or a setting holds.
bool option_holds(const RenderOptions& options, const SettingIs& is);

// Throws UsageError for options, or settings, that do not go together.
void check_options(const RenderOptions& options);

}  // namespace emberline
