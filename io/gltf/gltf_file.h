// Loads glTF 2.0: .gltf and .glb, with external, embedded and data-URI buffers and images.
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
  // Warn instead of failing: an undecodable image becomes a neutral colour, an invalid material
  // value the specification's default, and a missing texture is dropped.
  bool lenient = false;
  // Also read the materials of all the file's variants, with their images and vertex attributes, so
  // that SceneEdits can choose one. Otherwise read only the variants' names.
  bool variants = false;
  // Give every mesh tangents, so that SceneEdits can make any material anisotropic. Otherwise only
  // meshes whose materials need them.
  bool tangents = false;
  // Include all nodes, with their names and parents.
  bool nodes = false;
  // Referenced files must lie below this folder, links followed. Empty: the scene's folder.
  std::string resource_root = {};
  // The animation that poses the scene: a name, an index, or "all" for all of them in file order.
  // `time` is in seconds, clamped to the animation's range, default 0. With only a time, the file's
  // first animation is used; with neither, the scene is at rest.
  std::string animation = {};
  std::optional<double> time = {};
  // Shutter interval in seconds relative to `time`; whatever moves in it is loaded with its motion.
  // Absent: a single instant.
  struct Shutter {
    double open = 0.0, close = 0.0;
  };
  std::optional<Shutter> shutter = {};
  // For an instant with motion vectors: seconds after `time` of the second positions
  // (NextFrameInstance).
  std::optional<double> next_frame = {};
};

// Reads `path`. Throws InputError (file, JSON pointer, what to do) if something that the image
// needs is unusable: missing file, not a glTF, truncated, out-of-range indices, cyclic nodes, an
// unsupported extension in extensionsRequired, or only points, lines and broken geometry. Faults in
// unneeded parts are warnings; a camera carries its own fault. A scene that shows nothing at this
// time has no instances and gives a warning. Throws UsageError, which lists the file's animations,
// for an unknown animation, and Cancelled before any other error once `progress` is cancelled.
//
// Never allocates by a count that the file's size does not bear out. Repairs and ignored features
// are in the result and warned of once. Decodes images in parallel (TBB). Thread-safe, but not
// reentrant with log hooks.
SceneDescription load_gltf(const std::string& path, const GltfOptions& options,
                           LoadProgress& progress = LoadProgress::none());

// An open file, for posing its scene at several times. Whatever does not depend on time is read,
// checked and decoded once and kept: the document, images, and meshes without their arrays. Buffers
// are kept while anything deforms. Not thread-safe.
class GltfFile {
 public:
  // Ignores `animation`, `time` and `shutter`. Throws as load_gltf does.
  GltfFile(const std::string& path, const GltfOptions& options,
           LoadProgress& progress = LoadProgress::none());
  ~GltfFile();
  GltfFile(const GltfFile&) = delete;
  GltfFile& operator=(const GltfFile&) = delete;

  // Like load_gltf for the animation, time and shutter of `pose_options`. In addition, resting
  // meshes have keys, and those whose keys are in `held` (ascending) come without arrays. Keys are
  // valid for one animation. Throws as load_gltf does; later poses still work.
  SceneDescription pose(const GltfOptions& pose_options, std::span<const uint64_t> held = {},
                        LoadProgress& progress = LoadProgress::none());

  // Reserved memory, which the caller must return to the budget.
  uint64_t image_bytes() const;       // all images so far
  uint64_t static_bytes() const;      // meshes with keys in the latest pose
  uint64_t new_static_bytes() const;  // those of them that were not held

 private:
  struct State;
  const std::unique_ptr<State> state_;
};

}  // namespace emberline
