// Where, when and with which primaries an OpenEXR file's picture was made.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <utility>

#include "io/display/choices.h"

namespace emberline {

// Of OpenEXR's standard attributes those that say where, when and with which primaries: the
// matrices are worldToCamera and worldToNDC, of row vectors.
struct ExrView {
  struct Matrices {
    std::array<float, 16> world_to_camera, world_to_ndc;
  };
  std::optional<Matrices> camera;
  std::optional<std::pair<int32_t, uint32_t>> frames_per_second;  // a fraction
  std::optional<uint32_t> time_code;                              // see smpte_time_code()
  WorkingSpace space = WorkingSpace::kRec709;
};

}  // namespace emberline
