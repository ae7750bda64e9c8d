#include "renderer/app/commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>

#include "io/exr/writer.h"
#include "io/files/atomic_file.h"
#include "io/files/register.h"
#include "io/files/write_attempts.h"
#include "io/image/file_completeness.h"
#include "io/image/input.h"
#include "renderer/app/failure.h"
#include "renderer/app/frame_animation.h"
#include "renderer/app/frame_range.h"
#include "renderer/core/errors.h"
#include "renderer/core/file_suffix.h"
#include "renderer/core/log.h"
#include "renderer/core/parallel.h"
#include "renderer/core/rect_values.h"
#include "renderer/core/shell_quote.h"
#include "renderer/engine/worker_threads.h"
#include "renderer/output/outputs.h"
#include "renderer/output/rgb_file.h"
#include "renderer/statistics/heatmap_quantity.h"

namespace emberline {
namespace {

constexpr int kMaxAnimationSide = 640;  // pixels
constexpr const char* kTransparentAttribute = "emberline:transparent";
// The header attributes that are copied from the frame to an .exr with one layer.
constexpr std::string_view kKeptAttributes[] = {kCompleteAttribute, "emberline:samples",
                                                kTransparentAttribute};

// Returns the heatmap quantity that needs only this channel; "" if there is none.
std::string_view heatmap_of(std::string_view channel) {
  for (const HeatmapQuantity& quantity : heatmap_quantity_table()) {
    if (quantity.channels.size() == 1 && quantity.channels[0] == channel) return quantity.name;
  }
  return {};
}

// `hints`: whether the log may suggest something better.
ImageLayer choose_layer(const ShowOptions& options, const FloatImage& image, bool hints) {
  if (options.layer.empty()) {
    const ColourChannels colour =
        find_colour(image.channel_names, image.parts, options.image, "choose one with `layer`");
    ImageLayer layer = {image.channel_names[size_t(colour.first)], {}, -1, colour.count == 3};
    for (int c = 0; c < colour.count; ++c) layer.channels.push_back(colour.first + c);
    if (colour.has_alpha) layer.alpha = colour.first + colour.count;
    return layer;
  }
  ImageLayer layer = find_frame_layer(image, options.layer, options.image);
  if (!layer.is_number()) {
    // The denoised picture has the same alpha as the raw picture.
    if (layer.name == kDenoisedLayer) layer.alpha = image.find_channel("A");
    return layer;
  }
  const std::string_view quantity = heatmap_of(image.channel_names[size_t(layer.channels.front())]);
  const auto picture = std::ranges::find_if_not(options.outputs, is_exr);
  if (hints && !quantity.empty() && picture != options.outputs.end()) {
    log_info(
        fmt::format("a heatmap with a legend shows {} better: emberline heatmap {} -o {} --of {}",
                    layer.name, shell_quoted(options.image), shell_quoted(*picture), quantity));
  }
  return layer;
}

// Whether a .png gets the layer's alpha. If Emberline rendered the frame, the frame's --transparent
// decides. In other files, an alpha channel is enough.
bool is_transparent(const FloatImageRows& file, const ImageLayer& layer) {
  if (layer.alpha < 0) return false;
  const auto is_ours = [](const auto& attribute) { return attribute.first == kCompleteAttribute; };
  return std::ranges::none_of(file.text_attributes(), is_ours) ||
         is_marked(file, kTransparentAttribute);
}

// Returns the width and height of the tiles to be written, which is also the number of rows to be
// read at once. Tiles are at least 64 pixels wide (unless the picture is smaller), because each
// tile has an entry in the file's table and is compressed separately.
int tile_side(const FloatImageRows& file) {
  constexpr int kLeast = 64;
  const int step = file.rows_at_once();
  const int rows = (std::max(step, kLeast) + step - 1) / step * step;
  return std::min(rows, std::max(file.image().width, file.image().height));
}

// Calls `use` with each band of rows and its pixels, from top to bottom.
template <typename Use>
void read_bands(FloatImageRows& file, const Use& use) {
  const Rect& window = file.image().data_window;
  std::vector<float> pixels;
  for (int y = window.y0; y < window.y1;) {
    const Rect band = Rect{window.x0, y, window.x1, y + tile_side(file)}.intersect(window);
    file.read(band.height(), pixels);
    use(band, pixels);
    y = band.y1;
  }
}

// The values to be shown as black and as white.
struct GreyRange {
  float black = 0.0f, white = 1.0f;
};

// Returns the least and greatest values of the layer in all these files, or 0 and 1 if all values
// are between 0 and 1. If all values are equal and outside [0, 1], the range extends to 0. Ignores
// values that are not finite, magnitudes of 1e10 or more (the background's depth), and frames of a
// sequence that are not readable.
GreyRange grey_range(const ShowOptions& options, std::span<const std::string> paths) {
  constexpr float kBackground = 1e10f;  // depth that Emberline and Blender write for the background
  float least = std::numeric_limits<float>::infinity(), greatest = -least;
  for (const std::string& path : paths) {
    try {
      FloatImageRows file(path, LoadProgress({}, {}, limits_of(options.limits, path)));
      const ImageLayer layer = find_frame_layer(file.image(), options.layer, path);
      if (!layer.is_number()) return {};
      const size_t stride = file.image().channel_names.size(), channel = size_t(layer.channels[0]);
      read_bands(file, [&](const Rect&, const std::vector<float>& pixels) {
        for (size_t i = channel; i < pixels.size(); i += stride) {
          if (!(std::abs(pixels[i]) < kBackground)) continue;
          least = std::min(least, pixels[i]);
          greatest = std::max(greatest, pixels[i]);
        }
      });
    } catch (const LimitError&) {
      throw;
    } catch (const std::exception&) {
      if (paths.size() == 1) throw;
    }
  }
  if (!(least < 0.0f || greatest > 1.0f)) return {};
  if (least == greatest) (least > 0.0f ? least : greatest) = 0.0f;
  log_info(fmt::format("{}: black is {:.6g}, white is {:.6g}", options.layer, least, greatest));
  return {least, greatest};
}

// Converts the layer's values to interleaved R, G, B and A.
class LayerColours {
 public:
  LayerColours(const FloatImage& image, const ImageLayer& layer, const std::string& path)
      : layer_(layer), stride_(image.channel_names.size()) {
    const bool is_foreign = image.space == WorkingSpace::kRec709 && image.chromaticities;
    if (layer.has_colour && is_foreign) to_rec709_ = to_rec709(*image.chromaticities, path);
  }

