// The suffix of a file name decides the file's format.
#pragma once

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string>
#include <string_view>

namespace emberline {

inline std::string lower_case(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return text;
}

// Returns the part of the file name from its last dot, in lower case: ".exr" for "shots/A.010.EXR".
// Returns an empty string if the name has no dot, or only one at its beginning.
inline std::string lower_suffix(std::string_view path) {
  return lower_case(std::filesystem::path(path).extension().string());
}

inline bool is_exr(const std::string& path) { return lower_suffix(path) == ".exr"; }
inline bool is_json(const std::string& path) { return path.ends_with(".json"); }

}  // namespace emberline
