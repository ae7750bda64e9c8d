// What a picture says of its frame: that it was stopped before it was complete.
//
// EXR has the attribute "emberline:complete" (renderer/output/outputs.h), PNG a text of that name,
// JPEG a comment; the last two only where it is "false".
#pragma once

#include <string>
#include <string_view>

namespace emberline {

inline constexpr const char* kCompleteAttribute = "emberline:complete";
inline constexpr std::string_view kIncompleteComment = "emberline:complete=false";
inline constexpr std::string_view kIncompletePngText("emberline:complete\0false", 24);

// Reads no pixels. A picture that says nothing is complete. Throws InputError for a file that is
// not there, or is none of the three as far as it was looked at.
bool is_marked_incomplete(const std::string& path);

}  // namespace emberline
