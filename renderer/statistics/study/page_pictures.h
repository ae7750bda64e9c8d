// The parts of a study's page that show its pictures: whole, in zoomed crops, as FLIP maps, and
// where the samples went.
#pragma once

#include <string>
#include <vector>

#include "io/image/output.h"
#include "renderer/core/rect.h"
#include "renderer/statistics/html_page.h"
#include "renderer/statistics/study_results.h"

namespace emberline {

// Reads the files that `results` names in `folder`; what is missing or cannot be read is left out.
// Throws RenderError for a picture that cannot be encoded.
void add_study_pictures(HtmlPage& page, const StudyResults& results, const std::string& folder);

// At most `count` squares of `side` pixels in which `picture` differs most from `reference` (mean
// square of the bytes), none overlapping another, the worst first. Sizes equal (asserted).
std::vector<Rect> most_different_squares(const ByteImage& picture, const ByteImage& reference,
                                         int side, size_t count);

}  // namespace emberline
