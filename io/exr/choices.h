// Settings of EXR files; the writer itself is in writer.h.
#pragma once

#include <cstdint>

namespace emberline {

enum class ExrCompression : uint8_t { kNone, kZips, kZip, kPiz, kDwaa, kDwab };

enum class ExrParts : uint8_t { kOne, kLayers };

}  // namespace emberline
