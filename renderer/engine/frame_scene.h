// The scene and the view that a frame's settings ask for.
#pragma once

#include <optional>
#include <string>

#include "io/gltf/gltf_file.h"
#include "renderer/core/load_progress.h"
#include "renderer/description/framing.h"
#include "renderer/description/scene_description.h"
#include "renderer/description/scene_edits.h"
#include "renderer/engine/frame_settings.h"
#include "renderer/scene/camera.h"
#include "renderer/scene/scene.h"

namespace emberline {

// The edits of the settings, or none. Throws InputError.
SceneEdits load_edits(const FrameSettings& settings, const LoadProgress& progress);

// The time that the scene is posed for, in seconds; absent: no animation is chosen. Throws
// UsageError if `time` and `frame` are both given.
std::optional<double> chosen_time(const FrameSettings& settings);

// Whether the shutter is open for no time.
bool is_instant(const FrameSettings& settings);

// Fills in animation, time and shutter from the edits where the settings have none.
void apply_animation(const AnimationEdit& edit, FrameSettings& settings);

// The options that the scene's file is read with, before what edits need. Throws UsageError.
GltfOptions load_options(const FrameSettings& settings);

// Warns, once per file, that texels of a picture had to be repaired.
void warn_of_repaired(const std::string& file, uint64_t texels);

// The variant that the settings choose takes the place of that of `edits`. Throws UsageError that
// lists the file's.
void choose_variant(const FrameSettings& settings, const SceneDescription& scene,
                    SceneEdits& edits);

// The camera that the settings choose, and the lens on it. Throws UsageError that lists the file's
// cameras.
CameraDescription choose_camera(const FrameSettings& settings, const SceneDescription& scene);
// The cameras that --camera may mean: those of that name, then those whose node has it, else the
// one of that index.
std::vector<size_t> cameras_called(const std::string& wanted,
                                   const std::vector<CameraDescription>& cameras);
// The edits' camera, unless the settings choose a view; a lens of the settings applies to either.
// Throws InputError for edits that do not fit the scene.
CameraDescription choose_camera(const FrameSettings& settings, const SceneDescription& scene,
                                const SceneEdits& edits);

// Moves the camera to the settings' frame of a turntable: to its right, on a circle around the
// vertical axis through the centre of the bounds. choose_camera() does that with the scene's
// bounds. Without a turntable the camera is returned unchanged.
CameraDescription turned(CameraDescription camera, const FrameSettings& settings,
                         const WorldBounds& bounds);

// The camera for a frame of this size. Throws UsageError if the view or lens of the settings cannot
// be rendered, InputError if the file's cannot.
Camera create_camera(const FrameSettings& settings, const CameraDescription& camera,
                     const Scene& scene);

}  // namespace emberline
