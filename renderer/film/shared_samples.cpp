#include "renderer/film/shared_samples.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "renderer/core/parallel.h"
#include "renderer/core/rect_values.h"
#include "renderer/film/half_channels.h"
#include "renderer/film/half_sums.h"

namespace emberline {
namespace {

// If a neighbour has less than this fraction of the pixel's sample count, sharing may add more
// noise than it removes.
constexpr float kMinSampleRatio = 0.5f;
// If the sum of the weights at a pixel is smaller than this, sharing is not used there. The
// expectation of the sum is 1, but with negative filter lobes the sum may be smaller.
constexpr float kMinWeight = 0.25f;

constexpr size_t kSums = 3;  // R G B, which replace kSharedValues

std::string shared_name(const std::string& half, const char* channel) {
  return half + ".shared." + channel;
}

}  // namespace

std::vector<std::string> resolved_channel_names(std::span<const std::string> channels) {
  std::vector<std::string> names;
  for (size_t c = 0; c < channels.size(); ++c) {
    const auto half = std::ranges::find_if(
        kHalfNames, [&](const char* name) { return channels[c] == shared_name(name, "0.R"); });
    if (half == std::end(kHalfNames)) {
      names.push_back(channels[c]);
      continue;
    }
    for (const char* colour : {"R", "G", "B"}) names.push_back(shared_name(*half, colour));
    c += kSharedValues - 1;
  }
  return names;
}

ShareResolver::ShareResolver(const Rect& crop, std::span<const std::string> channels, Read read)
    : crop_(crop), channels_(channels.size()), read_(std::move(read)) {
  const auto index_of = [&](const std::string& name) {
    return size_t(std::ranges::find(channels, name) - channels.begin());
  };
  for (const std::string half : kHalfNames) {
    const size_t shared = index_of(shared_name(half, "0.R"));
    if (shared == channels.size()) continue;
    halves_.push_back({index_of(half + ".R"), index_of(half + ".samples"), shared});
    assert(halves_.back().own < shared && halves_.back().samples < shared);
    assert(shared + kSharedValues <= channels.size());
  }
}

void ShareResolver::read(const Rect& rows, std::vector<float>& pixels) {
  if (halves_.empty()) return read_(rows, pixels);
  const Rect padded_rows = Rect{rows.x0, rows.y0 - 1, rows.x1, rows.y1 + 1}.intersect(crop_);
  read_(padded_rows, input_rows_);
  const size_t resolved_channels = channels_ - halves_.size() * (kSharedValues - kSums);
  pixels.resize(size_t(rows.area()) * resolved_channels);
  parallel_each(size_t(rows.height()), [&](size_t row) {
    sum_row(padded_rows, rows.y0 + int(row),
            &pixels[row * size_t(rows.width()) * resolved_channels]);
  });
}

void ShareResolver::sum_row(const Rect& padded_rows, int y, float* to) const {
  const size_t row_stride = size_t(padded_rows.width()) * channels_;
  const float* pixel = &input_rows_[size_t(y - padded_rows.y0) * row_stride];
  for (int x = crop_.x0; x < crop_.x1; ++x, pixel += channels_) {
    const bool inside = x > crop_.x0 && x + 1 < crop_.x1 && y > crop_.y0 && y + 1 < crop_.y1;
    size_t c = 0;
    for (const HalfChannels& half : halves_) {
      to = std::copy(pixel + c, pixel + half.shared, to);
      put_sums(pixel, row_stride, inside, half, to);
      to += kSums;
      c = half.shared + kSharedValues;
    }
    to = std::copy(pixel + c, pixel + channels_, to);
  }
}

void ShareResolver::put_sums(const float* pixel, size_t row_stride, bool inside,
                             const HalfChannels& half, float* to) const {
  std::copy_n(pixel + half.own, kSums, to);
  if (!inside) return;
  const float min_count = kMinSampleRatio * pixel[half.samples];
  float sum[4] = {};
  for (size_t k = 0; k < kSharedPixels; ++k) {
    // The neighbour whose k-th share belongs to this pixel.
    const float* from = pixel + row_stride + channels_ - k / 3 * row_stride - k % 3 * channels_;
    const float count = from[half.samples];
    if (count < min_count || count <= 0.0f) return;
    const float* shared = from + half.shared + 4 * k;
    for (size_t c = 0; c < 4; ++c) sum[c] += shared[c];
  }
  if (!(sum[3] >= kMinWeight)) return;
  for (size_t c = 0; c < kSums; ++c) {
    const float value = sum[c] / sum[3];
    if (std::isfinite(value)) to[c] = value;
  }
}

void resolve_shares(const Rect& crop, std::vector<std::string>& channels,
                    std::vector<float>& pixels) {
  std::vector<std::string> names = resolved_channel_names(channels);
  if (names == channels) return;
  ShareResolver sums(crop, channels, [&](const Rect& rows, std::vector<float>& part) {
    part = extract_rect(pixels, crop, rows);
  });
  constexpr int kRows = 64;
  std::vector<float> summed, part;
  summed.reserve(size_t(crop.area()) * names.size());
  for (int y = crop.y0; y < crop.y1; y += kRows) {
    sums.read({crop.x0, y, crop.x1, std::min(y + kRows, crop.y1)}, part);
    summed.insert(summed.end(), part.begin(), part.end());
  }
  channels = std::move(names);
  pixels = std::move(summed);
}

}  // namespace emberline
