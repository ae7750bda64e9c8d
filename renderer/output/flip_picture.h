// FLIP per pixel as a picture.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "renderer/statistics/error_metrics.h"

namespace emberline {

// Black (0) over purple and orange to light yellow (1), the colours of magma; pixels that are not
// finite, where `masked` is not 0, are green. `flip` is per pixel of a picture of `image`'s size.
// Throws UsageError for the suffix, RenderError.
void write_flip_picture(const std::string& path, const RgbImage& image,
                        const std::vector<float>& flip, const std::vector<uint8_t>& masked);

}  // namespace emberline
