// The standard OpenEXR attributes for an image's camera, time and primaries.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <utility>

#include "io/display/choices.h"

namespace emberline {

// The matrices are the attributes worldToCamera and worldToNDC. They are for row vectors.
struct ExrView {
  struct Matrices {
    std::array<float, 16> world_to_camera, world_to_ndc;
  };
  std::optional<Matrices> camera;
  std::optional<std::pair<int32_t, uint32_t>> frames_per_second;  // as a fraction
  std::optional<uint32_t> time_code;                              // see smpte_time_code()
  WorkingSpace space = WorkingSpace::kRec709;
};

}  // namespace emberline
