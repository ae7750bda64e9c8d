// R, G and B of a picture file, for whatever measures one against another.
#pragma once

#include <string>

#include "renderer/statistics/error_metrics.h"

namespace emberline {

// Linear; the data window only. Throws InputError for a file that cannot be read or lacks one of
// the three channels.
RgbImage read_rgb(const std::string& path);

}  // namespace emberline
