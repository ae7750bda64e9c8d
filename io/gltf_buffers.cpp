// Buffers and buffer views of a GltfDocument: fetched, decompressed, bounded.

#include <exception>

#include "io/gltf_document.h"
#include "io/gltf_meshopt.h"
#include "io/gltf_uri.h"
#include "io/input_file.h"
#include "renderer/core/errors.h"
#include "renderer/core/parallel.h"

namespace emberline {
namespace {

using nlohmann::json;

const json* meshopt_extension(const json& object) {
  const json* extension = find_extension(object, "EXT_meshopt_compression");
  return extension ? extension : find_extension(object, "KHR_meshopt_compression");
}

ByteSpan load_buffer(GltfDocument& document, size_t i) {
  const json& buffer = document.json.at("buffers")[i];
  const std::string place = document.place("/buffers/" + std::to_string(i));
  const uint64_t byte_length = buffer.at("byteLength").get<uint64_t>();
  ByteSpan bytes;
  if (const json* uri_member = find_member(buffer, "uri")) {
    const std::string& uri = uri_member->get_ref<const std::string&>();
    const std::string uri_place = place + "/uri";
    if (is_data_uri(uri)) {
      document.storage.push_back(decode_data_uri(uri, uri_place));
    } else {
      document.storage.push_back(
          InputFile(resolve_uri(uri, document.directory, uri_place), uri_place)
              .read_all(*document.progress));
      document.total_bytes += document.storage.back().size();
    }
    bytes = document.storage.back();
  } else if (i == 0 && document.has_binary_chunk) {
    bytes = document.binary_chunk;
  } else {
    // The placeholder that decoders without meshopt would need; its views are all compressed.
    if (meshopt_extension(buffer)) return {};
    throw InputError(place, "the buffer has neither a uri nor a GLB binary chunk");
  }
  if (byte_length > bytes.size()) {
    throw InputError(place + "/byteLength", "the buffer should have " +
                                                std::to_string(byte_length) + " bytes, found " +
                                                std::to_string(bytes.size()));
  }
  return bytes.first(byte_length);
}

ByteSpan bounded(const std::vector<ByteSpan>& buffers, const json& reference,
                 const std::string& place) {
  const ByteSpan buffer = buffers[reference.at("buffer").get<size_t>()];
  const uint64_t offset = reference.value("byteOffset", uint64_t(0));
  const uint64_t length = reference.at("byteLength").get<uint64_t>();
  // Both are at most 2^53, so the sum cannot wrap.
  if (offset + length > buffer.size()) {
    throw InputError(place, "bytes " + std::to_string(offset) + " to " +
                                std::to_string(offset + length) + " are outside the buffer of " +
                                std::to_string(buffer.size()) + " bytes");
  }
  return buffer.subspan(offset, length);
}

}  // namespace

void load_gltf_buffers(GltfDocument& document) {
  const size_t buffer_count = document.array("buffers").size();
  std::vector<ByteSpan> buffers(buffer_count);
  for (size_t i = 0; i < buffer_count; ++i) buffers[i] = load_buffer(document, i);

  const json& views = document.array("bufferViews");
  const size_t first_decoded = document.storage.size();
  document.storage.resize(first_decoded + views.size());
  document.views.resize(views.size());
  std::vector<std::exception_ptr> errors(views.size());
  parallel_each(views.size(), [&](size_t i) {
    document.progress->check();
    const std::string place = document.place("/bufferViews/" + std::to_string(i));
    try {
      if (const json* compressed = meshopt_extension(views[i])) {
        const std::string inner = place + "/extensions/meshopt_compression";
        std::vector<uint8_t>& decoded = document.storage[first_decoded + i];
        decoded = decode_meshopt_view(*compressed, bounded(buffers, *compressed, inner),
                                      views[i].at("byteLength").get<uint64_t>(), inner);
        document.views[i] = decoded;
      } else {
        document.views[i] = bounded(buffers, views[i], place);
      }
    } catch (...) {
      errors[i] = std::current_exception();
    }
  });
  // The first in file order, so that the message does not depend on timing.
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
}

}  // namespace emberline
