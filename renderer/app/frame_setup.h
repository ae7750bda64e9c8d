// From options to the objects of a frame: which camera, which environment, which pixels.
#pragma once

#include <string>

#include "renderer/app/render_options.h"
#include "renderer/core/load_progress.h"
#include "renderer/scene/camera.h"
#include "renderer/scene/scene.h"
#include "renderer/scene/scene_description.h"
#include "renderer/scene/scene_edits.h"

namespace emberline {

// The edits of the options, or none. Throws InputError.
SceneEdits load_edits(const RenderOptions& options, const LoadProgress& progress);

// Loads the scene, puts the environment of the options into it. `variants` as in GltfOptions, for
// those who edit it; where the options choose one, they are read in any case. Throws InputError,
// and Cancelled.
SceneDescription load_scene(const RenderOptions& options,
                            LoadProgress& progress = LoadProgress::unwatched(),
                            bool variants = true);

// The variant that the options choose takes the place of that of `edits`. Throws UsageError that
// lists the file's.
void choose_variant(const RenderOptions& options, const SceneDescription& scene, SceneEdits& edits);

// The camera that the options choose, and the lens on it. Throws UsageError that lists the file's
// cameras.
CameraDescription choose_camera(const RenderOptions& options, const SceneDescription& scene);
// The same with edits: theirs, unless the command line asks for a view of its own; the command
// line's lens goes onto either. Throws InputError for edits that do not fit the scene.
CameraDescription choose_camera(const RenderOptions& options, const SceneDescription& scene,
                                const SceneEdits& edits);

// It in the options' frame of a scene. Throws UsageError where the command line's view or lens
// cannot be rendered, InputError where the file's cannot.
Camera create_camera(const RenderOptions& options, const CameraDescription& camera,
                     const Scene& scene);

}  // namespace emberline
