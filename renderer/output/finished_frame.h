// --skip-existing: finds out whether a frame is already finished.
#pragma once

#include <string>

#include "renderer/output/render_options.h"

namespace emberline {

// Returns true if every picture, heatmap, tree and report that the options name exists, is not
// truncated (file_completeness.h) and does not come from a stopped frame. (Pictures and JSON
// reports record whether they are "complete".) In addition, existing snapshots must be intact, and
// there must be no checkpoint to resume. Does not compare settings.
bool is_finished(const RenderOptions& options);

// Says why a finished frame is skipped: "all its outputs exist". If one of them is an EXR that was
// rendered with other settings (RecordedSettings::changes()), adds ", but a.exr has other settings:
// `spp` 64 (now 256)". Cannot check PNG and JPEG files, which do not store settings. Does not
// notice a changed scene, environment or edits file.
std::string skip_reason(const RenderOptions& options);

}  // namespace emberline
