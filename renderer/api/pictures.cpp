// Reads, writes and compares pictures.
#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <span>

#include "io/display/display.h"
#include "io/display/working_space.h"
#include "io/exr/writer.h"
#include "io/image/file_completeness.h"
#include "io/image/input.h"
#include "io/image/output.h"
#include "renderer/api/frame_parts.h"
#include "renderer/core/file_suffix.h"
#include "renderer/core/shortened.h"
#include "renderer/core/utf8.h"
#include "renderer/output/outputs.h"
#include "renderer/statistics/error_metrics.h"
#include "renderer/statistics/flip.h"

namespace emberline::api {
namespace {

size_t channel(const std::string& path, const Picture& picture, const std::string& name) {
  const auto found = std::ranges::find(picture.channels, name);
  if (found == picture.channels.end()) {
    throw emberline::UsageError(path + ": the picture has no channel " + name);
  }
  return size_t(found - picture.channels.begin());
}

// Returns the named channels, interleaved.
std::vector<float> values_of(const std::string& path, const Picture& picture,
                             std::span<const std::string> names) {
  std::vector<size_t> offsets;
  for (const std::string& name : names) offsets.push_back(channel(path, picture, name));
  std::vector<float> values;
  values.reserve(picture.values.size() / picture.channels.size() * names.size());
  for (size_t i = 0; i < picture.values.size(); i += picture.channels.size()) {
    for (const size_t offset : offsets) values.push_back(picture.values[i + offset]);
  }
  return values;
}

Rect pixels_of(const Picture& picture) {
  return {picture.x, picture.y, picture.x + picture.width, picture.y + picture.height};
}

void write_exr(const std::string& path, const Picture& picture) {
  const Rect pixels = pixels_of(picture);
  ExrHeader header;
  header.width = picture.frame_width > 0 ? picture.frame_width : pixels.x1;
  header.height = picture.frame_height > 0 ? picture.frame_height : pixels.y1;
  header.data_window = pixels;
  for (const std::string& name : picture.channels) header.channels.push_back({name});
  if (!picture.complete) {
    header.attributes = {{kCompleteAttribute, "false"},
                         {"emberline:samples", std::to_string(picture.samples)}};
  }
  write_exr_file(path, header, picture.values);
}

// The contents of a PNG or JPEG: the layer whose R, G and B are shown, whether alpha is included,
// and the layer's colour space.
struct DisplayLayer {
  std::string layer = {};
  bool alpha = false;
  WorkingSpace space = WorkingSpace::kRec709;
};

void write_displayed(const std::string& path, const Picture& picture, double exposure,
                     const DisplayLayer& display_layer) {
  const std::string suffix = lower_suffix(path);
  if (suffix != ".png" && suffix != ".jpg" && suffix != ".jpeg") {
    throw emberline::UsageError(
        "\"{}\": unknown format; valid suffixes are .exr, .png, .jpg, .jpeg", printable(path));
  }
  std::vector<std::string> names;
  for (const char* c : {"R", "G", "B"}) names.push_back(display_layer.layer + c);
  if (display_layer.alpha) names.push_back("A");
  const std::vector<float> values = values_of(path, picture, names);
  std::vector<float> rgba(values.size() / names.size() * 4, 1.0f);
  for (size_t i = 0; i < rgba.size() / 4; ++i) {
    std::copy_n(&values[i * names.size()], names.size(), &rgba[4 * i]);
  }
  const DisplaySettings display{.display = {}, .view = {}, .look = {}, .exposure = float(exposure)};
  write_display_image(path, {0, 0, picture.width, picture.height},
                      std::make_shared<const DisplayTransform>(display, display_layer.space),
                      display_layer.alpha, rgba);
}

// Writes the same file as the command.
void write_frame_exr(const std::string& path, const Picture& picture, OutputSettings output,
                     const SceneLayers& layers) {
  output.is_clamped = false;  // the picture does not store how much was clamped
  if (output.width != picture.frame_width || output.height != picture.frame_height ||
      output.crop != pixels_of(picture)) {
    throw emberline::UsageError(
        path + ": the picture's pixels or channels have changed since it was rendered");
  }
  std::vector<PictureChannel> channels;
  const std::vector<PictureChannel> of_film = film_channels(output.aovs);
  for (const std::string& name : picture.channels) {
    const auto same = std::ranges::find(of_film, name, &PictureChannel::name);
    channels.push_back(same != of_film.end() ? *same : PictureChannel{name});
  }
  ExrWriter writer(path, frame_header(output, std::move(channels), layers));
  writer.write(picture.values);
  set_state(output, {picture.complete, picture.samples}, writer);
  writer.finish();
}

// Converts the colours to Rec. 709. Variances and half images stay unchanged, because they are
// meant for computation and not for viewing.
void make_rec709(WorkingSpace space, Picture& picture) {
  const ToWorkingSpace to_rec709 = from_working_space(space);
  if (!to_rec709) return;
  const size_t stride = picture.channels.size();
  for (const std::string& red : picture.channels) {
    if (!is_colour(red) || !red.ends_with('R')) continue;
    std::array<size_t, 3> offsets;
    for (size_t c = 0; c < 3; ++c) {
      const std::string name = red.substr(0, red.size() - 1) + "RGB"[c];
      offsets[c] = size_t(std::ranges::find(picture.channels, name) - picture.channels.begin());
    }
    if (std::ranges::max(offsets) >= stride) continue;
    for (size_t i = 0; i < picture.values.size(); i += stride) {
      float* const pixel = &picture.values[i];
      const Rgb rgb = *to_rec709 * Rgb(pixel[offsets[0]], pixel[offsets[1]], pixel[offsets[2]]);
      for (int c = 0; c < 3; ++c) pixel[offsets[size_t(c)]] = rgb[c];
    }
  }
}

void check_exposure(double exposure) {
  if (!(std::abs(exposure) <= 100))
    throw emberline::UsageError("exposure: expected a number from -100 to 100 stops");
}

RgbImage rgb_image(const float* values, int width, int height) {
  return {width, height, {values, values + 3 * size_t(width) * size_t(height)}};
}

struct Pair {
  RgbImage image, reference;
};
Pair pair_of(const float* image, const float* reference, int width, int height, double exposure) {
  check_exposure(exposure);
  if (width <= 0 || height <= 0)
    throw emberline::UsageError("compare: the pictures have no pixels");
  return {rgb_image(image, width, height), rgb_image(reference, width, height)};
}

}  // namespace

void check_picture(const std::string& path, const Picture& picture) {
  const auto throw_invalid = [&](const std::string& what) {
    throw emberline::UsageError(path + ": the picture has " + what);
  };
  if (picture.width <= 0 || picture.height <= 0) throw_invalid("no pixels");
  const size_t pixels = size_t(picture.width) * size_t(picture.height);
  if (picture.channels.size() > size_t(kMaxChannels)) {
    throw_invalid("more than " + std::to_string(kMaxChannels) +
                  " channels, which is not supported");
  }
  if (picture.channels.empty() || picture.values.size() % pixels != 0 ||
      picture.values.size() / pixels != picture.channels.size()) {
    throw_invalid("a number of values that does not match its size and channels");
  }
  std::set<std::string_view> names;
  for (const std::string& name : picture.channels) {
    // OpenEXR limits names to 255 bytes.
    if (name.empty() || name.size() > 255 || name.find('\0') != std::string::npos) {
      throw_invalid("a channel with an invalid name: \"" + printable(shortened(name)) + "\"");
    }
    if (!names.insert(name).second) throw_invalid("two channels called " + printable(name));
  }
}

RenderedPicture::RenderedPicture(Picture picture) : Picture(std::move(picture)) {}

std::vector<float> RenderedPicture::rec709() const {
  return translate_errors([&] {
    check_picture("rec709", *this);
    Picture rgb;
    rgb.channels = {"R", "G", "B"};
    rgb.values = values_of("rec709", *this, rgb.channels);
    if (record_) make_rec709(record_->output.view.space, rgb);
    return std::move(rgb.values);
  });
}

RenderedPicture rendered_picture(Picture picture, const OutputSettings& output,
                                 const SceneLayers& layers, const RenderCounters& counters,
                                 std::optional<double> error_estimate, bool complete) {
  warn_about_optics(counters.optics);
  picture.samples = counters.samples;
  picture.rays = counters.rays.total();
  picture.non_finite_samples = counters.non_finite_samples;
  picture.error_estimate = error_estimate;
  picture.complete = complete;
  RenderedPicture rendered(std::move(picture));
  Access::impl(rendered) =
      std::shared_ptr<const Access::Record>(new Access::Record{output, layers});
  return rendered;
}

Picture read_picture(const std::string& path, const Resources& resources,
                     const std::stop_token& stop) {
  return translate_errors([&] {
    check_resources(resources);
    LoadProgress progress({}, stop,
                          limits_of({resources.memory_bytes, resources.load_timeout_s}, path));
    FloatImage file = read_float_image(path, progress);
    Picture picture;
    picture.width = file.width;
    picture.height = file.height;
    picture.x = file.data_window.x0;
    picture.y = file.data_window.y0;
    picture.frame_width = file.frame_width;
    picture.frame_height = file.frame_height;
    picture.channels = std::move(file.channel_names);
    picture.values = std::move(file.values);
    picture.samples = file.stopped_after.value_or(0);
    picture.complete = !file.stopped_after;
    make_rec709(file.space, picture);
    return picture;
  });
}

void write_picture(const std::string& path, const Picture& picture, double exposure) {
  translate_errors([&] {
    check_picture(path, picture);
    check_exposure(exposure);
    if (lower_suffix(path) == ".exr") {
      write_exr(path, picture);
    } else {
      write_displayed(path, picture, exposure, {});
    }
  });
}

void write_picture(const std::string& path, const RenderedPicture& picture, double exposure) {
  const Access::Record* const record = Access::impl(picture);
  if (!record) return write_picture(path, static_cast<const Picture&>(picture), exposure);
  translate_errors([&] {
    check_picture(path, picture);
    check_exposure(exposure);
    const OutputSettings& output = record->output;
    if (lower_suffix(path) == ".exr") {
      return write_frame_exr(path, picture, output, record->layers);
    }
    write_displayed(path, picture, exposure,
                    {.layer = output.denoise ? "denoised." : "",
                     .alpha = output.transparent && lower_suffix(path) == ".png",
                     .space = output.view.space});
  });
}

void write_picture(const std::string& path, const uint8_t* values, int width, int height,
                   int channels) {
  translate_errors([&] {
    if (width <= 0 || height <= 0)
      throw emberline::UsageError(path + ": the picture has no pixels");
    if (channels != 1 && channels != 3 && channels != 4) {
      throw emberline::UsageError(path + ": an 8-bit picture must have 1, 3 or 4 channels");
    }
    const size_t count = size_t(width) * size_t(height) * size_t(channels);
    write_image(path, {width, height, channels, {values, values + count}});
  });
}

Comparison compare(const float* image, const float* reference, int width, int height,
                   double exposure) {
  return translate_errors([&] {
    const Pair pair = pair_of(image, reference, width, height, exposure);
    const ErrorMetrics m = compare_images(pair.image, pair.reference, {float(exposure)});
    return Comparison{
        m.mse,  m.rmse, m.rel_mse, m.rel_mse_epsilon, m.rel_mse_trimmed,  m.signed_bias,
        m.psnr, m.ssim, m.flip,    m.max_absolute,    m.different_pixels, m.non_finite};
  });
}

std::vector<float> flip(const float* image, const float* reference, int width, int height,
                        double exposure) {
  return translate_errors([&] {
    const Pair pair = pair_of(image, reference, width, height, exposure);
    const std::vector<uint8_t> masked = non_finite_pixels(pair.image, pair.reference);
    std::vector<float> map = flip_map(to_display(pair.image, float(exposure), masked),
                                      to_display(pair.reference, float(exposure), masked));
    for (size_t i = 0; i < map.size(); ++i) {
      if (masked[i]) map[i] = 0.0f;
    }
    return map;
  });
}

}  // namespace emberline::api
