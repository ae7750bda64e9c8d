// glTF 2.0 in: .gltf and .glb, with external, embedded and data-URI buffers and images.
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
  // An image that does not decode becomes a neutral colour, a material's number that cannot be the
  // specification's default, a texture that is not there none; with a warning instead of an error.
  bool lenient = false;
  // True: what the meshes wear in any of the file's variants is read as well, images and vertex
  // attributes included, so that SceneEdits can choose one. Otherwise their names alone.
  bool variants = false;
  // True: every mesh has tangents, so that SceneEdits can make any material anisotropic. Otherwise
  // those whose materials need them in the file.
  bool tangents = false;
  // True: the names and roots of all nodes are in the scene.
  bool nodes = false;
  // The files that the scene refers to lie in this folder or below, links followed; empty: in the
  // scene's own.
  std::string resource_root = {};
  // Which animation poses the scene, by name or index, or "all" of them in their order; and when,
  // in seconds: 0, if nothing is said, held to where it begins and ends. With a time alone it is
  // the file's first; with neither the scene is at rest, as its nodes say.
  std::string animation = {};
  std::optional<double> time = {};
  // While the shutter is open, in seconds from that time on: what moves then is in the scene with
  // its motion. Absent: the instant alone.
  struct Shutter {
    double open = 0.0, close = 0.0;
  };
  std::optional<Shutter> shutter = {};
  // Of an instant, in seconds from then on: where things are at that time is in the scene as well
  // (LaterInstance), which is otherwise as it is without.
  std::optional<double> later = {};
};

// Reads `path`. Throws InputError (file, JSON pointer, what to do) for anything unusable that the
// picture needs: missing file, not a glTF, truncated, out-of-range indices, cyclic nodes, an
// extension in extensionsRequired that is not honoured, nothing but points, lines or broken
// geometry. A scene that shows nothing at this time has no instances, and a warning. What it does
// not need is warned of; a camera has its fault with it. Never allocates by a count that the file's
// own size does not bear out. What was repaired or ignored is in the result and warned of once.
// Images are decoded in parallel (TBB). Not reentrant with log hooks; otherwise thread-safe. Throws
// Cancelled if `progress` says so, before anything else that there is to throw; and UsageError,
// which lists the file's animations, for one that it has not.
SceneDescription load_gltf(const std::string& path, const GltfOptions& options,
                           LoadProgress& progress = LoadProgress::unwatched());

// A file whose scene is wanted at one time after another. What no time changes is read, checked and
// decoded once, and kept: the document, images, what meshes are apart from their arrays. Buffers
// are kept while something deforms. One call at a time.
class GltfFile {
 public:
  // Of the options all but animation, time and shutter count. Throws as load_gltf does.
  GltfFile(const std::string& path, const GltfOptions& options,
           LoadProgress& progress = LoadProgress::unwatched());
  ~GltfFile();
  GltfFile(const GltfFile&) = delete;
  GltfFile& operator=(const GltfFile&) = delete;

  // What load_gltf gives for the animation, time and shutter of `when`; but meshes that rest have
  // keys, and those with keys that are `held`, growing, come without their arrays. With another
  // animation there are other keys. Throws as load_gltf does; the next pose is none the worse.
  SceneDescription pose(const GltfOptions& when, std::span<const uint64_t> held = {},
                        LoadProgress& progress = LoadProgress::unwatched());

  // For whoever gives back what poses have reserved, since the file does not.
  uint64_t image_bytes() const;    // for all images so far
  uint64_t resting_bytes() const;  // for the meshes with keys of the pose made last
  uint64_t read_bytes() const;     // for those of them that were not held

 private:
  struct State;
  const std::unique_ptr<State> state_;
};

}  // namespace emberline
