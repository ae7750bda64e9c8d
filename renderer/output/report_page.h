// The report as a page for people: --report FILE.html.
#pragma once

#include <string>
#include <string_view>

#include "renderer/output/render_options.h"
#include "renderer/output/report.h"
#include "renderer/output/report_pictures.h"

namespace emberline {

// Whether a report of that name is a page: its suffix is .html or .htm.
bool is_page(std::string_view path);

// One self-contained HTML file: picture, maps, histogram, charts, tables, and the command that
// renders the frame again. Throws RenderError for a picture that cannot be encoded.
std::string report_page(const RenderOptions& options, const RenderReport& report,
                        const ReportPictures& pictures);

}  // namespace emberline
