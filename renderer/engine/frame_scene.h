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

// When the scene is posed, in seconds; absent: at rest, if no animation is chosen. Throws
// UsageError where it is said twice.
std::optional<double> chosen_time(const FrameSettings& settings);

// Whether the shutter is open for no time.
bool is_instant(const FrameSettings& settings);

// The animation, time and shutter of edits, where the settings say nothing of them.
void apply_animation(const AnimationEdit& edit, FrameSettings& settings);

// How the settings have the scene's file read, but for what edits need. Throws UsageError.
GltfOptions load_options(const FrameSettings& settings);

// Of a picture whose texels had to be repaired: says so, once.
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
// The same with edits: theirs, unless the command line asks for a view of its own; the command
// line's lens goes onto either. Throws InputError for edits that do not fit the scene.
CameraDescription choose_camera(const FrameSettings& settings, const SceneDescription& scene,
                                const SceneEdits& edits);

// A camera in the settings' frame of a turntable, or as it stands without: it goes to its right, on
// a circle round the vertical axis through the middle of the bounds, and turns with it.
// choose_camera does that with the scene's.
CameraDescription turned(CameraDescription camera, const FrameSettings& settings,
                         const WorldBounds& bounds);

// It in the settings' frame of a scene. Throws UsageError where the command line's view or lens
// cannot be rendered, InputError where the file's cannot.
Camera create_camera(const FrameSettings& settings, const CameraDescription& camera,
                     const Scene& scene);

}  // namespace emberline
