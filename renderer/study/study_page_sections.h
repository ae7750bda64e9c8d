// The parts of a study's page that are made of its numbers alone. Each says so where there is
// nothing to show: no run finished, one seed, no reference of its own.
#pragma once

#include <string>

#include "renderer/charts/html_page.h"
#include "renderer/statistics/study_results.h"

namespace emberline {

// "8 s" or "64 spp".
std::string study_budget_text(const StudySettings& settings, double budget);

void add_study_warnings(HtmlPage& page, const StudyResults& results);     // stopped, failed
void add_study_speedups(HtmlPage& page, const StudyResults& results);     // against the baseline
void add_study_curves(HtmlPage& page, const StudyResults& results);       // charts and slopes
void add_study_errors(HtmlPage& page, const StudyResults& results);       // every metric; bias
void add_study_calibration(HtmlPage& page, const StudyResults& results);  // estimates and truth
void add_study_limits(HtmlPage& page, const StudyResults& results);       // Neyman; overhead
void add_study_runs(HtmlPage& page, const StudyResults& results);         // failed ones by name
void add_study_settings(HtmlPage& page, const StudyResults& results);     // reference, command

}  // namespace emberline
