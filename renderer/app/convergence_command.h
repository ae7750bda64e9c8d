// emberline study --convergence: how fast the samples alone converge, without a scene.
#pragma once

#include "renderer/statistics/study/options.h"

namespace emberline {

// Prints a table, and writes convergence.csv and convergence.json if there is a folder. Throws
// UsageError, RenderError.
int run_convergence(const StudyOptions& options);

}  // namespace emberline
