// Formats the files of a study: the results as CSV and JSON, and each finished run, for resuming.
#pragma once

#include <string>
#include <string_view>

#include "io/json/reader.h"
#include "renderer/statistics/study_results.h"

namespace emberline {

// Returns one row for each checkpoint, and one for each failed run. Columns: method, driver,
// estimator, allocation, unbiased, sampler, seed, status, reason, budget, samples, mean_samples,
// the metrics by their names, signed_bias, estimate, wall_s, cpu_s. Numbers can be read back
// exactly; missing values are empty.
std::string study_csv(const StudyResults& results);

// Returns all results and, under "summary", the statistics of study_summary.h for each method.
std::string study_json(const StudyResults& results);

// A table for the terminal: each method's error, slope, speedup and overhead at the largest budget.
std::string study_table(const StudyResults& results);

// Save and load a finished run. `key` identifies everything that the run depends on; parse_run()
// throws InputError for a damaged run or another key. The method's index is not saved.
std::string run_json(const StudyRun& run, std::string_view key);
StudyRun parse_run(const JsonReader& root, std::string_view key);

}  // namespace emberline
