// The settings of working spaces. Does not include their matrices.
#pragma once

#include <cstdint>

namespace emberline {

// The primaries that a frame is rendered with. Scenes, maps and displays are linear Rec. 709.
enum class WorkingSpace : uint8_t { kRec709, kAcesCg };

}  // namespace emberline
