// What a file is to hold is told by the end of its name.
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

// From the last dot of the file's own name on, in lower case: ".exr" of "shots/A.010.EXR". Empty
// without a dot, and for a name that only begins with one.
inline std::string lower_suffix(std::string_view path) {
  return lower_case(std::filesystem::path(path).extension().string());
}

inline bool is_exr(const std::string& path) { return lower_suffix(path) == ".exr"; }
inline bool is_json(const std::string& path) { return path.ends_with(".json"); }

}  // namespace emberline
