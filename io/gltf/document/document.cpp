#include "io/gltf/document/document.h"

#include <array>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "io/files/byte_order.h"
#include "io/files/input_file.h"
#include "io/gltf/document/extensions.h"
#include "io/gltf/document/schema.h"
#include "io/json/input.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/parallel.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

using nlohmann::json;

constexpr uint32_t kGlbMagic = 0x46546C67;   // "glTF"
constexpr uint32_t kJsonChunk = 0x4E4F534A;  // "JSON"
constexpr uint32_t kBinChunk = 0x004E4942;   // "BIN\0"

// Reads a GLB (section 4.4). Returns the JSON text and records where the binary chunk is.
std::vector<uint8_t> read_glb(const InputFile& input, GltfDocument& document,
                              MemoryReservation& text_memory) {
  // The specification defines two chunks, and extensions may add more. The limit stops files that
  // consist of countless empty chunks.
  constexpr int kMaxChunks = 1000;
  const std::string& file = document.file;
  const auto describe_sizes = [](uint64_t needed, uint64_t found) {
    return std::to_string(needed) + " bytes declared, " + std::to_string(found) + " found";
  };
  if (input.size() < 12) {
    throw InputError(file, "truncated GLB: the header needs 12 bytes, but the file has {}",
                     input.size());
  }
  std::array<uint8_t, 12> header;
  input.read(0, header.size(), header.data());
  const uint32_t version = little_endian(header, 4, 4);
  if (version != 2) {
    throw InputError(file, "GLB container version {} is not supported, only version 2 is", version);
  }
  const uint64_t length = little_endian(header, 8, 4);
  if (length > input.size()) {
    throw InputError(file, "truncated GLB: " + describe_sizes(length, input.size()));
  }
  if (length < 20) {
    throw InputError(file,
                     "the GLB declares a length of {} bytes, which leaves no room for a JSON chunk",
                     length);
  }
  if (length < input.size()) {
    log_warning(file + ": " + std::to_string(input.size() - length) +
                " bytes after the end of the GLB are ignored");
  }

  std::vector<uint8_t> text;
  uint64_t offset = 12;
  for (int chunk = 0; offset < length; ++chunk) {
    if (length - offset < 8) throw InputError(file, "truncated GLB: incomplete chunk header");
    if (chunk == kMaxChunks) {
      throw InputError(file, "the GLB has more than {} chunks", kMaxChunks);
    }
    input.read(offset, 8, header.data());
    const uint64_t chunk_length = little_endian(header, 0, 4);
    const uint32_t type = little_endian(header, 4, 4);
    offset += 8;
    if (chunk_length > length - offset) {
      throw InputError(file, "GLB chunk {} does not fit into the file: {}", chunk,
                       describe_sizes(chunk_length, length - offset));
    }
    if (chunk == 0) {
      if (type != kJsonChunk) throw InputError(file, "the first GLB chunk is not JSON");
      text_memory.add(chunk_length, file);
      text.resize(chunk_length);
      input.read(offset, chunk_length, text.data(), *document.progress);
    } else if (type == kBinChunk && !document.binary_chunk) {
      document.binary_chunk = {offset, chunk_length};
    }
    offset += chunk_length;
  }
  // The padding should be spaces, but some writers use zeros.
  while (!text.empty() && text.back() == 0) text.pop_back();
  return text;
}

void check_version(const GltfDocument& document) {
  const json& asset = document.json->at("asset");
  const auto major = [&](const char* key) {
    const std::string text = asset.at(key).get<std::string>();
    const size_t dot = text.find('.');
    const bool is_well_formed = dot != std::string::npos && dot > 0 && dot < 9 &&
                                dot + 1 < text.size() &&
                                text.find_first_not_of("0123456789.") == std::string::npos;
    if (!is_well_formed) {
      throw InputError(document.place(std::string("/asset/") + key),
                       "expected a version such as \"2.0\", found \"{}\"", shortened(text));
    }
    return text;
  };
  const std::string version = major("version");
  if (version.substr(0, 2) != "2.") {
    throw InputError(document.place("/asset/version"), "glTF {} is not supported, only 2.x is",
                     version);
  }
  if (asset.contains("minVersion") && major("minVersion") != "2.0") {
    throw InputError(document.place("/asset/minVersion"),
                     "the file requires glTF {}, but this version reads 2.0", major("minVersion"));
  }
}

}  // namespace

const json* find_member(const json& object, const char* key) {
  if (!object.is_object()) return nullptr;
  const auto found = object.find(key);
  return found == object.end() ? nullptr : &*found;
}

