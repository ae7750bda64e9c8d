// `--light-groups`: writes the contribution of each light group as an EXR layer, for relighting in
// compositing.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "renderer/film/channels.h"
#include "renderer/scene/light_groups.h"

namespace emberline {

class FilmTile;

// Returns a layer name for each group: "light." and the group's name. In the group's name, every
// character except ASCII letters, digits, '-' and '_' becomes '_', because full stops separate the
// layers of an EXR and compositors use layer names as identifiers. Empty or duplicate names get a
// number.
std::vector<std::string> light_layer_names(std::span<const LightGroup> groups);

// Returns the channels .R, .G and .B of each layer. If `aovs` contains `denoising`, also returns
// those of each half, such as half1.light.NAME.R.
std::vector<std::string> light_channel_names(const std::vector<std::string>& layers,
                                             const AovSet& aovs);

// Writes the values of light_channel_names() for pixel i of the tile to `values`, and returns the
// position after them.
float* put_light_layers(const FilmTile& tile, size_t i, float* values);

// Returns text for the report, such as "light groups (2: key, environment)".
std::string describe(const LightGroups& groups);

}  // namespace emberline
