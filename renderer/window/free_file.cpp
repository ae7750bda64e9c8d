#include "renderer/window/free_file.h"

#include <filesystem>
#include <system_error>

namespace emberline {

std::string free_file(const std::string& stem, const std::string& suffix) {
  std::string name = stem + suffix;
  std::error_code unknown;  // then it is tried, and what is wrong is said
  for (int i = 2; std::filesystem::exists(std::filesystem::symlink_status(name, unknown)); ++i) {
    name = stem + "-" + std::to_string(i) + suffix;
  }
  return name;
}

}  // namespace emberline
