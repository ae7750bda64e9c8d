#include "renderer/session/display_table.h"

#include <algorithm>
#include <limits>

#include "io/image/output.h"

namespace emberline {
namespace {

using Bytes = std::array<uint8_t, 3>;

// Transforms grey values by the transform itself.
std::vector<Bytes> transformed(const DisplayTransform& transform, const std::vector<float>& grey) {
  std::vector<float> rgb;
  for (const float x : grey) rgb.insert(rgb.end(), 3, x);
  transform.apply(rgb.data(), grey.size());
  std::vector<Bytes> bytes(grey.size());
  for (size_t i = 0; i < rgb.size(); ++i) bytes[i / 3][i % 3] = to_byte(rgb[i]);
  return bytes;
}

float middle(float low, float high) {
  return std::bit_cast<float>(
      uint32_t((uint64_t(std::bit_cast<uint32_t>(low)) + std::bit_cast<uint32_t>(high)) / 2));
}

}  // namespace

std::unique_ptr<const DisplayTable> DisplayTable::make(const DisplayTransform& transform) {
  if (transform.mixes_channels()) return nullptr;
  std::vector<float> begins;
  for (uint32_t i = 0; i < kCells; ++i) begins.push_back(std::bit_cast<float>(i << 16));
  const std::vector<Bytes> cells = transformed(transform, begins);
  const std::vector<Bytes> ends = transformed(transform, {-kLargest, -1e-3f, kLargest});
  std::unique_ptr<DisplayTable> table(new DisplayTable);
  for (size_t c = 0; c < 3; ++c) {
    Curve& curve = table->curves_[c];
    for (const Bytes& bytes : cells) curve.cells.push_back(bytes[c]);
    const bool dark_below = ends[0][c] == curve.cells[0] && ends[1][c] == curve.cells[0];
    if (!dark_below || !std::ranges::is_sorted(curve.cells)) return nullptr;
  }
  // All thresholds of a channel at once: halve the floats between 0, which is below each of them,
  // and the largest, which is not.
  for (size_t c = 0; c < 3; ++c) {
    Curve& curve = table->curves_[c];
    curve.thresholds.fill(std::numeric_limits<float>::infinity());
    const size_t first = curve.cells[0], last = ends[2][c];
    std::fill_n(curve.thresholds.begin(), first, 0.0f);
    std::vector<float> low(last - first, 0.0f), high(last - first, kLargest), tried(last - first);
    for (int bit = 0; bit < 32; ++bit) {
      for (size_t k = 0; k < tried.size(); ++k) tried[k] = middle(low[k], high[k]);
      const std::vector<Bytes> bytes = transformed(transform, tried);
      for (size_t k = 0; k < tried.size(); ++k) {
        (bytes[k][c] > first + k ? high[k] : low[k]) = tried[k];
      }
    }
    std::ranges::copy(high, curve.thresholds.begin() + std::ptrdiff_t(first));
  }
  return table;
}

}  // namespace emberline
