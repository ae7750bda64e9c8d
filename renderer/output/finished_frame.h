// --skip-existing: finds out whether a frame is already finished.
#pragma once

#include <string>

#include "renderer/output/render_options.h"

namespace emberline {

// True if all pictures, heatmaps, trees and reports that the options name exist, are not truncated
// (file_completeness.h) and do not come from a stopped frame (pictures and JSON reports record
// whether they are "complete"). Snapshots that exist must be intact, and no checkpoint may be
// waiting to be resumed. Does not compare settings.
bool is_finished(const RenderOptions& options);

// Says why a finished frame is skipped: "all its outputs exist". If one of them is an EXR that was
// rendered with other settings (RecordedSettings::changes()), adds ", but a.exr has other settings:
// `spp` 64 (now 256)". PNG and JPEG files do not store settings, and a changed scene, environment
// or edits file is not noticed.
std::string skip_reason(const RenderOptions& options);

}  // namespace emberline
