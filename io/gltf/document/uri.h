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
// InputError naming `place` for anything malformed.
std::vector<uint8_t> decode_data_uri(std::string_view uri, const std::string& place);

// Where the files are that a scene refers to: relative to `directory`, and inside `root`.
struct ResourceFolder {
  std::filesystem::path directory, root;
};

struct ResolvedUri {
  std::filesystem::path name;  // relative to the directory
  std::filesystem::path file;  // links followed
};

// The file that a relative reference means. Writers that do not escape names, or separate folders
// by a backslash, are understood where such a file is there: after the name that the escapes stand
// for come the URI as it is, and both with "/" for "\". Absolute paths, other schemes (http:) and
// whatever lies outside the root are errors: a scene is not to read, say, a user's keys.
ResolvedUri resolve_uri(std::string_view uri, const ResourceFolder& folder,
                        const std::string& place);

}  // namespace emberline
