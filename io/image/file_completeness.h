// Detects pictures of unfinished frames. Also detects truncated files (from a full disk, an
// interrupted copy, a crash, or a power loss that left zeros).
//
// An EXR has the attribute "emberline:complete" (renderer/output/outputs.h). If the frame is
// unfinished, a PNG has a text of that name, and a JPEG has a comment.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace emberline {

inline constexpr const char* kCompleteAttribute = "emberline:complete";
inline constexpr std::string_view kIncompleteComment = "emberline:complete=false";
inline constexpr std::string_view kIncompletePngText("emberline:complete\0false", 24);

// Whether the file's mark (see above) says that the frame is unfinished. A picture without a mark
// counts as finished. Does not read pixels. Throws InputError for a missing file, and for a file
// that is not recognised as EXR, PNG or JPEG.
bool is_unfinished_image(const std::string& path);

// Returns the text attributes of an EXR's first header whose names begin with `prefix`. For any
// other format, returns nothing. Does not read pixels. Throws InputError for a missing file.
std::vector<std::pair<std::string, std::string>> exr_texts(const std::string& path,
                                                           std::string_view prefix);

// Checks, without decoding pixels, that the file is not truncated. For an EXR, checks the offset
// table, and checks that the last chunk ends at the end of the file and does not end with zeros.
// For PNG and JPEG, looks for the end marker. For GIF, checks the blocks. Returns false for deep
// EXRs, which we never write, and for any other format. Throws InputError for a missing file.
bool is_complete_file(const std::string& path);

}  // namespace emberline
