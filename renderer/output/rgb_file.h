// Picture files, for whatever shows their channels or measures R, G and B against another's.
#pragma once

#include <span>
#include <string>

#include "io/image/input.h"
#include "renderer/core/rect.h"
#include "renderer/statistics/error_metrics.h"

namespace emberline {

// All channels of a picture; warns of a frame that was stopped before it was complete. Throws
// InputError.
FloatImage read_frame(const std::string& path, const LoadProgress& progress);

// Pixels of a frame, and where in it they lie. A .png knows no frame but itself.
struct RgbFile {
  std::string path;
  RgbImage pixels;
  Rect crop;
  int frame_width = 0, frame_height = 0;

  bool is_whole_frame() const { return crop == Rect{0, 0, frame_width, frame_height}; }
};

// Linear; the data window only. Throws InputError for a file that cannot be read, and where
// find_colour() finds no R, G and B.
RgbFile read_rgb(const std::string& path, const LoadProgress& progress);

// Of a reference the pixels that `crop` of a frame is to be measured against: those at the same
// place of a frame of the same size; or, where one of the two knows no frame but itself, all of
// them, if they are as many. Throws InputError, which calls the picture to be measured `what`.
RgbImage reference_pixels(RgbFile reference, const std::string& what, const Rect& crop,
                          int frame_width, int frame_height);

// The first three of a crop's interleaved channels.
RgbImage to_rgb_image(std::span<const float> values, size_t channels, const Rect& crop);

}  // namespace emberline
