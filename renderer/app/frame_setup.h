// From options to the objects of a frame: which camera, which environment, which pixels.
#pragma once

#include <string>

#include "renderer/app/render_options.h"
#include "renderer/core/rect.h"
#include "renderer/scene/scene_description.h"

namespace emberline {

// Loads the scene, puts the environment of the options into it.
SceneDescription load_scene(const RenderOptions& options);

// The camera that the options choose. Throws UsageError that lists the file's cameras.
CameraDescription choose_camera(const RenderOptions& options, const SceneDescription& scene);

// The crop, or the whole frame. Throws UsageError for one outside the frame.
Rect choose_window(const RenderOptions& options);

}  // namespace emberline
