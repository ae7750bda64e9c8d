#include <cassert>
#include <cmath>

#include "io/atomic_file.h"
#include "io/display.h"
#include "io/image_output.h"

namespace emberline {

struct DisplayImageWriter::Impl {
  Impl(const std::string& path, const Rect& data_window)
      : format(image_format_of(path)), crop(data_window), file(path) {}

  std::string format;
  Rect crop;
  AtomicFile file;
  std::shared_ptr<const DisplayTransform> transform;
  ByteImage image;
};

DisplayImageWriter::DisplayImageWriter(const std::string& path, const Rect& data_window,
                                       std::shared_ptr<const DisplayTransform> transform,
                                       bool alpha)
    : impl_(std::make_unique<Impl>(path, data_window)) {
  assert(!data_window.empty() && transform);
  ByteImage& image = impl_->image;
  image.width = data_window.width();
  image.height = data_window.height();
  image.channels = alpha && impl_->format == "png" ? 4 : 3;
  image.srgb = transform->is_srgb();
  image.values.assign(size_t(data_window.area()) * size_t(image.channels), 0);
  impl_->transform = std::move(transform);
}

DisplayImageWriter::~DisplayImageWriter() = default;

void DisplayImageWriter::write_tile(const Rect& rect, const std::vector<float>& rgba) {
  ByteImage& image = impl_->image;
  const Rect& crop = impl_->crop;
  assert(rect == rect.intersect(crop) && rgba.size() == size_t(rect.area()) * 4);
  const size_t channels = size_t(image.channels);
  const size_t count = size_t(rect.area());

  std::vector<float> colour(3 * count);
  for (size_t i = 0; i < count; ++i) {
    // The display curve belongs to the colour itself, not to its product with coverage. Where
    // coverage is 0 there may still be light (a glow before an empty background): kept as it is.
    const float a = rgba[4 * i + 3];
    const float divisor = channels == 4 && a > 0.0f && std::isfinite(a) ? a : 1.0f;
    for (size_t c = 0; c < 3; ++c) colour[3 * i + c] = rgba[4 * i + c] / divisor;
  }
  impl_->transform->apply(colour.data(), count);

  const size_t tile_width = size_t(rect.width());
  for (size_t i = 0; i < count; ++i) {
    const size_t x = size_t(rect.x0 - crop.x0) + i % tile_width;
    const size_t y = size_t(rect.y0 - crop.y0) + i / tile_width;
    uint8_t* const target = &image.values[(y * size_t(image.width) + x) * channels];
    for (size_t c = 0; c < 3; ++c) target[c] = to_byte(colour[3 * i + c]);
    if (channels == 4) target[3] = to_byte(rgba[4 * i + 3]);
  }
}

const std::string& DisplayImageWriter::path() const { return impl_->file.path(); }

uint64_t DisplayImageWriter::bytes() const { return impl_->image.values.capacity(); }

void DisplayImageWriter::finish() {
  const std::vector<unsigned char> bytes =
      encode_image(impl_->image, impl_->format, impl_->file.path());
  impl_->file.write_at(bytes.data(), bytes.size(), 0);
  impl_->file.commit();
}

}  // namespace emberline
