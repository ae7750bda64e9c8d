// Formats the nodes of a scene file as text.
#pragma once

#include <string>
#include <vector>

#include "renderer/description/scene_description.h"

namespace emberline {

// Returns an indented line for each node, such as "3 'wheel'  mesh". Lists the nodes nearest the
// roots, at most 200 on at most 24 levels, and says how many more there are. Names are shortened
// and made printable. No node may be its own ancestor.
std::string node_tree(const std::vector<NodeDescription>& nodes);

}  // namespace emberline
