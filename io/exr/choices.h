// Settings of EXR files; writer.h has the writer itself.
#pragma once

#include <cstdint>

namespace emberline {

enum class ExrCompression : uint8_t { kNone, kZips, kZip, kPiz, kDwaa, kDwab };

enum class ExrParts : uint8_t { kOne, kLayers };

}  // namespace emberline
