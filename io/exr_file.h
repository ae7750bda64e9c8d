// A picture that is held as a whole as an EXR file.
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "io/exr_writer.h"

namespace emberline {

// Writes `values`, which hold the channels of `header`, interleaved, for every pixel of its data
// window, rows from the top, into a file that was begun with that header. finish() is left to do.
void write_exr_crop(ExrWriter& writer, const ExrHeader& header, std::span<const float> values);

// The same as a file of its own, which appears whole or not at all. Throws RenderError.
void write_exr_file(const std::string& path, const ExrHeader& header,
                    std::span<const float> values);

}  // namespace emberline
