#include "io/gltf_buffers.h"

#include <algorithm>
#include <exception>
#include <iterator>
#include <memory>

#include "io/gltf_document.h"
#include "io/gltf_meshopt.h"
#include "io/gltf_uri.h"
#include "renderer/core/errors.h"

namespace emberline {
namespace {

using nlohmann::json;

const json* meshopt_extension(const json& object) {
  const json* extension = find_extension(object, "EXT_meshopt_compression");
  return extension ? extension : find_extension(object, "KHR_meshopt_compression");
}

std::unique_ptr<GltfBuffer> open_buffer(GltfDocument& document, size_t i) {
  const json& buffer = document.json.at("buffers")[i];
  const std::string place = document.place("/buffers/" + std::to_string(i));
  const uint64_t byte_length = buffer.at("byteLength").get<uint64_t>();
  std::unique_ptr<GltfBuffer> result;
  if (const json* uri_member = find_member(buffer, "uri")) {
    const std::string& uri = uri_member->get_ref<const std::string&>();
    const std::string uri_place = place + "/uri";
    if (is_data_uri(uri)) {
      result = std::make_unique<GltfBuffer>(decode_data_uri(uri, uri_place));
    } else {
      InputFile file = document.open_resource(uri, uri_place);
      const uint64_t size = file.size();
      result = std::make_unique<GltfBuffer>(std::move(file), 0, size);
      document.total_bytes += std::min(size, byte_length);
    }
  } else if (i == 0 && document.binary_chunk) {
    const GltfDocument::BinaryChunk& chunk = *document.binary_chunk;
    result = std::make_unique<GltfBuffer>(InputFile(document.file), chunk.offset, chunk.size);
  } else {
    // The placeholder that decoders without meshopt would need; its views are all compressed.
    if (meshopt_extension(buffer)) return std::make_unique<GltfBuffer>();
    throw InputError(place, "the buffer has neither a uri nor a GLB binary chunk");
  }
  if (byte_length > result->size()) {
    throw InputError(place + "/byteLength", "the buffer should have {} bytes, found {}",
                     byte_length, result->size());
  }
  result->shrink(byte_length);
  return result;
}

// The part of a buffer that a view, or its compressed form, names.
GltfView bounded(const GltfDocument& document, const json& reference, const std::string& place) {
  GltfView view;
  view.buffer = reference.at("buffer").get<int>();
  view.offset = reference.value("byteOffset", uint64_t(0));
  view.size = reference.at("byteLength").get<uint64_t>();
  const uint64_t size = document.buffers[size_t(view.buffer)]->size();
  // Both are at most 2^53, so the sum cannot wrap.
  if (view.offset + view.size > size) {
    throw InputError(place, "bytes {} to {} are outside the buffer of {} bytes", view.offset,
                     view.offset + view.size, size);
  }
  return view;
}

}  // namespace

ByteSpan GltfBuffer::bytes(uint64_t begin, uint64_t end, const LoadProgress& progress) {
  if (!file_) return ByteSpan(bytes_).subspan(begin, end - begin);
  if (begin == end) return {};
  const std::lock_guard lock(mutex_);
  if (memory_.empty()) {
    memory_.reset(size_);
    reserved_ = MemoryReservation(progress.budget(), MemoryPart::kFile);
  }
  // The ranges that meet this one become one with it; what is between them is read.
  auto next = present_.upper_bound(begin);
  if (next != present_.begin() && std::prev(next)->second >= begin) --next;
  uint64_t first = begin, at = begin;
  const auto read_to = [&](uint64_t stop) {
    if (stop <= at) return;
    reserved_.add(stop - at, file_->place());
    file_->read(offset_ + at, stop - at, memory_.begin() + at, progress);
  };
  while (next != present_.end() && next->first <= end) {
    first = std::min(first, next->first);
    read_to(next->first);
    at = std::max(at, next->second);
    next = present_.erase(next);
  }
  read_to(end);
  present_[first] = std::max(at, end);
  return ByteSpan(memory_.begin() + begin, end - begin);
}

void load_gltf_buffers(GltfDocument& document) {
  const size_t buffer_count = document.array("buffers").size();
  for (size_t i = 0; i < buffer_count; ++i) {
    document.buffers.push_back(open_buffer(document, i));
  }

  const json& views = document.array("bufferViews");
  document.views.resize(views.size());
  const auto read_view = [&](size_t i) {
    const std::string place = document.place("/bufferViews/" + std::to_string(i));
    const json* compressed = meshopt_extension(views[i]);
    if (!compressed) {
      document.views[i] = bounded(document, views[i], place);
      return;
    }
    const std::string inner = place + "/extensions/meshopt_compression";
    const GltfView source = bounded(document, *compressed, inner);
    const ByteSpan encoded = document.buffers[size_t(source.buffer)]->bytes(
        source.offset, source.offset + source.size, *document.progress);
    GltfView& view = document.views[i];
    view.size = views[i].at("byteLength").get<uint64_t>();
    view.decoded = decode_meshopt_view(*compressed, encoded, view.size, inner, *document.progress);
  };
  // The first in file order, so that the message does not depend on timing.
  for (const std::exception_ptr& error : document.try_each(views.size(), read_view)) {
    if (error) std::rethrow_exception(error);
  }
}

ByteSpan GltfDocument::bytes(int view, uint64_t offset, uint64_t length) const {
  const GltfView& v = views[size_t(view)];
  if (v.buffer < 0) return ByteSpan(v.decoded).subspan(offset, length);
  return buffers[size_t(v.buffer)]->bytes(v.offset + offset, v.offset + offset + length, *progress);
}

ByteSpan GltfDocument::bytes(int view) const { return bytes(view, 0, views[size_t(view)].size); }

}  // namespace emberline
