#include "io/gltf/document/buffers.h"

#include <algorithm>
#include <exception>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "io/gltf/document/document.h"
#include "io/gltf/document/meshopt.h"
#include "io/gltf/document/uri.h"
#include "renderer/core/errors.h"
#include "renderer/core/parallel.h"

namespace emberline {
namespace {

using nlohmann::json;

constexpr const char* kMeshopt[] = {"EXT_meshopt_compression", "KHR_meshopt_compression"};

// Returns the name of the meshopt extension that the view has, or the second name if it has neither
// extension.
const char* meshopt_name(const json& view) {
  return find_extension(view, kMeshopt[0]) ? kMeshopt[0] : kMeshopt[1];
}

// Returns null for a buffer with neither a uri nor a GLB binary chunk. Such a buffer is a
// placeholder for views that meshopt compresses. It need not be marked as a fallback. If any other
// view uses it, checked_range() reports this.
std::unique_ptr<GltfBuffer> open_buffer(GltfDocument& document, const json& buffer,
                                        const std::string& place, size_t i) {
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
    return nullptr;
  }
  if (byte_length > result->size()) {
    throw InputError(place + "/byteLength", "the buffer should have {} bytes, found {}",
                     byte_length, result->size());
  }
  result->shrink(byte_length);
  return result;
}

// Returns the range of a buffer to which `reference` refers. `reference` is a bufferView or its
// meshopt extension.
GltfView checked_range(const GltfDocument& document, const json& reference,
                       const std::string& place) {
  GltfView view;
  view.buffer = reference.at("buffer").get<int>();
  view.offset = reference.value("byteOffset", uint64_t(0));
  view.size = reference.at("byteLength").get<uint64_t>();
  const std::string pointer = "/buffers/" + std::to_string(view.buffer);
  document.faults->require(pointer);
  if (!document.buffers[size_t(view.buffer)]) {
    throw InputError(document.place(pointer),
                     "the buffer has neither a uri nor a GLB binary chunk");
  }
  const uint64_t size = document.buffers[size_t(view.buffer)]->size();
  // The offset and the size are at most 2^53, so their sum cannot overflow.
  if (view.offset + view.size > size) {
    throw InputError(place, "bytes {} to {} are outside the buffer of {} bytes", view.offset,
                     view.offset + view.size, size);
  }
  view.broken = false;
  return view;
}

GltfView decompress_view(const GltfDocument& document, const json& object, const json& compressed,
                         const std::string& place) {
  const GltfView source = checked_range(document, compressed, place);
  const ByteSpan encoded = document.buffers[size_t(source.buffer)]->bytes(
      source.offset, source.offset + source.size, *document.progress);
  GltfView view;
  view.size = object.at("byteLength").get<uint64_t>();
  view.decoded = decode_meshopt_view(compressed, encoded, view.size, place, *document.progress);
  view.broken = false;
  return view;
}

// Reads the view at `pointer`. If compressed data cannot be decoded and the extension is optional,
// uses the fallback buffer's bytes and sets `fault`.
GltfView read_view(const GltfDocument& document, const json& object, const std::string& pointer,
                   std::optional<InputError>& fault) {
  const char* name = meshopt_name(object);
  if (const json* compressed = find_extension(object, name)) {
    try {
      return decompress_view(document, object, *compressed,
                             document.place(pointer + "/extensions/" + name));
    } catch (const InputError& error) {
      GltfFaults::rethrow_limit_error(error);
      if (document.requires_extension(name)) throw;
      fault = error;
    }
  }
  try {
    return checked_range(document, object, document.place(pointer));
  } catch (const InputError& error) {
    GltfFaults::rethrow_limit_error(error);
    if (fault) throw InputError(*fault);
    // If check_schema() removed the extension, reports the fault of the extension instead.
    for (const char* extension : kMeshopt) {
      document.faults->require(pointer + "/extensions/" + extension);
    }
    throw;
  }
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
  // Merges all loaded ranges that touch this one, and reads the gaps between them.
  auto next = loaded_ranges_.upper_bound(begin);
  if (next != loaded_ranges_.begin() && std::prev(next)->second >= begin) --next;
  uint64_t first = begin, at = begin;
  const auto read_to = [&](uint64_t stop) {
    if (stop <= at) return;
    reserved_.add(stop - at, file_->place());
    file_->read(offset_ + at, stop - at, memory_.begin() + at, progress);
  };
  while (next != loaded_ranges_.end() && next->first <= end) {
    first = std::min(first, next->first);
    read_to(next->first);
    at = std::max(at, next->second);
    next = loaded_ranges_.erase(next);
  }
  read_to(end);
  loaded_ranges_[first] = std::max(at, end);
  return ByteSpan(memory_.begin() + begin, end - begin);
}

bool GltfBuffer::is_loaded(uint64_t begin, uint64_t end) {
  const std::lock_guard lock(mutex_);
  const auto next = loaded_ranges_.upper_bound(begin);
  return next != loaded_ranges_.begin() && std::prev(next)->second >= end;
}

void GltfBuffer::copy(uint64_t begin, uint64_t end, void* out, const LoadProgress& progress) {
  auto* const to = static_cast<uint8_t*>(out);
  if (!file_ || is_loaded(begin, end)) {
    std::ranges::copy(bytes(begin, end, progress), to);
    return;
  }
  // A part is so large that reading it, with the page faults in `out`, takes longer than scheduling
  // it.
  constexpr uint64_t kGrain = uint64_t(1) << 20;
  parallel_ranges(end - begin, kGrain, [&](size_t first, size_t last) {
    file_->read(offset_ + begin + first, last - first, to + first, progress);
  });
}

void GltfBuffer::forget() {
  const std::lock_guard lock(mutex_);
  memory_ = {};
  loaded_ranges_.clear();
  reserved_.release();
}

void load_gltf_buffers(GltfDocument& document) {
  document.buffers.resize(document.array("buffers").size());
  document.check_each("/buffers", [&](const json& buffer, const std::string& place, size_t i) {
    document.buffers[i] = open_buffer(document, buffer, place, i);
  });

  const json& views = document.array("bufferViews");
  document.views.resize(views.size());
  const auto pointer = [](size_t i) { return "/bufferViews/" + std::to_string(i); };
  std::vector<std::optional<InputError>> extension_faults(views.size());
  const std::vector<std::exception_ptr> errors = document.try_each(views.size(), [&](size_t i) {
    if (views[i].is_null()) return;
    document.views[i] = read_view(document, views[i], pointer(i), extension_faults[i]);
  });
  // Faults are noted in file order, so that the messages do not depend on timing.
  for (size_t i = 0; i < views.size(); ++i) {
    try {
      if (errors[i]) std::rethrow_exception(errors[i]);
      if (extension_faults[i]) {
        document.faults->note_defaulted(pointer(i) + "/extensions/" + meshopt_name(views[i]),
                                        *extension_faults[i]);
      }
    } catch (const InputError& error) {
      document.faults->note_broken(pointer(i), error);
    }
  }
}

ByteSpan GltfDocument::bytes(int view, uint64_t offset, uint64_t length) const {
  const GltfView& v = this->view(view);
  if (v.buffer < 0) return ByteSpan(v.decoded).subspan(offset, length);
  return buffers[size_t(v.buffer)]->bytes(v.offset + offset, v.offset + offset + length, *progress);
}

void GltfDocument::copy_bytes(int view, uint64_t offset, uint64_t length, void* out) const {
  const GltfView& v = this->view(view);
  if (length == 0) return;
  if (v.buffer < 0) {
    std::ranges::copy(ByteSpan(v.decoded).subspan(offset, length), static_cast<uint8_t*>(out));
    return;
  }
  const uint64_t begin = v.offset + offset;
  buffers[size_t(v.buffer)]->copy(begin, begin + length, out, *progress);
}

ByteSpan GltfDocument::bytes(int view) const { return bytes(view, 0, this->view(view).size); }

}  // namespace emberline
