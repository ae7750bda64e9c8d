// Writes a picture of the FLIP error of each pixel.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "renderer/statistics/error_metrics.h"

namespace emberline {

// Draws the values of `flip`, one per pixel of `image`, with the magma map: from black (0) via
// purple and orange to light yellow (1). Pixels that are not finite (`masked` is not 0) are green.
// Throws UsageError for an unknown suffix, and RenderError if the file cannot be written.
void write_flip_picture(const std::string& path, const RgbImage& image,
                        const std::vector<float>& flip, const std::vector<uint8_t>& masked);

}  // namespace emberline
