// Explains in words and tables why a pixel of the adaptive driver got its samples.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "renderer/drivers/adaptive/refinement_tree.h"
#include "renderer/drivers/adaptive/round_planner.h"
#include "renderer/film/pixel_stop.h"

namespace emberline {

// Everything that the driver knows about one pixel.
struct PixelHistory {
  std::span<const RoundRecord> rounds;
  int recorded_since = 0;  // the rounds before this one were not recorded
  float threshold = 0.0f;  // 0: none
  const JudgedChannels* judged = nullptr;
  uint32_t samples = 0;               // present number of samples
  float error = 0.0f;                 // error at the last update
  std::optional<PixelStop> end = {};  // absent: the frame is not finished
};

// Returns one sentence and a line break, or an empty text if there was no decision yet. Example:
// "At 64 samples its error was 0.034 (threshold 0.02), so its target was 256 samples; at 256 it was
// 0.015, so the pixel was finished."
std::string describe_history(const PixelHistory& history);

// Returns one line with the errors of all judged channels, or an empty text if only R G B are
// judged.
std::string judged_errors(const JudgedChannels& judged);

// Both functions return a table, followed by an explanation of its columns.
std::string rounds_table(const PixelHistory& history);
std::string tree_table(std::span<const RefinementNode> path);

}  // namespace emberline
