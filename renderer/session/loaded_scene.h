// A scene as a session holds it: built, with what the window lists of it.
#pragma once

#include <memory>

#include "renderer/core/load_progress.h"
#include "renderer/frame/scene_file.h"
#include "renderer/output/render_options.h"
#include "renderer/scene/editable_scene.h"
#include "renderer/session/open_scene.h"

namespace emberline {

struct LoadedScene {
  std::shared_ptr<const OpenScene> open;
  SceneEdits edits;               // of the edits' file; the options' variant, lens and time
  EditableScene scene;            // the rendering thread's
  SceneDescription edit_lists;    // what edits count in, and no more: cheap to copy
  MemoryReservation memory = {};  // its share of what the window may take

  // The rendering thread's: what poses it, unless the file has no animations; the pose that it is
  // in, and the view of that.
  struct Posing {
    RenderOptions options;  // without animation and time, which are edits
    SceneFile file;
    std::shared_ptr<MemoryBudget> budget;
    PosedMemory memory;
    AnimationEdit pose;
    CameraDescription camera;
  };
  std::unique_ptr<Posing> posing = {};
  SceneBuildOptions build = {};

  // The view without edits in a frame of this size: a camera that frames the scene fits itself to
  // the frame, as the command line's does. The rendering thread's.
  CameraDescription camera(int width, int height) const;
  // Whether edits want another pose than it is in; and puts it into that, with them. Throws what
  // loading would, and is as it was then. The rendering thread's.
  bool stands_otherwise(const SceneEdits& wanted) const;
  void pose(const SceneEdits& wanted);
};

// Reads the options' scene, surroundings and edits, and builds it so that it can be edited. Throws
// what `render` would report, and Cancelled.
std::shared_ptr<LoadedScene> load_for_view(RenderOptions options, LoadProgress& progress);

// Throws InputError for edits that do not fit the scene; looks at no file.
void check_edits(const SceneEdits& edits, const LoadedScene& scene);

// The edits with every other light off.
SceneEdits with_solo(const SceneEdits& edits, const LightEdit& solo, const LoadedScene& scene);

// The edits with the view stated where the options of `render` would otherwise have to ask for it.
SceneEdits with_view(const SceneEdits& edits, const RenderOptions& options,
                     const LoadedScene& scene);

}  // namespace emberline
