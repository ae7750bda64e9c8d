#include "io/gltf/document/meshopt.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

#include "renderer/core/errors.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

// Returns the minimum number of bytes for `count` elements, from the extension's appendix A. The
// minimum is 2 header bits per 16 bytes of a byte plane for attributes, one byte per triangle for
// triangle indices, and one byte per index for an index sequence.
uint64_t min_encoded_size(const std::string& mode, ByteSpan encoded, uint64_t count,
                          uint64_t stride) {
  if (mode == "TRIANGLES") return 1 + count / 3;
  if (mode != "ATTRIBUTES") return 1 + count;
  return is_meshopt_v1(encoded) ? min_meshopt_v1_size(count, stride) : 1 + count * stride / 64;
}

// The extension's members, which check_schema has validated.
struct Description {
  uint64_t count, stride;
  std::string mode, filter;

  bool attributes() const { return mode == "ATTRIBUTES"; }
};

void check_description(const Description& d, ByteSpan encoded, uint64_t byte_length,
                       const std::string& place) {
  const bool triangles = d.mode == "TRIANGLES";
  if (!d.attributes() && !triangles && d.mode != "INDICES") {
    throw InputError(place + "/mode", "unknown meshopt mode \"{}\"", shortened(d.mode));
  }
  if (d.attributes() ? d.stride % 4 != 0 || d.stride > 256 : d.stride != 2 && d.stride != 4) {
    throw InputError(place + "/byteStride", "a byteStride of {} is not allowed for {}", d.stride,
                     d.mode);
  }
  if (triangles && d.count % 3 != 0) {
    throw InputError(place + "/count", "TRIANGLES needs a multiple of three indices");
  }
  if (min_encoded_size(d.mode, encoded, d.count, d.stride) > encoded.size()) {
    throw InputError(place + "/count", "{} elements do not fit into {} compressed bytes", d.count,
                     encoded.size());
  }
  if (d.count * d.stride != byte_length) {
    throw InputError(place, "count x byteStride is {}, but the buffer view has {} bytes",
                     d.count * d.stride, byte_length);
  }
}

void check_filter(const Description& d, const std::string& place) {
  struct Filter {
    std::string_view name;
    bool any_stride, stride_4;  // which strides are valid besides 8
  };
  constexpr Filter kFilters[] = {{"NONE", true, true},
                                 {"OCTAHEDRAL", false, true},
                                 {"QUATERNION", false, false},
                                 {"EXPONENTIAL", true, true},
                                 {"COLOR", false, true}};
  const auto* filter = std::ranges::find(kFilters, d.filter, &Filter::name);
  if (filter == std::end(kFilters)) {
    throw InputError(place + "/filter", "unknown meshopt filter \"{}\"", shortened(d.filter));
  }
  if (d.filter == "NONE") return;
  const bool fits = filter->any_stride || d.stride == 8 || (filter->stride_4 && d.stride == 4);
  if (!d.attributes() || !fits) {
    throw InputError(place + "/filter",
                     "the filter {} is not allowed for mode {} and a byteStride of {}", d.filter,
                     d.mode, d.stride);
  }
}

// Returns the decoder's status, which is 0 for success.
int decode(const Description& d, ByteSpan encoded, uint8_t* decoded) {
  if (d.attributes() && is_meshopt_v1(encoded)) {
    return decode_meshopt_v1(encoded, d.count, d.stride, decoded) ? 0 : -1;
  }
  const uint8_t* bytes = encoded.data();
  if (d.attributes()) {
    return meshopt_decodeVertexBuffer(decoded, d.count, d.stride, bytes, encoded.size());
  }
  if (d.mode == "TRIANGLES") {
    return meshopt_decodeIndexBuffer(decoded, d.count, d.stride, bytes, encoded.size());
  }
  return meshopt_decodeIndexSequence(decoded, d.count, d.stride, bytes, encoded.size());
}

}  // namespace

std::vector<uint8_t> decode_meshopt_view(const nlohmann::json& extension, ByteSpan encoded,
                                         uint64_t byte_length, const std::string& place,
                                         const LoadProgress& progress) {
  const Description d = {
      extension.at("count").get<uint64_t>(), extension.at("byteStride").get<uint64_t>(),
      extension.at("mode").get<std::string>(), extension.value("filter", "NONE")};
  check_description(d, encoded, byte_length, place);
  check_filter(d, place);
  progress.budget()->reserve(MemoryPart::kFile, byte_length, place);
  std::vector<uint8_t> decoded(byte_length);
  if (const int status = decode(d, encoded, decoded.data()); status != 0) {
    throw InputError(place, "the meshopt data is corrupt or of a newer version (code {})", status);
  }
  if (d.filter == "OCTAHEDRAL") meshopt_decodeFilterOct(decoded.data(), d.count, d.stride);
  if (d.filter == "QUATERNION") meshopt_decodeFilterQuat(decoded.data(), d.count, d.stride);
  if (d.filter == "EXPONENTIAL") meshopt_decodeFilterExp(decoded.data(), d.count, d.stride);
  if (d.filter == "COLOR") decode_meshopt_color(decoded.data(), d.count, d.stride);
  return decoded;
}

}  // namespace emberline
