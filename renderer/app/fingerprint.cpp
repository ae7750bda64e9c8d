#include "renderer/app/fingerprint.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "io/gltf_document.h"
#include "io/gltf_uri.h"
#include "io/input_file.h"
#include "renderer/core/errors.h"
#include "renderer/core/hash.h"

namespace emberline {
namespace {

uint64_t of_file(const std::filesystem::path& path, uint64_t seed) {
  const std::vector<uint8_t> bytes = InputFile(path).read_all();
  return fingerprint(std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()),
                     seed);
}

}  // namespace

uint64_t fingerprint(std::string_view bytes, uint64_t seed) {
  uint64_t hash = hash_combine64(seed, bytes.size());
  for (size_t i = 0; i < bytes.size(); i += 8) {
    uint64_t word = 0;
    std::memcpy(&word, bytes.data() + i, std::min<size_t>(8, bytes.size() - i));
    hash = hash_combine64(hash, word);
  }
  return hash;
}

uint64_t fingerprint(std::span<const float> values, uint64_t seed) {
  return fingerprint(
      std::string_view(reinterpret_cast<const char*>(values.data()), values.size_bytes()), seed);
}

std::string hexadecimal(uint64_t value) { return fmt::format("{:016x}", value); }

uint64_t file_fingerprint(const std::string& path) { return of_file(path, 0); }

uint64_t scene_fingerprint(const std::string& path) {
  const GltfDocument document = open_gltf_document(path, LoadProgress::unwatched());
  uint64_t hash = of_file(path, 0);
  for (const char* list : {"buffers", "images"}) {
    for (const nlohmann::json& item : document.array(list)) {
      const nlohmann::json* uri = find_member(item, "uri");
      if (!uri || is_data_uri(uri->get_ref<const std::string&>())) continue;
      try {
        hash = of_file(resolve_uri(uri->get_ref<const std::string&>(), document.directory, path),
                       hash);
      } catch (const InputError&) {
        hash = hash_combine64(hash, 0);
      }
    }
  }
  return hash;
}

}  // namespace emberline
