// A glTF file after its first reading: JSON that is known to be well formed, and the bytes that
// its buffers hold. Everything behind this header may rely on what is promised here.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "renderer/core/load_progress.h"

namespace emberline {

using ByteSpan = std::span<const uint8_t>;

// An accessor whose reach has been checked: every element lies inside its buffer view, or is zero.
struct GltfAccessor {
  int view = -1;  // -1: zeros, or the data is in a compressed primitive
  uint64_t offset = 0, stride = 0, count = 0;
  int component_type = 0;  // 5120 BYTE .. 5126 FLOAT
  int component_size = 0;  // bytes
  int components = 0;      // 1 SCALAR .. 16 MAT4
  bool normalized = false;
  struct Sparse {
    uint64_t count = 0;  // 0: not sparse
    int index_view = -1, value_view = -1;
    uint64_t index_offset = 0, value_offset = 0;
    int index_type = 0;
  } sparse;
};

struct GltfDocument {
  LoadProgress* progress = &LoadProgress::unwatched();  // of whoever waits for the scene
  std::string file;                                     // as the user gave it
  std::filesystem::path directory;
  // Passed check_schema: what this loader reads has the right type, every index is in range, and
  // numbers that must be whole are stored as integers.
  nlohmann::json json;
  MemoryReservation json_memory;
  ByteSpan binary_chunk;  // of a .glb
  bool has_binary_chunk = false;
  std::vector<ByteSpan> views;  // one per bufferView, decompressed; valid while the document lives
  std::vector<GltfAccessor> accessors;
  std::vector<int> parents;     // per node, -1 for roots; acyclic
  std::vector<int> node_order;  // every node, parents before children
  uint64_t total_bytes = 0;     // of the file and its buffers: what counts are held against
  uint64_t most_zeros = 0;      // the longest accessor without data that is believed
  std::vector<std::vector<uint8_t>> storage;

  // "file#/json/pointer", for InputError.
  std::string place(const std::string& pointer) const { return file + "#" + pointer; }
  // The array `name`, or an empty one.
  const nlohmann::json& array(const char* name) const;
};

// Reads the file, checks its framing, its JSON and extensionsRequired. Throws InputError.
GltfDocument open_gltf_document(const std::string& path, LoadProgress& progress);

// Fetches the buffers, decompresses EXT_meshopt_compression views and fills `views`.
void load_gltf_buffers(GltfDocument& document);

// Fill `accessors`, `parents` and `node_order`, or throw InputError (gltf_checks.cpp); the others
// only look.
void check_gltf_accessors(GltfDocument& document);
void check_gltf_nodes(GltfDocument& document);
void check_gltf_skins(const GltfDocument& document);
void check_gltf_cameras_and_lights(const GltfDocument& document);

// Member `key` of an object, or null when it is absent.
const nlohmann::json* find_member(const nlohmann::json& object, const char* key);
// The extension object `name` inside `object`, or null.
const nlohmann::json* find_extension(const nlohmann::json& object, const char* name);

}  // namespace emberline
