// A scene that is open: read from its file, built, and put into one pose after another. Whatever
// renders does it through here (`info`, which does not, reads the file alone). What throws leaves
// the scene as it was.
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

// What will be asked of an open scene.
struct OpenOptions {
  SceneBuildOptions build = {};
  // Its edits will change: it has editable(), and is built without the edits it is opened with.
  bool edits = false;
  // Other times will be asked for: the file stays open if it has animations.
  bool poses = false;
};

// A scene that is read and posed but not built. What it has reserved is given back unless it is
// built.
class ReadScene {
 public:
  // Reads the file and the environment of the settings, at the settings' time or else the edits'.
  // The variant of the settings replaces that of `edits`. Throws InputError, UsageError,
  // RenderError and Cancelled.
  ReadScene(const FrameSettings& settings, SceneEdits edits, const OpenOptions& options,
            LoadProgress& progress);
  ReadScene(ReadScene&&) noexcept = default;
  ReadScene& operator=(ReadScene&&) = delete;
  ~ReadScene();

  // The edits are applied to it unless OpenOptions::edits.
  const SceneDescription& description() const { return description_; }
  const SceneEdits& edits() const { return edits_; }

  // Throws what build_scene() does, and UsageError for names that are not in the scene.
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
  // For other threads while nothing poses or edits it.
  const Scene& scene() const { return editable_ ? editable_->scene() : *scene_; }
  // Valid until the scene is posed.
  SceneParts parts() const { return parts_.pointers(); }
  // Of the file in the pose that the scene is in.
  const CoverageReport& coverage() const { return coverage_; }
  const LoadRepairs& repairs() const { return repairs_; }

  // With OpenOptions::poses. False: the scene is the same at all times.
  bool can_pose() const;
  // The scene with other animation settings. Meshes that it holds already are left out of the
  // description. Throws as the constructor of ReadScene does.
  ReadScene read(const FrameSettings& settings, SceneEdits edits, LoadProgress& progress);
  // Puts it into a pose that was read from it, with the edits of that. Nobody may use scene()
  // meanwhile, and it may be another object afterwards. Throws what build() does. False: the pose
  // needed another internal space, and all was built anew.
  bool pose(ReadScene read, LoadProgress& progress);

  // With OpenOptions::edits.
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

  OpenScene(const OpenOptions& options, std::shared_ptr<SceneSource> source)
      : options_(options), source_(std::move(source)) {}
  void build(ReadScene& read, LoadProgress& progress);
  bool repose(ReadScene& read, LoadProgress& progress);

  OpenOptions options_;
  std::shared_ptr<SceneSource> source_;  // goes last
  std::unique_ptr<Scene> scene_;
  std::optional<EditableScene> editable_;
  Parts parts_;
  CoverageReport coverage_;
  LoadRepairs repairs_;
};

}  // namespace emberline
