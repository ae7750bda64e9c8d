// The node hierarchy, flattened: instances, lights and cameras in world space.
#pragma once

#include <span>

#include "io/gltf/animation/animation.h"
#include "io/gltf/animation/changes.h"
#include "io/gltf/animation/rest.h"
#include "io/gltf/document/document.h"
#include "renderer/description/scene_description.h"

namespace emberline {

// Fills meshes, instances, lights and cameras of `scene` (whose materials are read already) from
// the file's default scene: `scene`, else scene 0, else every root node, in the animation's pose.
// Meshes load in parallel. Repairs and coverage are added. What `rest` knows is not read again,
// and what it may come to know is added to it; of meshes whose keys are `held`, which grow, nothing
// is read. Throws InputError, also when nothing is left to render; what an animation hides for now
// is something.
void load_scene_graph(const GltfDocument& document, const GltfAnimation& animation,
                      const GltfChanges& changes, std::span<const uint64_t> held, GltfRest& rest,
                      SceneDescription& scene);

// By their numbers.
std::vector<NodeDescription> read_nodes(const GltfDocument& document);

}  // namespace emberline
