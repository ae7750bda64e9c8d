// A glTF file after its first reading: JSON that is known to be well formed, and the bytes that
// its buffers hold. Everything behind this header may rely on what is promised here.
#pragma once

#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "io/files/input_file.h"
#include "io/gltf/document/buffers.h"
#include "io/gltf/document/faults.h"
#include "io/gltf/document/uri.h"
#include "io/json/value.h"
#include "renderer/core/file_identity.h"
#include "renderer/core/load_progress.h"

// tinygltf's name in this program; see tiny_gltf_renamed.h.
namespace emberline_tinygltf {
class Model;
}

namespace emberline {
namespace tinygltf = ::emberline_tinygltf;

// Bytes of a buffer, or decoded ones. Without either it is broken.
struct GltfView {
  int buffer = -1;
  uint64_t offset = 0, size = 0;
  std::vector<uint8_t> decoded;  // where there is no buffer
  bool broken = true;
};

// An accessor whose reach has been checked: every element lies inside its buffer view, or is zero.
struct GltfAccessor {
  int view = -1;  // -1: zeros, or the data is in a compressed primitive
  uint64_t offset = 0, stride = 0, count = 0;
  int component_type = 0;  // 5120 BYTE .. 5126 FLOAT
  int component_size = 0;  // bytes
  int components = 0;      // 1 SCALAR .. 16 MAT4; 0: it is broken
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
  ResourceFolder resources;
  // Passed check_schema: what this loader reads has the right type, every index is in range, and
  // numbers that must be whole are stored as integers. Objects that are broken are null.
  JsonValue json;
  std::unique_ptr<GltfFaults> faults;  // whoever needs an object that may be broken asks here
  MemoryReservation json_memory;
  struct BinaryChunk {
    uint64_t offset = 0, size = 0;
  };
  std::set<std::string, std::less<>> required_extensions;
  std::optional<BinaryChunk> binary_chunk;  // of a .glb: where it is in the file
  std::vector<std::unique_ptr<GltfBuffer>> buffers;
  std::vector<GltfView> views;  // one per bufferView, decompressed, inside its buffer
  std::vector<GltfAccessor> accessors;
  std::vector<int> parents;     // per node, -1 for roots; acyclic
  std::vector<int> node_order;  // parents before children, without those on or below a cycle
  std::shared_ptr<const tinygltf::Model> model;  // see parse_gltf_model
  MemoryReservation model_memory;
  uint64_t total_bytes = 0;  // of the file and its buffers: what counts are held against
  uint64_t most_zeros = 0;   // the longest accessor without data that is believed

  // "file#/json/pointer", for InputError.
  std::string place(const std::string& pointer) const { return file + "#" + pointer; }
  // The array `name`, or an empty one.
  const nlohmann::json& array(const char* name) const;
  bool requires_extension(std::string_view name) const {
    return required_extensions.contains(name);
  }
  // Takes memory of the load's budget. Throws LimitError that names the file, or `at`.
  void reserve(MemoryPart part, uint64_t bytes) const { reserve(part, bytes, file); }
  void reserve(MemoryPart part, uint64_t bytes, const std::string& at) const {
    progress->budget()->reserve(part, bytes, at);
  }
  // check(object, place, i) for each object of the array at `pointer`, if there is one, that is not
  // broken; one for which it throws InputError is so from now on.
  using Check = std::function<void(const nlohmann::json&, const std::string& place, size_t i)>;
  void check_each(const std::string& pointer, const Check& check);
  // Those of views and accessors. Throw InputError where it is broken.
  const GltfView& view(int i) const;
  const GltfAccessor& accessor(int i) const;
  // Bytes of a view, or all of it. They lie in it, and live as long as the document. Thread-safe.
  // Throws InputError, Cancelled.
  ByteSpan bytes(int view, uint64_t offset, uint64_t length) const;
  ByteSpan bytes(int view) const;
  // The same bytes, copied to `out`; a file's need no room besides.
  void copy_bytes(int view, uint64_t offset, uint64_t length, void* out) const;
  // A file that the scene refers to, which is noted in `files`. Thread-safe. Throws InputError.
  InputFile open_resource(const std::string& uri, const std::string& uri_place) const;
  // body(i) for each i below count, in parallel, each an item of the stage of `progress`: what each
  // threw, if anything. Throws only what `progress` does.
  std::vector<std::exception_ptr> try_each(size_t count,
                                           const std::function<void(size_t)>& body) const;
  // Every file that was opened so far, the scene first.
  std::vector<NamedFile> files() const;

 private:
  struct OpenedFiles {
    std::mutex mutex;
    std::vector<NamedFile> list;
  };
  std::unique_ptr<OpenedFiles> opened_ = std::make_unique<OpenedFiles>();
  friend GltfDocument open_gltf_document(const std::string& path, const std::string& resource_root,
                                         LoadProgress& progress);
};

// Reads the file, checks its framing, its JSON and extensionsRequired. `resource_root` as in
// GltfOptions. Throws InputError.
GltfDocument open_gltf_document(const std::string& path, const std::string& resource_root,
                                LoadProgress& progress);

// Opens the buffers, decompresses EXT_meshopt_compression views and fills `views`. Like the checks
// below, it notes what is broken.
void load_gltf_buffers(GltfDocument& document);

// Fill `accessors`, `parents` and `node_order` (gltf/document/checks.cpp); the others only look.
// The nodes of the scene are needed: it throws InputError for those that are no tree.
void check_gltf_accessors(GltfDocument& document);
void check_gltf_nodes(GltfDocument& document);
void check_gltf_skins(GltfDocument& document);
void check_gltf_cameras_and_lights(GltfDocument& document);

// Asset, scenes, nodes, materials, textures, samplers, cameras, skins and punctual lights of a
// checked document, with glTF's defaults filled in. tinygltf does not get to see the bytes: it
// reads what check_schema has passed, without extras, buffers, accessors, meshes and images,
// because version 2.7 follows indices and offsets of those without looking. Throws InputError.
void parse_gltf_model(GltfDocument& document);

// Member `key` of an object, or null when it is absent.
const nlohmann::json* find_member(const nlohmann::json& object, const char* key);
// The extension object `name` inside `object`, or null.
const nlohmann::json* find_extension(const nlohmann::json& object, const char* name);

}  // namespace emberline
