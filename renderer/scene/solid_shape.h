// What meshes enclose, one alone or several together.
#pragma once

#include <span>
#include <string>

#include "renderer/scene/scene.h"

namespace emberline {

class LoadProgress;

namespace scene_detail {

// `meshes` are in one space and have triangles. Warns of closed ones that are inside out if they
// are given a name. Throws Cancelled.
SolidShape shape_of(std::span<const Mesh* const> meshes, const std::string* name,
                    LoadProgress& progress);

}  // namespace scene_detail
}  // namespace emberline
