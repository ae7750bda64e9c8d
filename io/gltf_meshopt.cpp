#include "io/gltf_meshopt.h"

#include <meshoptimizer.h>

#include "renderer/core/errors.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

// The least number of bytes that can hold `count` elements, from the extension's appendix A: a
// vertex stream spends 2 bits of header per 16 bytes of a byte plane; an index stream a byte per
// triangle, a sequence a byte per index.
uint64_t least_encoded_size(const std::string& mode, uint64_t count, uint64_t stride) {
  if (mode == "ATTRIBUTES") return 1 + count * stride / 64;
  if (mode == "TRIANGLES") return 1 + count / 3;
  return 1 + count;
}

}  // namespace

std::vector<uint8_t> decode_meshopt_view(const nlohmann::json& extension, ByteSpan encoded,
                                         uint64_t byte_length, const std::string& place,
                                         const LoadProgress& progress) {
  const uint64_t count = extension.at("count").get<uint64_t>();
  const uint64_t stride = extension.at("byteStride").get<uint64_t>();
  const std::string mode = extension.at("mode").get<std::string>();
  const std::string filter = extension.value("filter", "NONE");

  const bool attributes = mode == "ATTRIBUTES";
  const bool triangles = mode == "TRIANGLES";
  if (!attributes && !triangles && mode != "INDICES") {
    throw InputError(place + "/mode", "unknown meshopt mode \"{}\"", shortened(mode));
  }
  if (attributes ? stride % 4 != 0 || stride > 256 : stride != 2 && stride != 4) {
    throw InputError(place + "/byteStride", "a byteStride of {} is not allowed for {}", stride,
                     mode);
  }
  if (triangles && count % 3 != 0) {
    throw InputError(place + "/count", "TRIANGLES needs a multiple of three indices");
  }
  if (count > encoded.size() * 64 || least_encoded_size(mode, count, stride) > encoded.size()) {
    throw InputError(place + "/count", "{} elements cannot be in {} compressed bytes", count,
                     encoded.size());
  }
  if (count * stride != byte_length) {
    throw InputError(place, "count x byteStride is {}, but the buffer view has {} bytes",
                     count * stride, byte_length);
  }

  progress.budget()->reserve(MemoryPart::kFile, count * stride, place);
  std::vector<uint8_t> decoded(count * stride);
  int status = 0;
  if (attributes) {
    status =
        meshopt_decodeVertexBuffer(decoded.data(), count, stride, encoded.data(), encoded.size());
  } else if (triangles) {
    status =
        meshopt_decodeIndexBuffer(decoded.data(), count, stride, encoded.data(), encoded.size());
  } else {
    status =
        meshopt_decodeIndexSequence(decoded.data(), count, stride, encoded.data(), encoded.size());
  }
  if (status != 0) {
    throw InputError(place, "the meshopt data is corrupt or of a newer version (code {})", status);
  }

  if (filter == "NONE") return decoded;
  const bool octahedral = filter == "OCTAHEDRAL";
  const bool quaternion = filter == "QUATERNION";
  if (!octahedral && !quaternion && filter != "EXPONENTIAL") {
    throw InputError(place + "/filter", "unknown meshopt filter \"{}\"", shortened(filter));
  }
  if (!attributes || (octahedral && stride != 4 && stride != 8) || (quaternion && stride != 8)) {
    throw InputError(place + "/filter",
                     "the filter {} is not allowed for mode {} and a byteStride of {}", filter,
                     mode, stride);
  }
  if (octahedral) meshopt_decodeFilterOct(decoded.data(), count, stride);
  if (quaternion) meshopt_decodeFilterQuat(decoded.data(), count, stride);
  if (!octahedral && !quaternion) meshopt_decodeFilterExp(decoded.data(), count, stride);
  return decoded;
}

}  // namespace emberline