  std::vector<float> convert(const std::vector<float>& pixels) const {
    const std::vector<int>& channels = layer_.channels;
    std::vector<float> rgba(pixels.size() / stride_ * 4);
    float* next = rgba.data();
    for (size_t i = 0; i < pixels.size(); i += stride_, next += 4) {
      for (size_t k = 0; k < 3; ++k) {
        const size_t c = channels.size() == 1 ? 0 : k;
        next[k] = c < channels.size() ? pixels[i + size_t(channels[c])] : 0.0f;
      }
      if (to_rec709_) {
        const Rgb rgb = *to_rec709_ * Rgb(next[0], next[1], next[2]);
        std::copy_n(&rgb.x, 3, next);
      }
      next[3] = layer_.alpha >= 0 ? pixels[i + size_t(layer_.alpha)] : 1.0f;
    }
    return rgba;
  }

 private:
  const ImageLayer& layer_;
  const size_t stride_;
  ToWorkingSpace to_rec709_;
};

// The outputs of a frame. Files are opened before the pixels are read.
class ShownFrame {
 public:
  // `animation` may be null. Otherwise it has begun this frame.
  ShownFrame(const ShowOptions& options, const FloatImageRows& file, const ImageLayer& layer,
             FrameAnimation* animation)
      : tile_size_(tile_side(file)), has_alpha_(layer.alpha >= 0), animation_(animation) {
    const WorkingSpace space = layer.has_colour ? file.image().space : WorkingSpace::kRec709;
    if (animation || !std::ranges::all_of(options.outputs, is_exr)) {
      transform_ = std::make_shared<DisplayTransform>(options.display, space);
    }
    for (const std::string& path : options.outputs) {
      if (is_exr(path)) {
        exrs_.push_back(
            {path, std::make_unique<ExrWriter>(path, header(options, file, layer, space))});
      } else {
        images_.push_back(std::make_unique<DisplayImageWriter>(
            path, file.image().data_window, transform_, is_transparent(file, layer)));
      }
    }
  }

