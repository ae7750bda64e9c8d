// The HTML page of a study, study.html, which is self-contained.
#pragma once

#include <string>
#include <vector>

#include "io/image/output.h"
#include "renderer/core/rect.h"
#include "renderer/statistics/html_page.h"
#include "renderer/statistics/study_results.h"

namespace emberline {

// Returns the page as one HTML file. Reads the pictures that `results` names from `folder` and
// skips missing ones. Throws RenderError for a picture that cannot be encoded.
std::string study_page(const StudyResults& results, const std::string& folder);

// Adds the parts of the page that show pictures: whole pictures, zoomed crops, FLIP maps and sample
// densities. Reads the files that `results` names from `folder` and skips missing or unreadable
// ones. Throws RenderError for a picture that cannot be encoded.
void add_study_pictures(HtmlPage& page, const StudyResults& results, const std::string& folder);

// Finds up to `count` disjoint squares of `side` x `side` pixels in which `picture` differs most
// from `reference`, measured by the squared differences of the bytes. Returns the square with the
// largest difference first. The pictures must have equal size (asserted).
std::vector<Rect> most_different_squares(const ByteImage& picture, const ByteImage& reference,
                                         int side, size_t count);

}  // namespace emberline
