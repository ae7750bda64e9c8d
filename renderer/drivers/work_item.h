// A schedule is data: drivers emit these, RenderWorker carries them out, tests list them.
#pragma once

#include <cstdint>

#include "renderer/core/rect.h"

namespace emberline {

// Samples [first_sample, first_sample + sample_count) of every pixel in `pixels`.
struct WorkItem {
  Rect pixels;
  uint32_t first_sample = 0;
  uint32_t sample_count = 0;

  uint64_t samples() const { return uint64_t(pixels.area()) * sample_count; }
  bool operator==(const WorkItem&) const = default;
};

// The same of one pixel, for schedules that leave pixels out or give each a count of its own.
struct PixelWork {
  int x = 0, y = 0;
  uint32_t first_sample = 0;
  uint32_t sample_count = 0;
  bool operator==(const PixelWork&) const = default;
};

}  // namespace emberline
