// A floor that catches shadows, for scenes without one.
#pragma once

#include <optional>

#include "renderer/core/vector.h"

namespace emberline {

struct SceneDescription;

// Reflectance of the plane: the grey card of photographers. The plane is Lambertian.
inline constexpr float kCatcherPlaneAlbedo = 0.18f;

// Adds a horizontal, single-sided plane around the scene at this height, in metres. By default, it
// lies just below the lowest point of framed_bounds(), so that it does not coincide with surfaces
// that lie there. It extends 100 radii of these bounds in each direction. The plane affects neither
// the view of the whole scene nor its internal space (scene.h). The plane gets a node
// that catches shadows.
//
// Throws UsageError if the plane would be more than 1000 radii from the centre of these bounds.
// Warns if it is above the scene.
void add_catcher_plane(std::optional<double> height, SceneDescription& scene);

}  // namespace emberline
