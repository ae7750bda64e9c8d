#include "renderer/output/rgb_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "io/display/working_space.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/rect_values.h"
#include "renderer/engine/setting_table.h"

namespace emberline {
namespace {

std::string describe(const Rect& crop, int frame_width, int frame_height) {
  return fmt::format("{} x {} pixels from ({}, {}) of a frame of {} x {}", crop.width(),
                     crop.height(), crop.x0, crop.y0, frame_width, frame_height);
}

// Returns the channels R, G and B of the file. Throws InputError if the file does not have them.
ImageLayer find_picture(const FloatImage& file, const std::string& path,
                        const LayerChoice& choice) {
  const ColourChannels colour = find_colour(file.channel_names, file.parts, path, choice.remedy);
  if (colour.count != 3) {
    throw InputError(
        path, "it has {} x {} pixels, but no channels R, G and B to compare; its channels are {}",
        file.width, file.height, fmt::join(file.channel_names, ", "));
  }
  return {"", {colour.first, colour.first + 1, colour.first + 2}, -1, true};
}

// Returns the name of the reference's layer with which `layer` is compared; "" stands for R, G and
// B.
std::string reference_layer(const FloatImage& file, const std::string& path,
                            const std::string& layer) {
  const auto has = [&](const std::string& name) {
    return try_find_layer(file.channel_names, file.parts, name, path).has_value();
  };
  if (has(layer)) return layer;
  const std::string prefix = std::string(kDenoisedLayer) + ".";
  const std::string raw = layer.starts_with(prefix) ? layer.substr(prefix.size()) : "";
  if (!raw.empty() && !has(raw)) return layer;
  const bool is_denoised = layer == kDenoisedLayer || !raw.empty();
  if (!is_denoised && image_layers(file.channel_names, file.parts).size() > 1) return layer;
  log_info(fmt::format("{} has no layer {}; using its {} as the reference", path, layer,
                       raw.empty() ? "picture" : "layer " + raw));
  return raw;
}

ImageLayer choose_layer(const FloatImage& file, const std::string& path,
                        const LayerChoice& choice) {
  const std::string name = choice.layer.empty() || !choice.is_reference
                               ? choice.layer
                               : reference_layer(file, path, choice.layer);
  if (name.empty()) return find_picture(file, path, choice);
  ImageLayer layer = find_frame_layer(file, name, path);
  if (layer.channels.size() == 2) {
    throw UsageError(
        "`layer`: {} of {} has two channels; only layers with one or three channels can be "
        "measured",
        layer.name, path);
  }
  layer.channels.resize(3, layer.channels.front());
  return layer;
}

// Returns the motion in the layer `velocity`, or an empty one if the file has none.
PixelMotion motion_of(const FloatImage& file, const LoadProgress& progress,
                      const std::string& path) {
  const int right = file.find_channel("velocity.X"), up = file.find_channel("velocity.Y");
  PixelMotion motion;
  if (right < 0 || up < 0) return motion;
  const size_t pixels = size_t(file.width) * size_t(file.height);
  progress.budget()->reserve(MemoryPart::kTextures, bytes_of(pixels, 2 * sizeof(float)), path);
  motion.right.reserve(pixels);
  motion.down.reserve(pixels);
  for (size_t i = 0; i < file.values.size(); i += size_t(file.channels())) {
    motion.right.push_back(file.values[i + size_t(right)]);
    motion.down.push_back(-file.values[i + size_t(up)]);
  }
  return motion;
}

}  // namespace

void warn_if_stopped(const std::string& path, const FloatImage& image) {
  if (!image.stopped_after) return;
  log_warning(fmt::format("{}: the frame was stopped before it was complete, at {} samples", path,
                          *image.stopped_after));
}

bool is_marked(const FloatImageRows& file, const char* attribute) {
  const std::pair<std::string, std::string> mark(attribute, "yes");
  return std::ranges::find(file.text_attributes(), mark) != file.text_attributes().end();
}

FloatImage read_frame(const std::string& path, const LoadProgress& progress) {
  FloatImage image = read_float_image(path, progress);
  warn_if_stopped(path, image);
  return image;
}

ImageLayer find_frame_layer(const FloatImage& image, const std::string& name,
                            const std::string& path) {
  if (auto layer = try_find_layer(image.channel_names, image.parts, name, path)) {
    return *std::move(layer);
  }
  const auto reject = [&](const std::string& setting) {
    throw UsageError("`layer`: {} has no {}; render it with {}", path, name, setting);
  };
  if (name == kDenoisedLayer) reject("`denoise`");
  const std::vector<SettingChoice>& aovs = find_setting("aov")->choices;
  if (std::ranges::find(aovs, name, &SettingChoice::name) != aovs.end()) reject("`aov` " + name);
  return find_layer(image.channel_names, image.parts, name, path);
}

RgbFile read_rgb(const std::string& path, const LoadProgress& progress, const LayerChoice& choice) {
  const FloatImage file = read_frame(path, progress);
  const ImageLayer layer = choose_layer(file, path, choice);
  const int denoised = file.find_channel(std::string(kDenoisedLayer) + ".R");
  const size_t pixels = size_t(file.width) * size_t(file.height);
  progress.budget()->reserve(MemoryPart::kTextures, bytes_of(pixels, 3 * sizeof(float)), path);
  RgbFile result{path,
                 {file.width, file.height, std::vector<float>(3 * pixels)},
                 file.data_window,
                 file.frame_width,
                 file.frame_height,
                 denoised >= 0 && layer.channels.front() != denoised,
                 {}};
  const ToWorkingSpace to_rec709 = layer.has_colour ? from_working_space(file.space) : nullptr;
  for (size_t i = 0; i < pixels; ++i) {
    const float* const values = &file.values[i * size_t(file.channels())];
    float* const p = &result.pixels.rgb[3 * i];
    for (size_t c = 0; c < 3; ++c) p[c] = values[layer.channels[c]];
    if (!to_rec709) continue;
    const Rgb rgb = *to_rec709 * Rgb(p[0], p[1], p[2]);
    std::copy_n(&rgb.x, 3, p);
  }
  if (choice.reads_motion) result.motion = motion_of(file, progress, path);
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
                   "it has {}, but {} has {}; the reference must cover the whole picture that is "
                   "compared with it",
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
