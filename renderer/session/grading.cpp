#include "renderer/session/grading.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <vector>

#include "io/image/output.h"
#include "renderer/core/errors.h"
#include "renderer/core/parallel.h"

namespace emberline {
namespace {

// Rows, or runs of pixels, that one task grades.
constexpr size_t kRows = 8;
constexpr size_t kPixels = 4096;

DisplaySettings at_exposure(DisplaySettings settings, float exposure) {
  if (!std::isfinite(exposure)) throw UsageError("`exposure`: not a finite number");
  settings.exposure = exposure;
  return settings;
}

bool same_colour(const float* a, const float* b) {
  return std::memcmp(a, b, 3 * sizeof(float)) == 0;
}

}  // namespace

Grading::Grading(const DisplaySettings& settings)
    : settings_(at_exposure(settings, settings.exposure)),
      transform_(std::make_shared<const DisplayTransform>(at_exposure(settings, 0.0f))),
      table_(DisplayTable::make(*transform_)),
      scale_(std::exp2(settings.exposure)) {}

Grading::Grading(const Grading& other, float exposure)
    : settings_(at_exposure(other.settings_, exposure)),
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
  thread_local std::vector<float> rgb;  // of the pixels that differ from the one before
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
