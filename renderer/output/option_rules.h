// Rules for combining options of `render`, in addition to the rules for frame settings.
#pragma once

#include <span>

#include "renderer/engine/setting_rules.h"
#include "renderer/output/render_options.h"

namespace emberline {

std::span<const SettingRule> option_rules();

bool option_holds(const RenderOptions& options, const SettingCondition& condition);

// Throws UsageError for options or settings that exclude each other.
void check_options(const RenderOptions& options);

}  // namespace emberline
