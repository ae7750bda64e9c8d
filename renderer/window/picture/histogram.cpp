#include "renderer/window/picture/histogram.h"

#include <algorithm>

namespace emberline {
namespace {

constexpr double kUpdateInterval_s = 0.2;
// Larger pictures are subsampled; the fractions of black and clipped pixels are still accurate to a
// tenth of a percent.
constexpr size_t kMaxPixels = 300000;

}  // namespace

void Histogram::update(const std::shared_ptr<const SessionPicture>& picture, double now_s) {
  if (picture == picture_ || now_s < updated_s_ + kUpdateInterval_s) return;
  picture_ = picture;
  updated_s_ = now_s;
  counts_ = {};
  const size_t pixels = picture->rgba8.size() / 4;
  // The stride is odd, so that all columns are visited if the width is a power of two.
  const size_t stride = (pixels / kMaxPixels) | 1;
  size_t black = 0, clipped = 0, counted = 0;
  for (size_t i = 0; i < pixels; i += stride, ++counted) {
    const uint8_t* const rgb = &picture->rgba8[4 * i];
    for (size_t c = 0; c < 3; ++c) ++counts_[c][size_t(rgb[c]) * kBins / 256];
    black += rgb[0] == 0 && rgb[1] == 0 && rgb[2] == 0;
    clipped += rgb[0] == 255 || rgb[1] == 255 || rgb[2] == 255;
  }
  max_count_ = 1;
  for (const auto& channel : counts_) {
    max_count_ = std::max(max_count_, *std::max_element(channel.begin() + 1, channel.end() - 1));
  }
  const double total = double(std::max<size_t>(counted, 1));
  black_ = double(black) / total;
  clipped_ = double(clipped) / total;
}

float Histogram::height(size_t channel, int bin) const {
  return std::min(1.0f, float(counts_[channel][size_t(bin)]) / float(max_count_));
}

}  // namespace emberline
