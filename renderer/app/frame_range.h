// The frames of a range: their numbers, and the options of each frame.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/output/render_options.h"

namespace emberline {

inline constexpr size_t kMaxFrames = 1'000'000;
inline constexpr int kLastFrame = 999'999'999;  // the first is -kLastFrame

// Parses "5", "1-100", "1-100x2" (1, 3, 5 ...), "100-1", "-10--1", and lists of these, such as
// "1-10,20,30-40x5". Keeps the given order and drops repeated numbers. Throws a UsageError that
// quotes the text and says what is valid.
std::vector<int> parse_frames(std::string_view text);
// Returns a short text that parse_frames() turns into the same list.
std::string format_frames(std::span<const int> frames);

// A run of '#' in a name is a placeholder for the frame number. expand_frame_number() replaces each
// run with the number, padded with zeros to the run's length: "shot.####.exr" becomes
// "shot.0007.exr" for frame 7, "shot.-007.exr" for -7 and "shot.12345.exr" for 12345.
bool has_frame_number(std::string_view name);
std::string expand_frame_number(std::string_view name, int frame);
// Throws UsageError, with an example, if the name has no frame number. `frames` is the option that
// requests several frames, such as "--frames".
void check_frame_number(std::string_view option, const std::string& path, std::string_view frames);
// Whether the name stands for several frames: it has a frame number, and no file has exactly this
// name.
bool is_sequence(const std::string& name);
// Returns the frame numbers of the existing files of this sequence, in ascending order. Throws
// UsageError if a folder in the name has a frame number, and InputError if there are no files or
// too many.
std::vector<int> existing_frames(const std::string& name);

// Throws RenderError if every frame would fail, because an output folder is not writable or
// --save-settings cannot be written. `first` is the number of the first frame. Does not check
// folders that have a frame number in their names.
void check_output_folders(const RenderOptions& options, int first);

// Returns the frames that the options request, or an empty list if the options describe a single
// frame. The options must have passed check_options(). Throws UsageError for an output that several
// frames would write.
std::vector<int> requested_frames(const RenderOptions& options);
// Returns the options for one of these frames.
RenderOptions options_of_frame(const RenderOptions& options, int frame);

}  // namespace emberline
