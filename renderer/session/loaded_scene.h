// A scene as a session holds it: built, with what the window lists of it.
#pragma once

#include <memory>

#include "renderer/core/load_progress.h"
#include "renderer/engine/open_scene.h"
#include "renderer/output/render_options.h"
#include "renderer/session/listed_scene.h"

namespace emberline {

struct LoadedScene {
  std::shared_ptr<const ListedScene> open;
  SceneEdits edits;                  // of the edits' file; the options' variant, lens and time
  SceneDescription edit_lists;       // what edits count in, and no more: cheap to copy
  std::unique_ptr<OpenScene> scene;  // the rendering thread's, as is all that follows
  RenderOptions options;             // without animation, time and variant, which are edits
  AnimationEdit posed;               // that the scene is in,
  CameraDescription view;            // with the file's view then
  std::shared_ptr<MemoryBudget> budget;
  MemoryReservation memory = {};  // its share of what the window may take

  // The view without edits in a frame of this size: a camera that frames the scene fits itself to
  // the frame, as the command line's does.
  CameraDescription camera(int width, int height) const;
  // Whether edits want another pose than it is in; and puts it into that, with them. Throws what
  // loading would, and is as it was then.
  bool needs_repose(const SceneEdits& wanted) const;
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
