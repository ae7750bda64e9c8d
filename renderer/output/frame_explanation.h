// Says in words what a finished frame's file tells about one pixel.
#pragma once

#include <optional>
#include <string>

#include "renderer/core/load_progress.h"
#include "renderer/core/vector.h"

namespace emberline {

// Header attribute of a frame rendered with `explain`: "X,Y: " and the sentence of
// adaptive/pixel_explanation.h, padded with blanks to this length.
inline constexpr const char* kExplanationAttribute = "emberline:explanation";
inline constexpr size_t kMaxExplanation = 4096;
std::string explanation_attribute(const Vec2i& pixel, std::string text);

// Explains `pixel` of an EXR that `emberline render` wrote; without a pixel, the one with the
// largest error of the heatmap `error`. States only what the file has, and names the option for
// what it lacks. Throws InputError for an unusable file, and UsageError for a pixel outside it.
std::string explain_frame(const std::string& path, std::optional<Vec2i> pixel,
                          const LoadProgress& progress);

}  // namespace emberline
