// Applies morph targets and skins for one pose.
#pragma once

#include <span>

#include "io/gltf/geometry/primitive.h"
#include "renderer/description/scene_description.h"

namespace emberline {

// For each target, adds its weight times its displacements to positions, normals, tangents, UVs and
// colours (specification section 3.7.2.2). Throws InputError if there are more weights than
// targets.
void apply_morph_targets(const PrimitiveReader& reader, const GltfDocument& document,
                         const nlohmann::json& primitive, const std::string& pointer,
                         std::span<const double> weights, MeshDescription& mesh);

// Applies linear blend skinning (section 3.7.3.3). `joints` holds one matrix per joint, from bind
// space to instance space. If it is empty, does nothing. Throws InputError for a joint index out of
// range.
void apply_skin(const PrimitiveReader& reader, const GltfDocument& document,
                const std::string& pointer, std::span<const Mat44d> joints, MeshDescription& mesh);

}  // namespace emberline
