// A session's built scene, with the lists that a window shows.
#pragma once

#include <memory>

#include "renderer/core/load_progress.h"
#include "renderer/engine/open_scene.h"
#include "renderer/output/render_options.h"
#include "renderer/session/listed_scene.h"

namespace emberline {

struct LoadedScene {
  std::shared_ptr<const ListedScene> open;
  SceneEdits edits;             // from the edits file; includes the options' variant, lens and time
  SceneDescription edit_lists;  // only the lists that edits refer to: cheap to copy
  // After loading, only the rendering thread uses `scene` and the members below. Exception: any
  // thread may call memory.budget().
  std::unique_ptr<OpenScene> scene;
  RenderOptions options;            // without animation, time and variant, which are in `edits`
  AnimationEdit current_animation;  // the current pose
  CameraDescription view;           // the camera without edits, in the current pose
  std::shared_ptr<MemoryBudget> budget;
  MemoryReservation memory = {};  // the part of the session's budget that this scene uses

  // Returns the camera without edits for a frame of this size. If neither the file nor the user
  // chose a camera, the returned camera shows the whole scene in such a frame, as on the command
  // line.
  CameraDescription camera(int width, int height) const;
  // needs_repose() returns whether the edits need another pose; pose() applies that pose and the
  // edits. pose() throws the same errors as loading; the scene is then unchanged.
  bool needs_repose(const SceneEdits& target_edits) const;
  void pose(const SceneEdits& target_edits);
};

// Reads the options' scene, environment and edits, and builds an editable scene. Throws the errors
// that `render` would report, and Cancelled.
std::shared_ptr<LoadedScene> load_session_scene(RenderOptions options, LoadProgress& progress);

// Throws InputError if the edits do not fit the scene. Reads no files.
void check_edits(const SceneEdits& edits, const LoadedScene& scene);

// Returns the edits with all lights switched off except `solo`.
SceneEdits with_solo(const SceneEdits& edits, const LightEdit& solo, const LoadedScene& scene);

// If the view comes from the options, returns the edits with that view added, so that `render`
// needs no options for it.
SceneEdits with_view(const SceneEdits& edits, const RenderOptions& options,
                     const LoadedScene& scene);

}  // namespace emberline
