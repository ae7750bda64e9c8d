// Creates images that are embedded in scenes. They are encoded by our code, not by OpenImageIO.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "support/gltf_builder.h"

namespace emberline::test {

// Returns an RGB PNG of 2 x 2 pixels: red and green above, blue and white below.
std::vector<uint8_t> small_png();

// Adds a texture with an embedded image to `gltf`. Returns the texture's index.
int add_texture(GltfBuilder& gltf, const std::vector<uint8_t>& encoded,
                const std::string& media_type = "image/png");

}  // namespace emberline::test
