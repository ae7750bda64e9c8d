// Names of the working spaces; their matrices are in working_space.h.
#pragma once

#include <cstdint>

namespace emberline {

// The colour space used for rendering. Scenes, environment maps and displays use linear Rec. 709.
enum class WorkingSpace : uint8_t { kRec709, kAcesCg };

}  // namespace emberline
