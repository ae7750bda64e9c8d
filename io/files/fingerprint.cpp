#include "io/files/fingerprint.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "io/files/input_file.h"
#include "io/gltf/document/document.h"
#include "renderer/core/errors.h"
#include "renderer/core/hash.h"

namespace emberline {
namespace {

// Hashes the bytes as 8-byte words; the last word is padded with zeros.
uint64_t hash_words(uint64_t hash, const void* bytes, size_t size) {
  const auto* next = static_cast<const uint8_t*>(bytes);
  for (size_t i = 0; i < size; i += 8) {
    uint64_t word = 0;
    std::memcpy(&word, next + i, std::min<size_t>(8, size - i));
    hash = hash_combine64(hash, word);
  }
  return hash;
}

// Returns the fingerprint() of the file's contents, which are read in parts.
uint64_t hash_file(const InputFile& file, uint64_t seed, const LoadProgress& progress) {
  constexpr uint64_t kPartBytes = uint64_t(1) << 20;  // a multiple of the word size
  std::vector<uint8_t> part(std::min(kPartBytes, file.size()));
  uint64_t hash = hash_combine64(seed, file.size());
  for (uint64_t at = 0; at < file.size(); at += kPartBytes) {
    const uint64_t size = std::min(kPartBytes, file.size() - at);
    progress.check();  // a sparse file can have any size
    file.read(at, size, part.data());
    hash = hash_words(hash, part.data(), size);
  }
  return hash;
}

}  // namespace

uint64_t fingerprint(std::string_view bytes, uint64_t seed) {
  return hash_words(hash_combine64(seed, bytes.size()), bytes.data(), bytes.size());
}

uint64_t fingerprint(std::span<const float> values, uint64_t seed) {
  return fingerprint(
      std::string_view(reinterpret_cast<const char*>(values.data()), values.size_bytes()), seed);
}

std::string hexadecimal(uint64_t value) { return fmt::format("{:016x}", value); }

uint64_t file_fingerprint(const std::string& path, const LoadProgress& progress) {
  return hash_file(InputFile(path), 0, progress);
}

uint64_t scene_fingerprint(const std::string& path, const std::string& resource_root,
                           LoadProgress& progress) {
  const GltfDocument document = open_gltf_document(path, resource_root, progress);
  uint64_t hash = file_fingerprint(path, progress);
  for (const std::string& uri : document.external_uris()) {
    try {
      hash = hash_file(document.open_resource(uri, path), hash, progress);
    } catch (const InputError&) {
      progress.check();
      hash = hash_combine64(hash, 0);
    }
  }
  return hash;
}

}  // namespace emberline
