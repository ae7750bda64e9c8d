// Versions of the I/O libraries in this build, for headers and reports.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace emberline {

std::vector<std::pair<std::string, std::string>> io_library_versions();

}  // namespace emberline
