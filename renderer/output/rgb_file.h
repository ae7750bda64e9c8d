// Reads picture files to show their channels or to compare their R, G and B.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "io/image/input.h"
#include "renderer/core/rect.h"
#include "renderer/statistics/error_metrics.h"
#include "renderer/statistics/flicker.h"

namespace emberline {

// Warns if the frame was stopped early.
void warn_if_stopped(const std::string& path, const FloatImage& image);

// Whether the header has this attribute with the text "yes". Settings that are flags are stored in
// this way.
bool is_marked(const FloatImageRows& file, const char* attribute);

// Reads all channels of a picture and warns if its frame was stopped early. Throws InputError.
FloatImage read_frame(const std::string& path, const LoadProgress& progress);

// The layer of a denoised picture.
inline constexpr std::string_view kDenoisedLayer = "denoised";

// Like find_layer(), but if a render could have written the missing layer, the error message names
// the setting for it.
ImageLayer find_frame_layer(const FloatImage& image, const std::string& name,
                            const std::string& path);

// Pixels of a frame and their position in it. A .png stores no position, so it counts as a whole
// frame.
struct RgbFile {
  std::string path;
  RgbImage pixels;
  Rect crop;
  int frame_width = 0, frame_height = 0;
  // Whether the file has a denoised picture but `pixels` come from another layer.
  bool has_denoised = false;
  PixelMotion motion;  // if LayerChoice::reads_motion is set and the file has a layer `velocity`

  bool is_whole_frame() const { return crop == Rect{0, 0, frame_width, frame_height}; }
};

// How read_rgb() chooses a picture's channels.
struct LayerChoice {
  std::string layer;  // see find_layer(); empty: find_colour()
  // If set, a missing denoised layer is replaced by the same layer without denoising. Any other
  // missing layer is replaced by R, G and B, if the file has only one layer.
  bool is_reference = false;
  bool reads_motion = false;
  std::string_view remedy = "save one of them as a separate file";  // see find_colour()
};

// Returns the pixels of the data window in linear Rec. 709. The channels X, Y and Z of a layer
// count as R, G and B. A single channel counts as all three. Throws InputError if the file is
// unreadable or find_colour() finds no R, G and B, and UsageError if the layer is unknown or has
// two channels.
RgbFile read_rgb(const std::string& path, const LoadProgress& progress,
                 const LayerChoice& choice = {});

// Returns the pixels of the reference with which `crop` is compared. If both frames have the same
// size, returns the pixels at the same position; the reference must contain all of them. If the
// frames differ in size, returns the whole reference. It must then have the size of `crop`, and the
// reference or `crop` must be a whole frame. Otherwise throws an InputError. Its message calls the
// compared picture `what`.
RgbImage reference_pixels(RgbFile reference, const std::string& what, const Rect& crop,
                          int frame_width, int frame_height);

// Returns an image of the first three channels. `values` are the interleaved channels of the crop's
// pixels.
RgbImage to_rgb_image(std::span<const float> values, size_t channels, const Rect& crop);

}  // namespace emberline
