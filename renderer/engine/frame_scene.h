// Applies a frame's settings to the scene: edits, time, variant, camera.
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

// Loads the edits file that the settings name, if any. Throws InputError.
SceneEdits load_edits(const FrameSettings& settings, const LoadProgress& progress);

// Returns the time at which the scene is posed, in seconds; nullopt if neither `time` nor `frame`
// is given. Throws UsageError if both are given.
std::optional<double> pose_time(const FrameSettings& settings);

// Returns whether the shutter interval is empty.
bool is_instant(const FrameSettings& settings);

// Fills in the animation, time and shutter from the edits if the settings do not give them.
void apply_animation(const AnimationEdit& edit, FrameSettings& settings);

// If the shutter is open but the scene is at rest, logs why nothing is blurred.
void hint_at_rest(const FrameSettings& settings, const SceneDescription& scene);

// Returns the options for reading the parts of the scene file that the settings need. Edits may
// need further parts (AdditionalParts in scene_file.h). Throws UsageError.
GltfOptions load_options(const FrameSettings& settings);

// Logs a warning if texels of a picture had to be repaired. Call this once per file.
void warn_about_repaired(const std::string& file, uint64_t texels);

// Replaces the variant of `edits` with the settings' variant, if any. Throws a UsageError that
// lists the file's variants if there is no such variant.
void choose_variant(const FrameSettings& settings, const SceneDescription& scene,
                    SceneEdits& edits);

// Returns the camera that the settings choose, with the settings' lens applied. Throws a UsageError
// that lists the file's cameras if there is no such camera.
CameraDescription choose_camera(const FrameSettings& settings, const SceneDescription& scene);
// Returns the indices of the cameras that match --camera: first the cameras with this name, then
// the cameras whose node has this name. If no name matches, `requested` may be an index.
std::vector<size_t> matching_cameras(const std::string& requested,
                                     const std::vector<CameraDescription>& cameras);
// Returns the camera of the edits. If the settings choose a view, returns the settings' camera
// instead. Applies the settings' lens in both cases. Throws InputError for edits that do not fit
// the scene.
CameraDescription choose_camera(const FrameSettings& settings, const SceneDescription& scene,
                                const SceneEdits& edits);

// Moves the camera to the turntable frame that the settings give. From frame to frame, the camera
// moves to its right, on a circle around a vertical axis. The axis goes through the centre of the
// bounds, or through the point that the settings choose. choose_camera() calls this with the
// scene's bounds. If the settings have no turntable, the camera is unchanged.
CameraDescription apply_turntable(CameraDescription camera, const FrameSettings& settings,
                                  const WorldBounds& bounds);

// Creates the camera for the frame's size. If the view or lens is unusable, throws UsageError if it
// comes from the settings, and InputError if it comes from the file.
Camera create_camera(const FrameSettings& settings, const CameraDescription& camera,
                     const Scene& scene);

}  // namespace emberline
