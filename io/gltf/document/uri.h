// URIs as glTF uses them (specification section 2.8): data URIs and relative references.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace emberline {

bool is_data_uri(std::string_view uri);

// Decodes the payload of "data:[media type][;parameter=value...][;base64],...", whatever the media
// type. Throws InputError at `place` if the URI is malformed.
std::vector<uint8_t> decode_data_uri(std::string_view uri, const std::string& place);

// Where a scene's files are: their names are relative to `directory`, and the files lie inside
// `root`.
struct ResourceFolder {
  std::filesystem::path directory, root;
};

struct ResolvedUri {
  std::filesystem::path name;  // relative to the directory
  std::filesystem::path file;  // with links followed
};

// Finds the file of a relative reference. Tries the name that the URI's escapes encode, then the
// URI unchanged, then both with "/" for "\", so that it also finds names that a writer did not
// escape or wrote with backslashes. Absolute paths, other schemes (http:) and files outside the
// root are errors, so that a scene cannot read, for example, a user's keys.
ResolvedUri resolve_uri(std::string_view uri, const ResourceFolder& folder,
                        const std::string& place);

}  // namespace emberline
