// Detects pictures of unfinished frames, and truncated files (from a full disk, an interrupted
// copy, a crash, or a power loss that left zeros).
//
// An EXR has the attribute "emberline:complete" (renderer/output/outputs.h). A PNG has a text of
// that name, and a JPEG a comment, but only if the frame is unfinished.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace emberline {

inline constexpr const char* kCompleteAttribute = "emberline:complete";
inline constexpr std::string_view kIncompleteComment = "emberline:complete=false";
inline constexpr std::string_view kIncompletePngText("emberline:complete\0false", 24);

// Does not read pixels. A picture without the mark counts as complete. Throws InputError for a
// missing file, or one that is not recognised as EXR, PNG or JPEG.
bool is_unfinished_image(const std::string& path);

// Returns the text attributes of an EXR's first header whose names begin with `prefix`; none for
// any other format. Does not read pixels. Throws InputError for a missing file.
std::vector<std::pair<std::string, std::string>> exr_texts(const std::string& path,
                                                           std::string_view prefix);

// Checks, without decoding pixels, that the file is not truncated. For an EXR, tests the offset
// table, and that the last chunk ends at the end of the file and not with zeros. For PNG and JPEG,
// tests the end marker; for GIF, tests the blocks. Returns false for deep EXRs, which we never
// write, and for any other format. Throws InputError for a missing file.
bool is_complete_file(const std::string& path);

}  // namespace emberline
