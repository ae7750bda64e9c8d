// Detects pictures of unfinished frames, and truncated files (from a full disk, an interrupted
// copy, a crash, or a power loss that left zeros).
//
// EXR has the attribute "emberline:complete" (renderer/output/outputs.h), PNG a text of that name,
// JPEG a comment; PNG and JPEG only if it is "false".
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace emberline {

inline constexpr const char* kCompleteAttribute = "emberline:complete";
inline constexpr std::string_view kIncompleteComment = "emberline:complete=false";
inline constexpr std::string_view kIncompletePngText("emberline:complete\0false", 24);

// Reads no pixels. A picture without the mark counts as complete. Throws InputError for a missing
// file, or one that is not recognised as EXR, PNG or JPEG.
bool is_unfinished_image(const std::string& path);

// The text attributes of an EXR's first header whose names begin with `prefix`. Reads no pixels.
// Throws InputError for a missing file; anything that is no EXR has none.
std::vector<std::pair<std::string, std::string>> exr_texts(const std::string& path,
                                                           std::string_view prefix);

// Checks that the file reaches its end, without decoding pixels: EXR by its offset table and a last
// chunk that ends with the file and not in zeros, PNG and JPEG by their end, GIF by its blocks.
// False also for deep EXRs, which we never write, and for any other format. Throws InputError for a
// missing file.
bool is_complete_file(const std::string& path);

}  // namespace emberline
