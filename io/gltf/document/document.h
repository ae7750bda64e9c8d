// A glTF file after validation: its JSON is valid, and its buffers can be read. All users of this
// header may rely on the invariants stated here.
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

// tinygltf's namespace in this program; see tiny_gltf_renamed.h.
namespace emberline_tinygltf {
class Model;
}

namespace emberline {
namespace tinygltf = ::emberline_tinygltf;

// A buffer view: a range of a buffer, or decoded bytes. A view with neither is broken.
struct GltfView {
  int buffer = -1;
  uint64_t offset = 0, size = 0;
  std::vector<uint8_t> decoded;  // used if there is no buffer
  bool broken = true;
};

// A range-checked accessor: every element lies inside its buffer view or is zero.
struct GltfAccessor {
  int view = -1;  // -1: the elements are zeros, or are in a Draco stream
  uint64_t offset = 0, stride = 0, count = 0;
  int component_type = 0;  // 5120 BYTE .. 5126 FLOAT
  int component_size = 0;  // bytes
  int components = 0;      // 1 SCALAR .. 16 MAT4; 0: broken
  bool normalized = false;
  struct Sparse {
    uint64_t count = 0;  // 0: not sparse
    int index_view = -1, value_view = -1;
    uint64_t index_offset = 0, value_offset = 0;
    int index_type = 0;
  } sparse;
};

struct GltfDocument {
  LoadProgress* progress = &LoadProgress::none();  // of the current load
  std::string file;                                // as given by the user
  ResourceFolder resources;
  // check_schema() has accepted this JSON, so members that the loader reads have the right type,
  // indices are in range, and integers are stored as integers. Broken objects are null.
  JsonValue json;
  std::unique_ptr<GltfFaults> faults;  // query these before using an object that may be broken
  MemoryReservation json_memory;
  struct BinaryChunk {
    uint64_t offset = 0, size = 0;
  };
  std::set<std::string, std::less<>> required_extensions;
  std::optional<BinaryChunk> binary_chunk;  // the chunk's range in a .glb file
  std::vector<std::unique_ptr<GltfBuffer>> buffers;
  std::vector<GltfView> views;  // one per bufferView, decompressed and range-checked
  std::vector<GltfAccessor> accessors;
  std::vector<int> parents;     // per node, -1 for roots; acyclic
  std::vector<int> node_order;  // parents before children, without nodes on or below a cycle
  std::shared_ptr<const tinygltf::Model> model;  // see parse_gltf_model
  MemoryReservation model_memory;
  uint64_t total_bytes = 0;  // size of the file and its buffers, which limits counts
  uint64_t max_zeros = 0;    // limit on the count of an accessor without data

  // Returns "file#/json/pointer", the place for an InputError.
  std::string place(const std::string& pointer) const { return file + "#" + pointer; }
  // Returns the array `name`, or an empty array if the file has none.
  const nlohmann::json& array(const char* name) const;
  bool requires_extension(std::string_view name) const {
    return required_extensions.contains(name);
  }
  // Reserves memory in the load's budget. On failure, throws LimitError at `at`, by default the
  // file.
  void reserve(MemoryPart part, uint64_t bytes) const { reserve(part, bytes, file); }
  void reserve(MemoryPart part, uint64_t bytes, const std::string& at) const {
    progress->budget()->reserve(part, bytes, at);
  }
  // Calls check(object, place, i) for each intact object of the array at `pointer`, if it exists.
  // An InputError from `check` marks the object as broken.
  using Check = std::function<void(const nlohmann::json&, const std::string& place, size_t i)>;
  void check_each(const std::string& pointer, const Check& check);
  // These throw InputError if the view or accessor is broken.
  const GltfView& view(int i) const;
  const GltfAccessor& accessor(int i) const;
  // Returns the bytes of a range, which must lie inside the view, or the bytes of the whole view.
  // The bytes are valid for the document's lifetime. Thread-safe. Throws InputError and Cancelled.
  ByteSpan bytes(int view, uint64_t offset, uint64_t length) const;
  ByteSpan bytes(int view) const;
  // Copies the bytes to `out`. If some of them are not loaded yet, reads all of them directly into
  // `out`.
  void copy_bytes(int view, uint64_t offset, uint64_t length, void* out) const;
  // Opens a file that the scene refers to and adds it to `files`. Thread-safe. Throws InputError.
  InputFile open_resource(const std::string& uri, const std::string& uri_place) const;
  // Returns the URIs of all buffers and images that are not data URIs, in the document's order.
  std::vector<std::string> external_uris() const;
  // Runs body(i) for all i < count in parallel, and advances `progress` by one item after each
  // call. Returns, for each call, its exception or null. Throws only Cancelled.
  std::vector<std::exception_ptr> try_each(size_t count,
                                           const std::function<void(size_t)>& body) const;
  // Returns all files opened so far. The scene file comes first.
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

// Reads the file and checks its container, its JSON and extensionsRequired. `resource_root` means
// the same as in GltfOptions. Throws InputError.
GltfDocument open_gltf_document(const std::string& path, const std::string& resource_root,
                                LoadProgress& progress);

// Opens the buffers, decompresses the views that meshopt has compressed, and fills `views`. Like
// the checks below, records broken objects as faults.
void load_gltf_buffers(GltfDocument& document);

// These are the checks of gltf/document/checks.cpp. The first two fill `accessors`, `parents` and
// `node_order`. check_gltf_nodes() throws InputError if the scene's nodes do not form trees.
void check_gltf_accessors(GltfDocument& document);
void check_gltf_nodes(GltfDocument& document);
void check_gltf_skins(GltfDocument& document);
void check_gltf_cameras_and_lights(GltfDocument& document);

// Parses assets, scenes, nodes, materials, textures, samplers, cameras, skins and punctual lights
// of a checked document, and adds glTF's defaults. tinygltf gets only JSON that check_schema() has
// accepted. It does not get extras, buffers, accessors, meshes and images, because version 2.7 does
// not check their indices and offsets. Throws InputError.
void parse_gltf_model(GltfDocument& document);

// Returns the member `key` of an object, or null if it is absent.
const nlohmann::json* find_member(const nlohmann::json& object, const char* key);
// Returns the extension `name` of `object`, or null if it is absent.
const nlohmann::json* find_extension(const nlohmann::json& object, const char* name);

}  // namespace emberline
