// Whether a picture's file was cut short: by a full disk, a copy that was broken off, a crash, or a
// loss of power that left zeros.
#pragma once

#include <string>

namespace emberline {

// Reads what proves that the file goes on to its end, and decodes no pixels: of an EXR the table of
// offsets, and that the last chunk ends with the file, and not in zeros; of a PNG and a JPEG the
// end, of a GIF the blocks. False also for deep EXRs, which are not ours, and for any other format.
// Throws InputError for a file that is not there.
bool is_whole_picture(const std::string& path);

}  // namespace emberline
