// The frames of a range: their numbers, and what of the options is each one's own.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/output/render_options.h"

namespace emberline {

inline constexpr size_t kMostFrames = 1'000'000;
inline constexpr int kLastFrame = 999'999'999;  // and the first is as far below 0

// "5", "1-100", "1-100x2" (1, 3, 5 ...), "100-1", "-10--1", and lists of those: "1-10,20,30-40x5".
// In the order in which they stand there, each once. Throws UsageError: the text, what is valid.
std::vector<int> parse_frames(std::string_view text);
// The same in few words, for which parse_frames gives the same.
std::string frames_text(std::span<const int> frames);

// Every run of '#' is the frame's number, with zeros in front as long as the run: of frame 7
// "shot.####.exr" is "shot.0007.exr", of frame -7 "shot.-007.exr", of 12345 "shot.12345.exr".
bool is_numbered(std::string_view name);
std::string numbered(std::string_view name, int frame);

// Throws RenderError for a folder that takes no file of any frame, or for --save-settings that
// cannot be written: each frame would fail for it. Folders with a frame's number are not checked.
void check_output_folders(const RenderOptions& options, int first);

// The frames that the options, which check_options() has passed, ask for; none: one frame, which is
// what the options say. Throws UsageError for an output that each of them would write.
std::vector<int> frames_of(const RenderOptions& options);
// What is left to be said of one of them.
RenderOptions options_of_frame(const RenderOptions& options, int frame);

}  // namespace emberline
