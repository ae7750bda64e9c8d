// Names the working spaces; working_space.h has their matrices.
#pragma once

#include <cstdint>

namespace emberline {

// The primaries used for rendering. Scenes, environment maps and displays use linear Rec. 709.
enum class WorkingSpace : uint8_t { kRec709, kAcesCg };

}  // namespace emberline
