// Loads glTF 2.0 files: .gltf and .glb, with buffers and images that are external, embedded or in
// data URIs.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/core/load_progress.h"
#include "renderer/description/scene_description.h"

namespace emberline {

struct GltfOptions {
  // Warns instead of failing: an undecodable image becomes a neutral colour, an invalid material
  // value becomes the specification's default, and a missing texture is dropped.
  bool lenient = false;
  // Also reads the materials of all variants in the file, with their images and vertex attributes,
  // so that SceneEdits can choose a variant. Otherwise only the variants' names are read.
  bool variants = false;
  // Gives every mesh tangents, so that SceneEdits can make any material anisotropic. Otherwise only
  // meshes whose materials need tangents get them.
  bool tangents = false;
  // Fills SceneDescription::nodes with all nodes of the file.
  bool nodes = false;
  // Referenced files must lie below this folder after links have been followed. If empty, the
  // scene's folder is used.
  std::string resource_root = {};
  // The animation that poses the scene: a name, an index, or "all" for all of them in file order.
  // `time` is in seconds, clamped to the animation's range. The default time is 0. If only the time
  // is set, the file's first animation is used. If neither is set, the scene is at rest.
  std::string animation = {};
  std::optional<double> time = {};
  // The shutter interval in seconds, relative to `time`. Objects that move in this interval are
  // loaded with their motion. If the interval is absent, the scene is loaded at a single instant.
  struct Shutter {
    double open = 0.0, close = 0.0;
  };
  std::optional<Shutter> shutter = {};
  // Also loads the positions this many seconds after `time` (NextFrameInstance), for motion vectors
  // without a shutter.
  std::optional<double> next_frame = {};
};

// Reads `path`. Throws InputError (with the file, the JSON pointer and what to do) if something
// that the image needs is unusable. Examples are a file that is missing, truncated or not a glTF,
// out-of-range indices, cyclic nodes, an unsupported extension in extensionsRequired, and a file
// with only points, lines and broken geometry. Faults in unneeded parts cause warnings. A faulty
// camera does not fail the load: its error is stored in CameraDescription::fault. If nothing is
// visible at this time, the result has no instances, and a warning says so. For an unknown
// animation, throws UsageError, which lists the file's animations. Once `progress` is cancelled,
// throws Cancelled before any other error.
//
// Allocates no more memory than the file's size justifies, even if the file declares huge counts.
// The result lists repairs and ignored features. Each of them causes one warning. Decodes images in
// parallel (TBB). Thread-safe, but must not be called from a log hook.
SceneDescription load_gltf(const std::string& path, const GltfOptions& options,
                           LoadProgress& progress = LoadProgress::none());

// An open file whose scene can be posed at several times. Everything that does not depend on time
// is read, checked and decoded once and then kept: the document, the images, and the meshes (but
// not their vertices and triangles). The file's buffers are kept only if a mesh deforms. Not
// thread-safe.
class GltfFile {
 public:
  // Ignores `animation`, `time` and `shutter`. Throws as load_gltf() does.
  GltfFile(const std::string& path, const GltfOptions& options,
           LoadProgress& progress = LoadProgress::none());
  ~GltfFile();
  GltfFile(const GltfFile&) = delete;
  GltfFile& operator=(const GltfFile&) = delete;

  // Like load_gltf(), with the animation, time and shutter of `pose_options`. In addition, each
  // mesh that never deforms has a key. `held` (ascending) lists the keys of meshes that the caller
  // still has from earlier poses. These meshes are returned without vertices and triangles. Keys
  // are invalid for another animation. Throws as load_gltf() does. Even after an exception, later
  // calls work.
  SceneDescription pose(const GltfOptions& pose_options, std::span<const uint64_t> held = {},
                        LoadProgress& progress = LoadProgress::none());

  // Bytes that are reserved in the budget. The caller must release them.
  uint64_t image_bytes() const;       // for all images so far
  uint64_t static_bytes() const;      // for meshes with keys in the latest pose
  uint64_t new_static_bytes() const;  // the part of static_bytes() for meshes that were not held

 private:
  struct State;
  const std::unique_ptr<State> state_;
};

}  // namespace emberline
