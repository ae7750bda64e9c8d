// The nodes of a scene file as text.
#pragma once

#include <string>
#include <vector>

#include "renderer/description/scene_description.h"

namespace emberline {

// One indented line for each node: "3 'wheel'  mesh". At most 200 nodes and 24 levels are listed,
// those nearest the roots first; lines say how many more there are. Names are shortened and
// printable. Nodes must not be their own ancestors.
std::string node_tree(const std::vector<NodeDescription>& nodes);

}  // namespace emberline
