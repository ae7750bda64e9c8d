// `--light-groups`: each light's contribution as EXR layers, for relighting in compositing.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "renderer/film/channels.h"
#include "renderer/scene/light_groups.h"

namespace emberline {

class FilmTile;

// Returns a layer name per group: "light." and its name. EXR separates layers by full stops and
// compositors use the names as identifiers, so every character except ASCII letters, digits, '-'
// and '_' becomes '_'. Empty or duplicate names get a number.
std::vector<std::string> light_layer_names(std::span<const LightGroup> groups);

// Returns .R .G .B of each layer; with `denoising`, followed by those of each half as
// half1.light.NAME.
std::vector<std::string> light_channel_names(const std::vector<std::string>& layers,
                                             const AovSet& aovs);

// Writes the values of these channels for pixel i of the tile and returns the end.
float* put_light_layers(const FilmTile& tile, size_t i, float* values);

// For the report, such as "light groups (2: key, environment)".
std::string describe(const LightGroups& groups);

}  // namespace emberline