const json* find_extension(const json& object, const char* name) {
  const json* extensions = find_member(object, "extensions");
  return extensions ? find_member(*extensions, name) : nullptr;
}

const nlohmann::json& GltfDocument::array(const char* name) const {
  static const nlohmann::json empty = nlohmann::json::array();
  const nlohmann::json* found = find_member(*json, name);
  return found ? *found : empty;
}

void GltfDocument::check_each(const std::string& pointer, const Check& check) {
  const nlohmann::json::json_pointer array(pointer);
  if (!json->contains(array)) return;
  nlohmann::json& objects = json->at(array);
  for (size_t i = 0; i < objects.size(); ++i) {
    if (objects[i].is_null()) continue;
    const std::string its_pointer = pointer + "/" + std::to_string(i);
    try {
      check(objects[i], place(its_pointer), i);
    } catch (const InputError& error) {
      faults->note_broken(its_pointer, error);
      objects[i] = nullptr;
    }
  }
}

const GltfView& GltfDocument::view(int i) const {
  const GltfView& found = views[size_t(i)];
  if (found.broken) faults->require("/bufferViews/" + std::to_string(i));
  return found;
}

const GltfAccessor& GltfDocument::accessor(int i) const {
  const GltfAccessor& found = accessors[size_t(i)];
  if (found.components == 0) faults->require("/accessors/" + std::to_string(i));
  return found;
}

GltfDocument open_gltf_document(const std::string& path, const std::string& resource_root,
                                LoadProgress& progress) {
  GltfDocument document;
  document.progress = &progress;
  document.faults = std::make_unique<GltfFaults>(progress.budget());
  document.file = path;
  const std::filesystem::path directory = std::filesystem::path(path).parent_path();
  document.resources.directory = directory.empty() ? "." : directory;
  document.resources.root =
      resource_root.empty() ? document.resources.directory : std::filesystem::path(resource_root);
  const InputFile input(path);
  document.opened_->list.push_back(input.named_file(path));
  document.total_bytes = input.size();
  if (input.size() == 0) throw InputError(path, "the file is empty");

  MemoryReservation text_memory(progress.budget(), MemoryPart::kFile);
  std::vector<uint8_t> text;
  std::array<uint8_t, 4> magic = {};
  input.try_read(0, magic.size(), magic.data());
  if (little_endian(magic, 0, 4) == kGlbMagic) {
    text = read_glb(input, document, text_memory);
  } else {
    text_memory.add(input.size(), path);
    text = input.read_all(progress);
    const auto is_space = [](uint8_t c) { return c == ' ' || (c >= '\t' && c <= '\r'); };
    size_t start = text.size() >= 3 && std::memcmp(text.data(), "\xEF\xBB\xBF", 3) == 0 ? 3 : 0;
    while (start < text.size() && is_space(text[start])) ++start;
    if (start == text.size() || text[start] != '{') {
      throw InputError(path, "not a glTF file (neither GLB nor a JSON object)");
    }
  }
  *document.json =
      parse_json(std::string_view(reinterpret_cast<const char*>(text.data()), text.size()), path,
                 DuplicateMembers::kWarn, progress, &document.json_memory);
  check_schema(*document.json, path, *document.faults);
  for (const json& name : document.array("extensionsRequired")) {
    document.required_extensions.insert(name.get<std::string>());
  }
  check_version(document);
  check_required_extensions(document);
  return document;
}

InputFile GltfDocument::open_resource(const std::string& uri, const std::string& uri_place) const {
  InputFile resource(resolve_uri(uri, resources, uri_place).file, uri_place);
  const std::lock_guard lock(opened_->mutex);
  opened_->list.push_back(resource.named_file(uri));
  return resource;
}

std::vector<std::string> GltfDocument::external_uris() const {
  std::vector<std::string> uris;
  for (const char* list : {"buffers", "images"}) {
    for (const nlohmann::json& item : array(list)) {
      const nlohmann::json* uri = find_member(item, "uri");
      if (uri && !is_data_uri(uri->get_ref<const std::string&>()))
        uris.push_back(uri->get<std::string>());
    }
  }
  return uris;
}

std::vector<std::exception_ptr> GltfDocument::try_each(
    size_t count, const std::function<void(size_t)>& body) const {
  std::vector<std::exception_ptr> errors(count);
  parallel_each(count, [&](size_t i) {
    progress->check();
    try {
      body(i);
    } catch (...) {
      errors[i] = std::current_exception();
    }
    progress->advance();
  });
  return errors;
}

std::vector<NamedFile> GltfDocument::files() const {
  const std::lock_guard lock(opened_->mutex);
  return opened_->list;
}

}  // namespace emberline
