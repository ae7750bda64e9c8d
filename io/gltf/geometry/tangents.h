// Computes tangents in the MikkTSpace convention.
#pragma once

#include "renderer/description/scene_description.h"

namespace emberline {

// Computes mesh.tangents from the UV set and transform of `layout`, as glTF 2.0 section 3.7.2.1
// requires if TANGENT is missing. The method is M. Mikkelsen's, "Simulation of Wrinkled Surfaces
// Revisited" (2008), with the weights of his reference code. A tangent is the sum of the directions
// of increasing u of all corners that share position, normal, UV and UV orientation. Each direction
// is projected to the vertex's tangent plane and weighted by the corner's angle. A vertex with
// corners of both orientations is split. The bitangent cross(normal, tangent) * w points towards
// decreasing v, which is "up" in an image.
//
// A KHR_texture_transform rotates generated tangents with the texture, as in the Khronos sample
// renderer. Tangents from the file are not changed.
//
// If the mesh has no normals, its faces are flat. In this case, vertices are first split per face.
void generate_tangents(MeshDescription& mesh, const TextureRef& layout);

// Returns an arbitrary tangent for a vertex with this normal and without a UV direction.
Vec4f arbitrary_tangent(const Vec3f& normal);

}  // namespace emberline
