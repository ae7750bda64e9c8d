#include "renderer/session/grading.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "io/image/output.h"
#include "renderer/core/errors.h"
#include "renderer/core/parallel.h"

namespace emberline {
namespace {

// Rows per task of grade(), and pixels per task of to_display().
constexpr size_t kRows = 8;
constexpr size_t kPixels = 4096;

DisplaySettings with_exposure(DisplaySettings settings, float exposure) {
  if (!std::isfinite(exposure)) throw UsageError("`exposure`: not a finite number");
  settings.exposure = exposure;
  return settings;
}

bool same_colour(const float* a, const float* b) {
  return std::memcmp(a, b, 3 * sizeof(float)) == 0;
}

using Bytes = std::array<uint8_t, 3>;

// Converts grey values with the transform, without a table.
std::vector<Bytes> grade_grey(const DisplayTransform& transform, const std::vector<float>& grey) {
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

// Tabulates a display transform that treats channels independently. byte(c, x) returns the display
// byte of channel c for the linear value x. This byte equals the number of thresholds that x has
// reached. A table, indexed by the upper 16 bits of x, gives the byte of the smallest value with
// these bits; then x is compared with the next few thresholds.
//
// The curve must be increasing except for rounding. Near a threshold the table may differ from the
// transform by a few units in the last place of x.
class DisplayTable {
 public:
  // Returns null if the transform mixes channels, as film looks do, or if a curve is not
  // increasing.
  static std::unique_ptr<const DisplayTable> make(const DisplayTransform& transform) {
    if (transform.mixes_channels()) return nullptr;
    std::vector<float> begins;
    for (uint32_t i = 0; i < kCells; ++i) begins.push_back(std::bit_cast<float>(i << 16));
    const std::vector<Bytes> cells = grade_grey(transform, begins);
    const std::vector<Bytes> ends = grade_grey(transform, {-kMaxValue, -1e-3f, kMaxValue});
    std::unique_ptr<DisplayTable> table(new DisplayTable);
    for (size_t c = 0; c < 3; ++c) {
      Curve& curve = table->curves_[c];
      for (const Bytes& bytes : cells) curve.cells.push_back(bytes[c]);
      const bool dark_below = ends[0][c] == curve.cells[0] && ends[1][c] == curve.cells[0];
      if (!dark_below || !std::ranges::is_sorted(curve.cells)) return nullptr;
    }
    // Finds all thresholds of a channel at once, by bisection over the bit patterns of floats. All
    // thresholds lie above 0 and do not exceed kMaxValue.
    for (size_t c = 0; c < 3; ++c) {
      Curve& curve = table->curves_[c];
      curve.thresholds.fill(std::numeric_limits<float>::infinity());
      const size_t first = curve.cells[0], last = ends[2][c];
      std::fill_n(curve.thresholds.begin(), first, 0.0f);
      std::vector<float> low(last - first, 0.0f), high(last - first, kMaxValue),
          candidates(last - first);
      for (int bit = 0; bit < 32; ++bit) {
        for (size_t k = 0; k < candidates.size(); ++k) candidates[k] = middle(low[k], high[k]);
        const std::vector<Bytes> bytes = grade_grey(transform, candidates);
        for (size_t k = 0; k < candidates.size(); ++k) {
          (bytes[k][c] > first + k ? high[k] : low[k]) = candidates[k];
        }
      }
      std::ranges::copy(high, curve.thresholds.begin() + std::ptrdiff_t(first));
    }
    return table;
  }

  uint8_t byte(size_t channel, float x) const {
    const Curve& curve = curves_[channel];
    if (!(x > 0.0f)) return curve.cells[0];  // NaN counts as 0
    if (x > kMaxValue) x = kMaxValue;
    uint32_t reached = curve.cells[std::bit_cast<uint32_t>(x) >> 16];
    while (x >= curve.thresholds[reached]) ++reached;
    return uint8_t(reached);
  }

 private:
  static constexpr float kMaxValue = 65504.0f;  // as in DisplayTransform::apply
  static constexpr size_t kCells = (std::bit_cast<uint32_t>(kMaxValue) >> 16) + 1;

  struct Curve {
    // thresholds[k] is the smallest x whose byte is at least k + 1; infinity if there is none.
    std::array<float, 256> thresholds;
    // Indexed by the upper 16 bits of x: the byte of the smallest x with these bits.
    std::vector<uint8_t> cells;
  };

  DisplayTable() = default;

  std::array<Curve, 3> curves_;
};

Grading::Grading(const DisplaySettings& settings)
    : settings_(with_exposure(settings, settings.exposure)),
      transform_(std::make_shared<const DisplayTransform>(with_exposure(settings, 0.0f))),
      table_(DisplayTable::make(*transform_)),
      scale_(std::exp2(settings.exposure)) {}

Grading::Grading(const Grading& other, float exposure)
    : settings_(with_exposure(other.settings_, exposure)),
      transform_(other.transform_),
      table_(other.table_),
      scale_(std::exp2(exposure)) {}

void Grading::grade_run(std::span<const float> rgba, std::span<uint8_t> rgba8) const {
  const size_t pixels = rgba.size() / 4;
  if (table_) {
    for (size_t i = 0; i < pixels; ++i) {
      for (size_t c = 0; c < 3; ++c) {
        rgba8[4 * i + c] = table_->byte(c, rgba[4 * i + c] * scale_);
      }
      rgba8[4 * i + 3] = 255;
    }
    return;
  }
  thread_local std::vector<float> rgb;  // pixels that differ from their predecessor
  rgb.clear();
  for (size_t i = 0; i < pixels; ++i) {
    if (i > 0 && same_colour(&rgba[4 * i], &rgba[4 * (i - 1)])) continue;
    for (size_t c = 0; c < 3; ++c) rgb.push_back(rgba[4 * i + c] * scale_);
  }
  transform_->apply(rgb.data(), rgb.size() / 3);
  size_t graded = 0;
  for (size_t i = 0; i < pixels; ++i) {
    uint8_t* out = &rgba8[4 * i];
    if (i > 0 && same_colour(&rgba[4 * i], &rgba[4 * (i - 1)])) {
      std::copy_n(out - 4, 4, out);
      continue;
    }
    for (size_t c = 0; c < 3; ++c) out[c] = to_byte(rgb[graded++]);
    out[3] = 255;
  }
}

void Grading::grade(std::span<const float> rgba, int width, std::span<uint8_t> rgba8) const {
  const size_t row = 4 * size_t(width), rows = rgba.size() / row;
  assert(rgba8.size() == rgba.size());
  parallel_ranges(rows, kRows, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      const float* values = &rgba[y * row];
      if (y > begin && std::memcmp(values, values - row, row * sizeof(float)) == 0) {
        std::copy_n(&rgba8[(y - 1) * row], row, &rgba8[y * row]);
      } else {
        grade_run({values, row}, {&rgba8[y * row], row});
      }
    }
  });
}

void Grading::to_display(std::span<float> rgba) const {
  parallel_ranges(rgba.size() / 4, kPixels, [&](size_t begin, size_t end) {
    thread_local std::vector<float> rgb;
    rgb.clear();
    for (size_t i = begin; i < end; ++i) {
      for (size_t c = 0; c < 3; ++c) rgb.push_back(rgba[4 * i + c] * scale_);
    }
    transform_->apply(rgb.data(), end - begin);
    for (size_t i = begin; i < end; ++i) std::copy_n(&rgb[3 * (i - begin)], 3, &rgba[4 * i]);
  });
}

}  // namespace emberline
