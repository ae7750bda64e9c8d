// Studies of several frames of an animation, and what they say together.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "renderer/core/load_progress.h"
#include "renderer/statistics/study_results.h"

namespace emberline {

// The study of one frame. All studies of a range have the same methods and budgets (asserted).
struct FrameStudy {
  int frame = 0;
  std::string folder;  // of the study
  StudyResults results;
  // For each method, the flicker (flicker.h) between its picture of this frame and that of the
  // next. NaN if it is unknown.
  std::vector<double> flicker;
};

// Sets `flicker` of `frame`. `next` must be the study of the next frame. Reads the pictures of the
// largest budget and the first seed, and the references, which must have the layer `velocity`.
// Throws InputError if a picture cannot be read.
void measure_flicker(FrameStudy& frame, const FrameStudy& next, const LoadLimits& limits);

// These functions return all results in one file or one table. There must be at least one study.
// Summaries are about the largest budget.

// Returns the rows of study_csv() for all frames.
std::string study_range_csv(std::span<const FrameStudy> studies);
// Returns {"frames": [{"frame", "folder", "methods": [{"method", "relmse_trimmed", "speedup",
// "flicker"}]}], "summary": [{"method", "relmse_trimmed", "speedup", "flicker"}]}. The speedup is
// in processor time at equal relmse_trimmed, against the baseline. Each value in the summary has
// the keys "median", "mean", "least" and "largest", or is null if no frame has it.
std::string study_range_json(std::span<const FrameStudy> studies);
// Returns a table for the terminal.
std::string study_range_table(std::span<const FrameStudy> studies);
// Returns the same as a self-contained HTML page, with charts. `command_line` repeats all studies.
std::string study_range_page(std::span<const FrameStudy> studies, const std::string& command_line);

}  // namespace emberline
