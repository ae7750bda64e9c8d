// The channels of a whole window as an EXR file.
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "io/exr_writer.h"

namespace emberline {

// `header` says everything but what is in the pixels; `values` holds its channels, interleaved, for
// every pixel of its data window, rows from the top. The file appears whole or not at all. Throws
// RenderError.
void write_exr_file(const std::string& path, const ExrHeader& header,
                    std::span<const float> values);

}  // namespace emberline
