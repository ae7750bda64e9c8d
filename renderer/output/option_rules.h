// Rules for combining options of `render`, in addition to the rules for frame settings.
#pragma once

#include <span>
#include <string>

#include "renderer/engine/setting_rules.h"
#include "renderer/output/render_options.h"

namespace emberline {

std::span<const SettingRule> option_rules();

// Returns a message that the pixel is outside the crop; "" if the pixel is in the crop.
std::string outside_message(const Vec2i& pixel, const Rect& crop);

bool option_holds(const RenderOptions& options, const SettingCondition& condition);

// Throws UsageError if the options break one of these rules or one of the rules for frame settings.
void check_options(const RenderOptions& options);

}  // namespace emberline
