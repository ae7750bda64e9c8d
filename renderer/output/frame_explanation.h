// Explains one pixel in words, from the file of a finished frame.
#pragma once

#include <optional>
#include <string>

#include "renderer/core/load_progress.h"
#include "renderer/core/vector.h"

namespace emberline {

// The header attribute of a frame that was rendered with `explain`. Its text is "X,Y: " and the
// sentence from adaptive/pixel_explanation.h, padded with blanks to kMaxExplanation characters.
inline constexpr const char* kExplanationAttribute = "emberline:explanation";
inline constexpr size_t kMaxExplanation = 4096;
std::string explanation_attribute(const Vec2i& pixel, std::string text);

// Explains a pixel of an EXR that `emberline render` wrote: `pixel` or, if that is absent, the
// pixel with the largest value of the heatmap quantity `error`. States only what the file contains.
// If the file lacks something, names the option that makes a render store it. Throws InputError for
// an unusable file, and UsageError for a pixel outside the frame.
std::string explain_frame(const std::string& path, std::optional<Vec2i> pixel,
                          const LoadProgress& progress);

}  // namespace emberline
