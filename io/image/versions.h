// Which I/O libraries this binary was built with, for headers and reports.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace emberline {

std::vector<std::pair<std::string, std::string>> io_library_versions();

}  // namespace emberline
