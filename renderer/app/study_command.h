// emberline study: speed against error of several ways to render one frame.
#pragma once

#include "renderer/statistics/study/options.h"

namespace emberline {

// Renders, measures and writes study.csv, study.json, study.html and pictures into the folder. A
// study that was stopped goes on where it was when the same command is given again.
//
// Returns kExitDone, also where some runs have failed: they are shown as failed; kExitRenderFailed
// if all have; kExitStopped after a signal. Throws UsageError, InputError, RenderError before any
// long work for whatever is wrong with the options.
int run_study(const StudyOptions& options);

}  // namespace emberline
