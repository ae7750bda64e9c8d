// URIs as glTF uses them (specification section 2.8): data URIs and relative references.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace emberline {

bool is_data_uri(std::string_view uri);

// Decodes the payload of "data:[media type][;parameter=value...][;base64],...". Accepts any media
// type. Throws InputError at `place` if the URI is malformed.
std::vector<uint8_t> decode_data_uri(std::string_view uri, const std::string& place);

// The folders of a scene's files. File names are relative to `directory`, and all files lie inside
// `root`.
struct ResourceFolder {
  std::filesystem::path directory, root;
};

struct ResolvedUri {
  std::filesystem::path name;  // relative to the directory
  std::filesystem::path file;  // with symbolic links resolved
};

// Finds the file of a relative reference. Tries the percent-decoded name, then the URI unchanged,
// then both with "/" instead of "\". So it also finds names that a writer did not escape or wrote
// with backslashes. Absolute paths, other schemes (http:) and files outside the root are errors. So
// a scene cannot read, for example, a user's keys.
ResolvedUri resolve_uri(std::string_view uri, const ResourceFolder& folder,
                        const std::string& place);

}  // namespace emberline
