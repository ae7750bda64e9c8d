// Formats the nodes of a scene file as text.
#pragma once

#include <string>
#include <vector>

#include "renderer/description/scene_description.h"

namespace emberline {

// Returns an indented line for each node, such as "3 'wheel'  mesh". Lists the nodes that are
// nearest to the roots, at most 200 on at most 24 levels, and says how many more nodes there are.
// Shortens names and makes them printable. No node may be its own ancestor.
std::string node_tree(const std::vector<NodeDescription>& nodes);

}  // namespace emberline
