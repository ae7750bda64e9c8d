// Creates images that are embedded in scenes, with our own encoder.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "support/gltf_builder.h"

namespace emberline::test {

// A 2 x 2 RGB PNG: red, green / blue, white.
std::vector<uint8_t> small_png();

// Adds a texture with an embedded image to `gltf`; returns the texture's index.
int add_texture(GltfBuilder& gltf, const std::vector<uint8_t>& encoded,
                const std::string& media_type = "image/png");

}  // namespace emberline::test
