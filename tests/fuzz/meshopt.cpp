// Fuzzes a compressed buffer view. The last eight bytes of the input describe the view: mode,
// filter, stride - 1, an unused byte, and the count (little-endian).
#include "io/gltf/document/meshopt.h"

#include <nlohmann/json.hpp>
#include "fuzz/fuzz.h"

using namespace emberline;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 8) return 0;
  const uint8_t* header_bytes = data + size - 8;
  static constexpr const char* kModes[] = {"ATTRIBUTES", "TRIANGLES", "INDICES", "other"};
  static constexpr const char* kFilters[] = {"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL",
                                             "COLOR"};
  const uint64_t stride = header_bytes[2] + uint64_t(1);
  const uint64_t count =
      header_bytes[4] | uint64_t(header_bytes[5]) << 8 | uint64_t(header_bytes[6]) << 16;
  const nlohmann::json extension = {{"mode", kModes[header_bytes[0] % 4]},
                                    {"filter", kFilters[header_bytes[1] % 5]},
                                    {"byteStride", stride},
                                    {"count", count}};
  fuzz::allow_errors([&] {
    const auto decoded = decode_meshopt_view(extension, {data, size - 8}, count * stride, "view");
    fuzz::require_none(decoded.size() == count * stride ? "" : "size");
  });
  return 0;
}
