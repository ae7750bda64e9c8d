// Fuzzes the buffer view of a Draco primitive. The last four bytes of the input describe the
// primitive: the numbers of components of its position, normal and first UV set, and the binary
// logarithm of the announced number of indices.
#include "io/gltf/geometry/draco.h"
#include "fuzz/fuzz.h"

using namespace emberline;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 4) return 0;
  const uint8_t* asked = data + size - 4;
  std::vector<DracoRequest> requests;
  for (uint32_t i = 0; i < 3; ++i) {
    if (asked[i] > 0) requests.push_back({std::to_string(i), i, asked[i] % 17, i % 2 == 1});
  }
  fuzz::allow_errors([&] {
    const LoadProgress progress({}, {}, fuzz::small_limits("view"));
    const DracoPrimitive primitive =
        decode_draco({data, size - 4}, requests, uint64_t(1) << (asked[3] % 40), "view", progress);
    for (const uint32_t i : primitive.indices) {
      fuzz::require_none(i < primitive.vertex_count ? "" : "an index");
    }
    for (const DracoRequest& request : requests) {
      const uint64_t full = primitive.vertex_count * uint64_t(request.components);
      fuzz::require_none(primitive.attributes.at(request.name).size() == full ? "" : "size");
    }
  });
  return 0;
}
