// A session's picture as files.
#pragma once

#include <string>

#include "renderer/session/view_frame.h"

namespace emberline {

// .exr: all channels, linear. .png, .jpg: as `display` shows it, a .png with alpha if the
// environment is transparent. Appears whole or not at all. Throws UsageError for another suffix,
// RenderError.
void write_picture(const std::string& path, const FilmCopy& film, const DisplaySettings& display);

// A heatmap with its legend (.png, .jpg), or its values (.exr). Throws UsageError for an overlay
// that is none of a quantity, RenderError where the film lacks its channel.
void write_heatmap(const std::string& path, const FilmCopy& film, ViewOverlay overlay);

// Throws UsageError for an overlay that is none of a quantity.
const HeatmapQuantity& heatmap_of(ViewOverlay overlay);

}  // namespace emberline
