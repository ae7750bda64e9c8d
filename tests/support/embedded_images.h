// Images in scenes, made by our own writer.
#pragma once

#include "io/image/output.h"
#include "support/gltf_builder.h"

namespace emberline::test {

// A 2 x 2 RGB PNG: red, green / blue, white.
inline std::vector<uint8_t> small_png() {
  const ByteImage image{2, 2, 3, {255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255}};
  return emberline::encode_image(image, "png", "small.png");
}

// A texture of an embedded image in `gltf`; returns the texture's index.
inline int add_texture(GltfBuilder& gltf, const std::vector<uint8_t>& encoded,
                       const std::string& media_type = "image/png") {
  const int image =
      gltf.push("images", {{"bufferView", gltf.add_view(encoded)}, {"mimeType", media_type}});
  return gltf.push("textures", {{"source", image}});
}

}  // namespace emberline::test
