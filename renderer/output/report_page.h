// The report as an HTML page: --report FILE.html.
#pragma once

#include <string>
#include <string_view>

#include "renderer/output/render_options.h"
#include "renderer/output/report.h"
#include "renderer/output/report_pictures.h"

namespace emberline {

// True for the suffixes .html and .htm.
bool is_page(std::string_view path);

// Returns a self-contained HTML file with the picture, maps, a histogram, charts, tables, and the
// command that renders the frame again. Throws RenderError if a picture cannot be encoded.
std::string report_page(const RenderOptions& options, const RenderReport& report,
                        const ReportPictures& pictures);

}  // namespace emberline