  void write(const Rect& band, std::vector<float> rgba, const GreyRange& range) {
    if (!exrs_.empty()) write_exrs(band, rgba);
    if (!transform_) return;
    if (range.black != 0.0f || range.white != 1.0f) {
      for (size_t i = 0; i < rgba.size(); ++i) {
        if (i % 4 < 3) rgba[i] = (rgba[i] - range.black) / (range.white - range.black);
      }
    }
    if (animation_) animation_->add(band, rgba);
    for_tiles(band, rgba, [this](const Rect& tile, const std::vector<float>& pixels) {
      for (const auto& image : images_) image->write_tile(tile, pixels);
    });
  }

  void finish(bool complete, WriteAttempts& attempts) {
    if (animation_) animation_->end(*transform_);
    for (const auto& [path, writer] : exrs_) attempts.attempt(path, [&] { writer->finish(); });
    for (const auto& image : images_) {
      attempts.attempt(image->path(), [&] { image->finish(complete); });
    }
  }

 private:
  static ExrHeader header(const ShowOptions& options, const FloatImageRows& file,
                          const ImageLayer& layer, WorkingSpace space) {
    const FloatImage& image = file.image();
    ExrHeader header = {
        .width = image.frame_width,
        .height = image.frame_height,
        .data_window = image.data_window,
        .tile_size = tile_side(file),
        .channels = {{"R"}, {"G"}, {"B"}},
        .view = file.view(),
        .attributes = {{"emberline.image", options.image}, {"emberline.layer", options.layer}}};
    if (layer.alpha >= 0) header.channels.push_back({"A"});
    header.view.space = space;
    for (const auto& attribute : file.text_attributes()) {
      if (std::ranges::find(kKeptAttributes, attribute.first) != std::end(kKeptAttributes)) {
        header.attributes.push_back(attribute);
      }
    }
    return header;
  }

  template <typename Write>
  void for_tiles(const Rect& band, const std::vector<float>& pixels, const Write& write) const {
    parallel_tasks(size_t((band.width() + tile_size_ - 1) / tile_size_), [&](size_t i) {
      const int x = band.x0 + int(i) * tile_size_;
      const Rect tile = Rect{x, band.y0, x + tile_size_, band.y1}.intersect(band);
      write(tile, extract_rect(pixels, band, tile));
    });
  }

  void write_exrs(const Rect& band, const std::vector<float>& rgba) {
    std::vector<float> pixels = rgba;
    if (!has_alpha_) {
      size_t count = 0;
      for (size_t i = 0; i < rgba.size(); ++i) {
        if (i % 4 < 3) pixels[count++] = rgba[i];
      }
      pixels.resize(count);
    }
    for_tiles(band, pixels, [this](const Rect& tile, const std::vector<float>& values) {
      for (const auto& [path, writer] : exrs_) writer->write_tile(tile, values);
    });
  }

