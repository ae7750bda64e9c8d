// What a picture says of its frame, that it was stopped before it was complete; and whether its
// file was cut short: by a full disk, a copy that was broken off, a crash, or a loss of power that
// left zeros.
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

// Reads what proves that the file goes on to its end, and decodes no pixels: of an EXR the table of
// offsets, and that the last chunk ends with the file, and not in zeros; of a PNG and a JPEG the
// end, of a GIF the blocks. False also for deep EXRs, which are not ours, and for any other format.
// Throws InputError for a file that is not there.
bool is_whole_picture(const std::string& path);

}  // namespace emberline
