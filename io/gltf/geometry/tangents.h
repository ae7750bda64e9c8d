// Tangents after the MikkTSpace convention.
#pragma once

#include "renderer/description/scene_description.h"

namespace emberline {

// Fills mesh.tangents for the UV set and transform of `layout`, as glTF 2.0 section 3.7.2.1 asks
// when TANGENT is missing: M. Mikkelsen, "Simulation of Wrinkled Surfaces Revisited" (2008), as his
// reference code weighs it: per corner the direction of growing u, projected to the vertex's
// tangent plane, weighted by the corner's angle, summed over all corners that share position,
// normal, UV and orientation of the UV map. Corners of one vertex that belong to both orientations
// split it. w is such that the bitangent cross(normal, tangent) * w points to falling v, "up" in an
// image.
//
// A KHR_texture_transform turns the frame with the texture, as in the Khronos sample renderer;
// supplied tangents are taken as they are.
//
// Without normals the faces are flat: vertices are split per face first.
void generate_tangents(MeshDescription& mesh, const TextureRef& layout);

// Some tangent for a normal, for vertices that no UV direction reaches.
Vec4f arbitrary_tangent(const Vec3f& normal);

}  // namespace emberline
