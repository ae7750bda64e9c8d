// Which Embree this binary runs with.
#pragma once

#include <string>

namespace emberline {

std::string embree_version();  // "3.13.5"

}  // namespace emberline
