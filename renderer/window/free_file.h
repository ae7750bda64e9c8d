// Names for files that the window writes without asking for one.
#pragma once

#include <string>

namespace emberline {

// The first of "<stem><suffix>", "<stem>-2<suffix>", … that nothing has.
std::string free_file(const std::string& stem, const std::string& suffix);

}  // namespace emberline
