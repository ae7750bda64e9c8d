#include "renderer/output/scaled_picture.h"

#include <algorithm>

#include "io/display/display.h"

namespace emberline {

ScaledPicture::ScaledPicture(const Rect& crop, int max_side)
    : crop_(crop),
      factor_(std::max(1, (std::max(crop.width(), crop.height()) + max_side - 1) / max_side)),
      width_((crop.width() + factor_ - 1) / factor_),
      height_((crop.height() + factor_ - 1) / factor_),
      sums_(3 * size_t(width_) * size_t(height_)),
      counts_(size_t(width_) * size_t(height_)) {}

void ScaledPicture::add(const Rect& rect, std::span<const float> values, size_t stride) {
  const float* pixel = values.data();
  for (size_t i = 0; i < size_t(rect.area()); ++i, pixel += stride) {
    const size_t square = index_of(rect.x_of(i), rect.y_of(i));
    for (size_t c = 0; c < 3; ++c) sums_[3 * square + c] += pixel[c];
    ++counts_[square];
  }
}

ByteImage ScaledPicture::display(const DisplayTransform& transform) const {
  std::vector<float> rgb(sums_);
  for (size_t i = 0; i < rgb.size(); ++i) rgb[i] /= float(std::max(1u, counts_[i / 3]));
  transform.apply(rgb.data(), counts_.size());
  ByteImage image{.width = width_, .height = height_, .values = {}, .srgb = transform.is_srgb()};
  image.values.reserve(rgb.size());
  for (const float value : rgb) image.values.push_back(to_byte(value));
  return image;
}

uint64_t ScaledPicture::bytes() const {
  return sums_.capacity() * sizeof(float) + counts_.capacity() * sizeof(uint32_t);
}

}  // namespace emberline
