#include "renderer/output/rgb_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <utility>
#include <vector>

#include "io/display/working_space.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/rect_values.h"

namespace emberline {
namespace {

std::string describe(const Rect& crop, int frame_width, int frame_height) {
  return fmt::format("{} x {} pixels from ({}, {}) of a frame of {} x {}", crop.width(),
                     crop.height(), crop.x0, crop.y0, frame_width, frame_height);
}

}  // namespace

FloatImage read_frame(const std::string& path, const LoadProgress& progress) {
  FloatImage image = read_float_image(path, progress);
  if (image.stopped_after) {
    log_warning(fmt::format("{}: the frame was stopped before it was complete, at {} samples", path,
                            *image.stopped_after));
  }
  return image;
}

RgbFile read_rgb(const std::string& path, const LoadProgress& progress) {
  const FloatImage file = read_frame(path, progress);
  const ColourChannels colour = find_colour(file.channel_names, file.parts, path);
  if (colour.count != 3) {
    throw InputError(
        path, "it has {} x {} pixels, but no channels R, G and B to compare; its channels are {}",
        file.width, file.height, fmt::join(file.channel_names, ", "));
  }
  const size_t pixels = size_t(file.width) * size_t(file.height);
  progress.budget()->reserve(MemoryPart::kTextures, bytes_of(pixels, 3 * sizeof(float)), path);
  RgbFile result{path,
                 {file.width, file.height, std::vector<float>(3 * pixels)},
                 file.data_window,
                 file.frame_width,
                 file.frame_height};
  const ToWorkingSpace to_rec709 = from_working_space(file.space);
  const auto first = size_t(colour.first);
  for (size_t i = 0; i < pixels; ++i) {
    for (size_t c = 0; c < 3; ++c) {
      result.pixels.rgb[3 * i + c] = file.values[i * size_t(file.channels()) + first + c];
    }
    if (!to_rec709) continue;
    float* const p = &result.pixels.rgb[3 * i];
    const Rgb rgb = *to_rec709 * Rgb(p[0], p[1], p[2]);
    std::copy_n(&rgb.x, 3, p);
  }
  progress.budget()->release(MemoryPart::kTextures, file.values.size() * sizeof(float));
  return result;
}

RgbImage reference_pixels(RgbFile reference, const std::string& what, const Rect& crop,
                          int frame_width, int frame_height) {
  const bool same_frame =
      reference.frame_width == frame_width && reference.frame_height == frame_height;
  const bool whole = crop == Rect{0, 0, frame_width, frame_height};
  if (same_frame && reference.crop == crop) return std::move(reference.pixels);
  if (same_frame && reference.crop.intersect(crop) == crop) {
    return {crop.width(), crop.height(), extract_rect(reference.pixels.rgb, reference.crop, crop)};
  }
  const bool same_size =
      reference.pixels.width == crop.width() && reference.pixels.height == crop.height();
  if (!same_frame && same_size && (whole || reference.is_whole_frame())) {
    return std::move(reference.pixels);
  }
  throw InputError(reference.path,
                   "it has {}, but {} has {}; a reference must cover the whole picture",
                   describe(reference.crop, reference.frame_width, reference.frame_height), what,
                   describe(crop, frame_width, frame_height));
}

RgbImage to_rgb_image(std::span<const float> values, size_t channels, const Rect& crop) {
  RgbImage image{crop.width(), crop.height(), {}};
  image.rgb.reserve(values.size() / channels * 3);
  for (size_t i = 0; i < values.size(); i += channels) {
    image.rgb.insert(image.rgb.end(), &values[i], &values[i] + 3);
  }
  return image;
}

}  // namespace emberline
