#include <cassert>
#include <cmath>

#include "io/display/display.h"

namespace emberline {

DisplayImageWriter::DisplayImageWriter(const std::string& path, const Rect& data_window,
                                       std::shared_ptr<const DisplayTransform> transform,
                                       bool alpha)
    : format_(image_format_of(path)),
      data_window_(data_window),
      transform_(std::move(transform)),
      file_(path) {
  assert(!data_window.empty() && transform_);
  image_.width = data_window.width();
  image_.height = data_window.height();
  image_.channels = alpha && format_ == "png" ? 4 : 3;
  image_.srgb = transform_->is_srgb();
  image_.values.assign(size_t(data_window.area()) * size_t(image_.channels), 0);
}

void DisplayImageWriter::write_tile(const Rect& rect, const std::vector<float>& rgba) {
  assert(rect == rect.intersect(data_window_) && rgba.size() == size_t(rect.area()) * 4);
  const size_t channels = size_t(image_.channels);
  const size_t count = size_t(rect.area());

  std::vector<float> colour(3 * count);
  for (size_t i = 0; i < count; ++i) {
    // The display curve applies to the unpremultiplied colour. Where coverage is 0, there may still
    // be light (a glow in front of an empty background). This light is not divided.
    const float a = rgba[4 * i + 3];
    const float divisor = channels == 4 && a > 0.0f && std::isfinite(a) ? a : 1.0f;
    for (size_t c = 0; c < 3; ++c) colour[3 * i + c] = rgba[4 * i + c] / divisor;
  }
  transform_->apply(colour.data(), count);

  const size_t tile_width = size_t(rect.width());
  for (size_t i = 0; i < count; ++i) {
    const size_t x = size_t(rect.x0 - data_window_.x0) + i % tile_width;
    const size_t y = size_t(rect.y0 - data_window_.y0) + i / tile_width;
    uint8_t* const target = &image_.values[(y * size_t(image_.width) + x) * channels];
    for (size_t c = 0; c < 3; ++c) target[c] = to_byte(colour[3 * i + c]);
    if (channels == 4) target[3] = to_byte(rgba[4 * i + 3]);
  }
}

void DisplayImageWriter::finish(bool complete) {
  image_.incomplete = !complete;
  const std::vector<unsigned char> bytes = encode_image(image_, format_, file_.path());
  file_.write_at(bytes.data(), bytes.size(), 0);
  file_.commit();
}

void write_display_image(const std::string& path, const Rect& data_window,
                         std::shared_ptr<const DisplayTransform> transform, bool alpha,
                         const std::vector<float>& rgba) {
  DisplayImageWriter writer(path, data_window, std::move(transform), alpha);
  writer.write_tile(data_window, rgba);
  writer.finish();
}

}  // namespace emberline
