// Formats the files of a study: the results as CSV and JSON, and each finished run, so that the
// study can be resumed.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/json/reader.h"
#include "renderer/statistics/study_results.h"

namespace emberline {

// Returns a row for each checkpoint and for each failed run. The columns are frame (only if it is
// given), method, driver, estimator, allocation, unbiased, denoised, sampler, seed, status, reason,
// budget, samples, mean_samples, the name of each metric, signed_bias, estimate, wall_s, cpu_s,
// filter_cpu_s, kept_share. Numbers have enough digits to be read back exactly. Missing values are
// empty.
std::string study_csv(const StudyResults& results, std::optional<int> frame = {});

// Returns all results and, under "summary", each method's statistics (study_summary.h).
std::string study_json(const StudyResults& results);

// Returns a table for the terminal. It shows each method's error, slope, speedup and overhead at
// the largest budget.
std::string study_table(const StudyResults& results);

// Returns a text with a line for each row, in which each column is as wide as its widest cell. The
// first row must have a cell for each column.
std::string aligned_table(const std::vector<std::vector<std::string>>& rows);

// Convert a finished run to JSON and back. `key` identifies everything that the run depends on.
// parse_run() throws InputError if the run is damaged or has another key. The method's index is not
// saved.
std::string run_json(const StudyRun& run, std::string_view key);
StudyRun parse_run(const JsonReader& root, std::string_view key);

}  // namespace emberline
