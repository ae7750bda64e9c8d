#include "io/gltf_document.h"

#include <cstring>

#include "io/gltf_extensions.h"
#include "io/gltf_schema.h"
#include "io/input_file.h"
#include "io/json_input.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

using nlohmann::json;

uint32_t read_u32(ByteSpan bytes, size_t offset) {
  return uint32_t(bytes[offset]) | uint32_t(bytes[offset + 1]) << 8 |
         uint32_t(bytes[offset + 2]) << 16 | uint32_t(bytes[offset + 3]) << 24;
}

constexpr uint32_t kGlbMagic = 0x46546C67;   // "glTF"
constexpr uint32_t kJsonChunk = 0x4E4F534A;  // "JSON"
constexpr uint32_t kBinChunk = 0x004E4942;   // "BIN\0"

// Specification section 4.4. Returns the JSON text and notes the binary chunk.
ByteSpan split_glb(ByteSpan bytes, GltfDocument& document) {
  const std::string& file = document.file;
  const auto sizes = [](uint64_t needed, uint64_t found) {
    return std::to_string(needed) + " bytes announced, " + std::to_string(found) + " found";
  };
  if (bytes.size() < 12) {
    throw InputError(file, "truncated GLB: the header takes 12 bytes, the file has " +
                               std::to_string(bytes.size()));
  }
  const uint32_t version = read_u32(bytes, 4);
  if (version != 2) {
    throw InputError(
        file, "GLB container version " + std::to_string(version) + " is not supported, only 2 is");
  }
  const uint64_t length = read_u32(bytes, 8);
  if (length > bytes.size()) {
    throw InputError(file, "truncated GLB: " + sizes(length, bytes.size()));
  }
  if (length < 20) {
    throw InputError(file, "the GLB announces " + std::to_string(length) +
                               " bytes, which leaves no room for a JSON chunk");
  }
  if (length < bytes.size()) {
    log_warning(file + ": " + std::to_string(bytes.size() - length) +
                " bytes behind the end of the GLB are ignored");
  }
  bytes = bytes.first(length);

  ByteSpan text;
  size_t offset = 12;
  for (int chunk = 0; offset < length; ++chunk) {
    if (length - offset < 8) throw InputError(file, "truncated GLB: incomplete chunk header");
    const uint64_t chunk_length = read_u32(bytes, offset);
    const uint32_t type = read_u32(bytes, offset + 4);
    offset += 8;
    if (chunk_length > length - offset) {
      throw InputError(file,
                       "GLB chunk " + std::to_string(chunk) +
                           " does not fit into the file: " + sizes(chunk_length, length - offset));
    }
    const ByteSpan content = bytes.subspan(offset, chunk_length);
    if (chunk == 0) {
      if (type != kJsonChunk) throw InputError(file, "the first GLB chunk is not JSON");
      text = content;
    } else if (type == kBinChunk && !document.has_binary_chunk) {
      document.binary_chunk = content;
      document.has_binary_chunk = true;
    }
    offset += chunk_length;
  }
  // Padding should be spaces; some writers use zeros.
  while (!text.empty() && text.back() == 0) text = text.first(text.size() - 1);
  return text;
}

void check_version(const GltfDocument& document) {
  const json& asset = document.json.at("asset");
  const auto major = [&](const char* key) {
    const std::string text = asset.at(key).get<std::string>();
    const size_t dot = text.find('.');
    const bool sane = dot != std::string::npos && dot > 0 && dot < 9 && dot + 1 < text.size() &&
                      text.find_first_not_of("0123456789.") == std::string::npos;
    if (!sane) {
      throw InputError(document.place(std::string("/asset/") + key),
                       "expected a version such as \"2.0\", found \"" + shortened(text) + "\"");
    }
    return text;
  };
  const std::string version = major("version");
  if (version.substr(0, 2) != "2.") {
    throw InputError(document.place("/asset/version"),
                     "glTF " + version + " is not supported, only 2.x is");
  }
  if (asset.contains("minVersion") && major("minVersion") != "2.0") {
    throw InputError(document.place("/asset/minVersion"),
                     "the file asks for glTF " + major("minVersion") + ", this reads 2.0");
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
  const nlohmann::json* found = find_member(json, name);
  return found ? *found : empty;
}

GltfDocument open_gltf_document(const std::string& path, LoadProgress& progress) {
  GltfDocument document;
  document.progress = &progress;
  document.file = path;
  document.directory = std::filesystem::path(path).parent_path();
  document.storage.push_back(InputFile(path).read_all(progress));
  const ByteSpan bytes = document.storage.back();
  document.total_bytes = bytes.size();
  if (bytes.empty()) throw InputError(path, "the file is empty");

  ByteSpan text = bytes;
  if (bytes.size() >= 4 && read_u32(bytes, 0) == kGlbMagic) {
    text = split_glb(bytes, document);
  } else {
    const auto is_space = [](uint8_t c) { return c == ' ' || (c >= '\t' && c <= '\r'); };
    size_t start = bytes.size() >= 3 && std::memcmp(bytes.data(), "\xEF\xBB\xBF", 3) == 0 ? 3 : 0;
    while (start < bytes.size() && is_space(bytes[start])) ++start;
    if (start == bytes.size() || bytes[start] != '{') {
      throw InputError(path, "not a glTF file (neither GLB nor a JSON object)");
    }
  }
  document.json =
      parse_json(std::string_view(reinterpret_cast<const char*>(text.data()), text.size()), path,
                 DuplicateMembers::kWarnedOf, progress, &document.json_memory);
  check_schema(document.json, path);
  check_version(document);
  check_required_extensions(document);
  if (!document.has_binary_chunk && text.data() == bytes.data()) {
    // Nothing of a .gltf is needed once it is parsed.
    document.storage.clear();
  }
  return document;
}

}  // namespace emberline
