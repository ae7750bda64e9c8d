// URIs as glTF uses them (specification section 2.8): data URIs and relative references.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace emberline {

bool is_data_uri(std::string_view uri);

// The payload of "data:[media type][;parameter=value...][;base64],..." for any media type. Throws
// InputError at `place` if malformed.
std::vector<uint8_t> decode_data_uri(std::string_view uri, const std::string& place);

// Location of a scene's files: relative to `directory` and inside `root`.
struct ResourceFolder {
  std::filesystem::path directory, root;
};

struct ResolvedUri {
  std::filesystem::path name;  // relative to the directory
  std::filesystem::path file;  // links followed
};

// Finds the file of a relative reference. Also accepts unescaped names and backslashes if such a
// file exists: tries the unescaped name, then the URI unchanged, then both with "/" for "\".
// Absolute paths, other schemes (http:) and files outside the root are errors, so that a scene
// cannot read, for example, a user's keys.
ResolvedUri resolve_uri(std::string_view uri, const ResourceFolder& folder,
                        const std::string& place);

}  // namespace emberline
