// An open scene that can be posed repeatedly. Only this file loads, poses, edits, rebuilds and
// rolls back scenes. A step that throws leaves the scene unchanged.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "renderer/core/load_progress.h"
#include "renderer/description/scene_description.h"
#include "renderer/description/scene_edits.h"
#include "renderer/engine/frame_settings.h"
#include "renderer/engine/scene_parts.h"
#include "renderer/scene/build_scene.h"
#include "renderer/scene/cryptomatte_ids.h"
#include "renderer/scene/editable_scene.h"
#include "renderer/scene/light_groups.h"
#include "renderer/scene/scene.h"
#include "renderer/scene/surface_roles.h"

namespace emberline {

class OpenScene;
class SceneSource;

// Chooses what the open scene must support.
struct OpenOptions {
  SceneBuildOptions build = {};
  bool edits = false;  // enables editable(); the scene is built without its initial edits
  bool poses = false;  // enables read() and pose() for other times; keeps an animated file open
  bool nodes = false;  // lists all nodes of the file
};

// A scene that is read and posed but not built. If it is destroyed without being built, its memory
// reservations are released.
class ReadScene {
 public:
  // Reads the scene's file and the environment that the settings name. Poses the scene at the
  // settings' time or, if they have none, at the edits' time. If the settings name a variant, it
  // replaces the variant of `edits`. Throws InputError, UsageError, RenderError and Cancelled.
  ReadScene(const FrameSettings& settings, SceneEdits edits, const OpenOptions& options,
            LoadProgress& progress);
  ReadScene(ReadScene&&) noexcept = default;
  ReadScene& operator=(ReadScene&&) = delete;
  ~ReadScene();

  // The description includes the edits unless OpenOptions::edits is set.
  const SceneDescription& description() const { return description_; }
  const SceneEdits& edits() const { return edits_; }

  // Throws what build_scene() throws, and UsageError for names that are not in the scene.
  std::unique_ptr<OpenScene> build(LoadProgress& progress) &&;

 private:
  friend class OpenScene;
  ReadScene(const FrameSettings& settings, SceneEdits edits, const OpenOptions& options,
            std::shared_ptr<SceneSource> source);
  void read(std::span<const uint64_t> held, LoadProgress& progress);

  FrameSettings settings_;
  SceneEdits edits_;
  OpenOptions options_;
  std::shared_ptr<SceneSource> source_;
  SceneDescription description_;
};

class OpenScene {
 public:
  // Thread-safe, except while the scene is being posed or edited.
  const Scene& scene() const { return editable_ ? editable_->scene() : *scene_; }
  // Valid until the scene is posed.
  SceneParts parts() const { return parts_.pointers(); }
  // The settings with which the scene was read, including animation, time and shutter of the edits.
  const FrameSettings& settings() const { return settings_; }
  // Returns `settings` with the animation, time and shutter of the current pose.
  FrameSettings posed(FrameSettings settings) const;
  // Return reports on the scene in its current pose.
  const CoverageReport& coverage() const { return coverage_; }
  const LoadRepairs& repairs() const { return repairs_; }
  // The budget in which the scene's memory is reserved.
  const std::shared_ptr<MemoryBudget>& memory() const;

  // Returns whether the scene has an animation. Requires OpenOptions::poses.
  bool can_pose() const;
  // Reads the scene with other animation settings. The description omits meshes that the scene
  // already has in memory. Throws like the constructor of ReadScene.
  ReadScene read(const FrameSettings& settings, SceneEdits edits, LoadProgress& progress);
  // Applies a pose from read(), including its edits. scene() must not be in use; afterwards, it may
  // return a different object. Returns false if the whole scene had to be rebuilt, because the pose
  // needed another internal space (origin and scale). Throws like build().
  bool pose(ReadScene read, LoadProgress& progress);

  // These functions require OpenOptions::edits.
  EditableScene& editable() { return *editable_; }
  const EditableScene& editable() const { return *editable_; }

 private:
  friend class ReadScene;

  struct Parts {
    explicit Parts(const ReadScene& read);
    Parts() = default;
    SceneParts pointers() const;

    std::optional<LightGroups> light_groups;
    std::optional<CryptomatteIds> cryptomattes;
    std::optional<SurfaceRoles> roles;
  };

  OpenScene(const OpenOptions& options, const FrameSettings& settings,
            std::shared_ptr<SceneSource> source)
      : options_(options), settings_(settings), source_(std::move(source)) {}
  void build(ReadScene& read, LoadProgress& progress);
  bool repose(ReadScene& read, LoadProgress& progress);

  OpenOptions options_;
  FrameSettings settings_;
  std::shared_ptr<SceneSource> source_;  // declared before the scene, so destroyed after it
  std::unique_ptr<Scene> scene_;
  std::optional<EditableScene> editable_;
  Parts parts_;
  CoverageReport coverage_;
  LoadRepairs repairs_;
};

}  // namespace emberline
