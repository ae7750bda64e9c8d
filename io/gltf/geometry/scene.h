// Flattens the node hierarchy into instances, lights and cameras in world space.
#pragma once

#include <span>

#include "io/gltf/animation/animated_values.h"
#include "io/gltf/animation/animation.h"
#include "io/gltf/animation/cache.h"
#include "io/gltf/document/document.h"
#include "renderer/description/scene_description.h"

namespace emberline {

// Reads the meshes, instances, lights and cameras of the file's default scene (`scene`, else scene
// 0, else all root nodes) into `scene`, in the animation's pose. The materials of `scene` must have
// been read before. Loads meshes in parallel. Also records repairs and coverage. Undeformed meshes
// are added to `cache`. `held` (ascending) lists the keys of cached meshes that the caller still
// has; these are not read again. Throws InputError, also if the only geometry is broken or has no
// surface.
void load_scene_graph(const GltfDocument& document, const GltfAnimation& animation,
                      const GltfAnimatedValues& changes, std::span<const uint64_t> held,
                      GltfCache& cache, SceneDescription& scene);

// Returns all nodes in file order.
std::vector<NodeDescription> read_nodes(const GltfDocument& document);

}  // namespace emberline
