// Flattens the node hierarchy into instances, lights and cameras in world space.
#pragma once

#include <span>

#include "io/gltf/animation/animated_values.h"
#include "io/gltf/animation/animation.h"
#include "io/gltf/animation/cache.h"
#include "io/gltf/document/document.h"
#include "renderer/description/scene_description.h"

namespace emberline {

// Fills meshes, instances, lights and cameras of `scene`, whose materials must have been read, from
// the file's default scene (`scene`, else scene 0, else all root nodes) in the animation's pose.
// Loads meshes in parallel; adds repairs and coverage. Undeformed meshes are added to `cache`.
// Meshes in the cache whose keys are in `held` (ascending) are not read again. Throws InputError,
// also if the file has nothing to render at any time.
void load_scene_graph(const GltfDocument& document, const GltfAnimation& animation,
                      const GltfAnimatedValues& changes, std::span<const uint64_t> held,
                      GltfCache& cache, SceneDescription& scene);

// Returns all nodes in file order.
std::vector<NodeDescription> read_nodes(const GltfDocument& document);

}  // namespace emberline
