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
// that lie there. It extends 100 radii of these bounds in each direction. The view of the whole
// scene and its internal space do not depend on the plane. If `scene` lists its nodes, the plane
// becomes another node.
//
// Throws UsageError if the plane would be more than 1000 radii away. Warns if it is above the
// scene.
void add_catcher_plane(std::optional<double> height, SceneDescription& scene);

}  // namespace emberline
