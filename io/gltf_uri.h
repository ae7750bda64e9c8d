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

// "a%20b" -> "a b". Throws InputError for a stray % and for %00.
std::string decode_percent(std::string_view text, const std::string& place);

// The file that a relative reference means. Absolute paths and other schemes (http:) are errors:
// a scene that needs them would render differently elsewhere.
std::filesystem::path resolve_uri(std::string_view uri, const std::filesystem::path& directory,
                                  const std::string& place);

}  // namespace emberline
