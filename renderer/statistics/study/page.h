// The page of a study, study.html: self-contained, for people.
#pragma once

#include <string>

#include "renderer/statistics/study_results.h"

namespace emberline {

// The page as one HTML file. Pictures are read from the files that `results` names in `folder`; one
// that is missing is left out. Throws RenderError for a picture that cannot be encoded.
std::string study_page(const StudyResults& results, const std::string& folder);

}  // namespace emberline