  const int tile_size_;
  const bool has_alpha_;
  FrameAnimation* const animation_;
  std::shared_ptr<const DisplayTransform> transform_;  // if a file or the animation needs it
  std::vector<std::pair<std::string, std::unique_ptr<ExrWriter>>> exrs_;
  std::vector<std::unique_ptr<DisplayImageWriter>> images_;
};

// Returns the memory for a band of rows of the file, of the layer and of its tiles. For each .png
// or .jpg, adds the 8-bit pixels and the encoded file, which is at most as large. For each .exr,
// adds its table of tiles.
uint64_t shown_bytes(const ShowOptions& options, const FloatImageRows& file,
                     const ImageLayer& layer) {
  const FloatImage& image = file.image();
  const auto band_pixels =
      uint64_t(image.width) * uint64_t(std::min(tile_side(file), image.height));
  const auto side = uint64_t(tile_side(file));
  const uint64_t tiles =
      (uint64_t(image.width) + side - 1) / side * ((uint64_t(image.height) + side - 1) / side);
  uint64_t bytes = bytes_of(band_pixels, (image.channel_names.size() + 16) * sizeof(float));
  for (const std::string& path : options.outputs) {
    const uint64_t picture =
        bytes_of(uint64_t(image.data_window.area()), is_transparent(file, layer) ? 8 : 6);
    bytes += is_exr(path) ? bytes_of(tiles, sizeof(uint64_t)) : picture;
  }
  return bytes;
}

// What happens to a sequence as a whole.
struct SequenceState {
  bool hints = true;  // whether the log may suggest something better
  GreyRange range;
  FrameAnimation* animation = nullptr;
  bool prefers_denoised = false;              // without --layer
  void (*log)(std::string_view) = log_error;  // for frames that fail
  std::vector<int> animated;                  // frames that are in the animation
};

bool is_displayed(const ShowOptions& options) {
  return !std::ranges::all_of(options.outputs, is_exr);
}

// Begins the frame in the animation, if there is one. Returns false if it cannot have this frame.
// If memory is short, the animation ends.
bool begin_animated(SequenceState& sequence, const Rect& window, const std::string& path,
                    const LoadProgress& progress) {
  if (!sequence.animation) return true;
  try {
    sequence.animation->begin(window, path, progress);
    return true;
  } catch (const InputError& error) {
    sequence.log(error.what());
    if (dynamic_cast<const LimitError*>(&error)) sequence.animation = nullptr;
    return false;
  }
}

int show_frame(const ShowOptions& options, SequenceState& sequence) {
  const LoadProgress progress({}, {}, limits_of(options.limits, options.image));
  FloatImageRows file(options.image, progress);
  const FloatImage& image = file.image();
  for (const std::string& path : options.outputs) check_picture_format(path, image.data_window);
  const bool is_denoised = image.find_channel(std::string(kDenoisedLayer) + ".R") >= 0;
  ShowOptions chosen = options;
  if (is_denoised && sequence.prefers_denoised) chosen.layer = kDenoisedLayer;
  const ImageLayer layer = choose_layer(chosen, image, sequence.hints);
  const MemoryReservation memory(progress.budget(), MemoryPart::kFilm,
                                 shown_bytes(options, file, layer), options.image);
  warn_if_stopped(options.image, image);
  if (sequence.hints && chosen.layer.empty() && is_denoised &&
      image.channel_names[size_t(layer.channels.front())] != std::string(kDenoisedLayer) + ".R") {
    log_info(
        fmt::format("showing R, G and B of {}, which are not denoised; --layer {} shows the "
                    "denoised picture",
                    options.image, kDenoisedLayer));
  }
  const bool is_animated = begin_animated(sequence, image.data_window, options.image, progress);
  ShownFrame shown(options, file, layer, is_animated ? sequence.animation : nullptr);
  const LayerColours colours(image, layer, options.image);
  read_bands(file, [&](const Rect& band, const std::vector<float>& pixels) {
    shown.write(band, colours.convert(pixels), sequence.range);
  });
  WriteAttempts attempts;
  shown.finish(!image.stopped_after, attempts);
  for (const std::string& path : attempts.written()) log_info("wrote " + path);
  if (!attempts.failed().empty()) return kExitRenderFailed;
  return is_animated ? kExitDone : kExitInput;
}

ShowOptions options_of_frame(const ShowOptions& options, int number) {
  ShowOptions one = options;
  one.image = expand_frame_number(options.image, number);
  for (std::string& path : one.outputs) path = expand_frame_number(path, number);
  return one;
}

// Converts the frames. `options` has only outputs for single frames. Returns the exit code.
int show_frames(const ShowOptions& options, std::span<const int> frames, SequenceState& sequence) {
  if (!options.layer.empty() && (sequence.animation || is_displayed(options))) {
    std::vector<std::string> paths;
    for (const int number : frames) paths.push_back(expand_frame_number(options.image, number));
    sequence.range = grey_range(options, paths);
  }
  int exit_code = kExitDone;
  for (const int number : frames) {
    if (options.outputs.empty() && !sequence.animation) break;  // memory has ended the animation
    try {
      const int code = show_frame(options_of_frame(options, number), sequence);
      if (code == kExitDone && sequence.animation) sequence.animated.push_back(number);
      exit_code = std::max(exit_code, code);
      sequence.hints = false;
    } catch (const std::exception& error) {
      // If no frame has been shown yet, a usage error probably affects all frames.
      const Failure failure = failure_of(error);
      if (sequence.hints && failure.exit_code == kExitUsage) throw;
      sequence.log(failure.message);
      exit_code = std::max(exit_code, failure.exit_code);
    }
  }
  return exit_code;
}

int show_sequence(ShowOptions options) {
  const std::vector<int> frames =
      options.frames.empty() ? existing_frames(options.image) : options.frames;
  std::vector<std::string> gifs;
  std::erase_if(options.outputs, [&](const std::string& path) {
    if (is_gif(path)) gifs.push_back(path);
    return is_gif(path);
  });
  FileRegister files;
  for (const int number : frames) {
    files.read(expand_frame_number(options.image, number), "it is a frame of the sequence");
  }
  for (const std::string& path : options.outputs) {
    if (frames.size() > 1) check_frame_number("-o", path, options.image);
    for (const int number : frames) {
      const std::string file = expand_frame_number(path, number);
      check_picture_format(file, {});
      files.write("-o", file);
    }
    check_writable(expand_frame_number(path, frames.front()));
  }
  for (const std::string& path : gifs) {
    files.write("-o", path);
    check_writable(path);
  }
  FrameAnimation animation(kMaxAnimationSide);
  SequenceState sequence;
  if (!gifs.empty()) sequence.animation = &animation;
  const int exit_code = show_frames(options, frames, sequence);
  WriteAttempts attempts;
  for (const std::string& path : gifs) {
    if (animation.size() == 0) break;
    attempts.attempt(path, [&] {
      const std::vector<unsigned char> gif =
          animation.encode(options.fps.value_or(kAnimationFps), path);
      write_file_atomically(path, {reinterpret_cast<const char*>(gif.data()), gif.size()});
    });
  }
  for (const std::string& path : attempts.written()) {
    log_info(fmt::format("wrote {} ({} frame{})", path, animation.size(),
                         animation.size() == 1 ? "" : "s"));
  }
  return attempts.failed().empty() ? exit_code : std::max<int>(exit_code, kExitRenderFailed);
}

}  // namespace

int run_show(const ShowOptions& options) {
  const WorkerThreads workers(0);
  const auto gif = std::ranges::find_if(options.outputs, is_gif);
  if (options.fps && gif == options.outputs.end()) {
    throw UsageError("--fps needs a .gif output, such as -o shot.gif");
  }
  if (is_sequence(options.image)) return show_sequence(options);
  if (gif != options.outputs.end() || !options.frames.empty()) {
    throw UsageError("{} needs a sequence: write #### instead of the frame's number in {}",
                     options.frames.empty() ? "-o " + *gif : "--frames", options.image);
  }
  FileRegister files;
  files.read(options.image, "it is the frame itself");
  for (const std::string& path : options.outputs) {
    check_picture_format(path, {});
    files.write("-o", path);
  }
  SequenceState sequence;
  // Without --layer, a single channel is the luminance. It is displayed like a picture, so it needs
  // no range.
  if (!options.layer.empty() && is_displayed(options)) {
    sequence.range = grey_range(options, std::array{options.image});
  }
  return show_frame(options, sequence);
}

AnimatedFrames animate_frames(const ShowOptions& options, int max_side, const Rect& window) {
  ShowOptions animated = options;
  animated.outputs.clear();
  animated.layer.clear();
  FrameAnimation animation(max_side, window);
  SequenceState sequence;
  sequence.hints = false;
  sequence.animation = &animation;
  sequence.prefers_denoised = true;
  sequence.log = log_warning;
  show_frames(animated, options.frames, sequence);
  if (animation.size() == 0) return {};
  return {animation.encode(options.fps.value_or(kAnimationFps), options.image), animation.width(),
          animation.height(), sequence.animated};
}

}  // namespace emberline
