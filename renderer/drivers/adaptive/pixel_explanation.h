// Says in words and tables why a pixel of the adaptive driver got its samples.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "renderer/drivers/adaptive/refinement_tree.h"
#include "renderer/drivers/adaptive/round_planner.h"
#include "renderer/film/pixel_stop.h"

namespace emberline {

// What the driver knows about one pixel.
struct PixelHistory {
  std::span<const RoundRecord> rounds;
  int recorded_since = 0;             // the rounds before this one were not recorded
  float threshold = 0.0f;             // 0: none
  uint32_t samples = 0;               // at present
  float error = 0.0f;                 // at the last update
  std::optional<PixelStop> end = {};  // absent: the frame goes on
};

// One sentence and a line break; empty if nothing has been decided yet: "At 64 samples its error
// was 0.034 (threshold 0.02), so its target was 256 samples; at 256 it was 0.015 and the pixel was
// finished."
std::string describe_history(const PixelHistory& history);

// The tables, each with the meaning of its columns.
std::string rounds_table(const PixelHistory& history);
std::string tree_table(std::span<const RefinementNode> path);

}  // namespace emberline
