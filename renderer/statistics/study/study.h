// Speed against error of several ways to render one frame: from warm-up to results.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "io/files/write_attempts.h"
#include "renderer/statistics/study/options.h"
#include "renderer/statistics/study_results.h"

namespace emberline {

// What a study has come to.
struct StudyOutcome {
  std::optional<StudyResults> results;  // none: stopped before there was a reference
  WriteAttempts attempts = {};
};

// Renders a study's reference, then its runs. `on_samples` is called from any thread. A run that
// fails is kept as failed; what a stop cuts short is left for the next start.
using RenderStudy =
    std::function<void(const std::function<void(uint64_t)>& on_samples, std::stop_token stop)>;

// Calls `render` once. `samples`: how many it will take; of runs that end by time a guess.
using StudyClient = std::function<void(uint64_t samples, const RenderStudy& render)>;

// A study from its options to its files, on `options.frame.threads` threads. `folder`: what the
// client calls the folder of the results. Throws UsageError, InputError and RenderError.
StudyOutcome make_study(const StudyOptions& options, const std::string& folder,
                        const StudyClient& client);

}  // namespace emberline
