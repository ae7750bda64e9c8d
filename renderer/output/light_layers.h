// `--light-groups`: what each light gave as layers of the EXR, for compositors who change lights
// after the render.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "renderer/film/channels.h"
#include "renderer/scene/light_groups.h"

namespace emberline {

class FilmTile;

// A layer for each group: "light." and its name. EXR parts layers by full stops, and compositors
// make identifiers of their names, so all but ASCII letters, digits, '-' and '_' becomes '_'. A
// name that is empty or taken gets a number.
std::vector<std::string> light_layer_names(std::span<const LightGroup> groups);

// The channels of these layers: .R .G .B of each; with the halves of `denoising` those of each half
// behind them, as half1.light.NAME.
std::vector<std::string> light_channel_names(const std::vector<std::string>& layers,
                                             const AovSet& aovs);

// Writes the values of these of the tile's pixel i; returns the end.
float* put_light_layers(const FilmTile& tile, size_t i, float* values);

// "light groups (2: key, environment)", for the report.
std::string describe(const LightGroups& groups);

}  // namespace emberline
