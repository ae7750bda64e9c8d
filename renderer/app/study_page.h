// The page of a study, study.html: self-contained, for people.
#pragma once

#include <string>

#include "renderer/statistics/study_results.h"

namespace emberline {

// Writes FOLDER/study.html, which appears whole or not at all. Pictures are read from the files
// that `results` names in that folder; one that is missing is left out. Throws RenderError.
void write_study_page(const StudyResults& results, const std::string& folder);

}  // namespace emberline
