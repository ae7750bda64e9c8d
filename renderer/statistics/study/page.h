// The page of a study, study.html: self-contained, for people.
#pragma once

#include <string>
#include <vector>

#include "io/image/output.h"
#include "renderer/core/rect.h"
#include "renderer/statistics/html_page.h"
#include "renderer/statistics/study_results.h"

namespace emberline {

// The page as one HTML file. Pictures are read from the files that `results` names in `folder`; one
// that is missing is left out. Throws RenderError for a picture that cannot be encoded.
std::string study_page(const StudyResults& results, const std::string& folder);

// The parts that show pictures: whole, in zoomed crops, as FLIP maps, and where the samples went.
// Reads the files that `results` names in `folder`; what is missing or cannot be read is left out.
// Throws RenderError for a picture that cannot be encoded.
void add_study_pictures(HtmlPage& page, const StudyResults& results, const std::string& folder);

// At most `count` squares of `side` pixels in which `picture` differs most from `reference` (mean
// square of the bytes), none overlapping another, the worst first. Sizes equal (asserted).
std::vector<Rect> most_different_squares(const ByteImage& picture, const ByteImage& reference,
                                         int side, size_t count);

}  // namespace emberline
