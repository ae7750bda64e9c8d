#include "support/embedded_images.h"

#include <nlohmann/json.hpp>

#include "io/image/output.h"

namespace emberline::test {

std::vector<uint8_t> small_png() {
  const ByteImage image{2, 2, 3, {255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255}};
  return emberline::encode_image(image, "png", "small.png");
}

int add_texture(GltfBuilder& gltf, const std::vector<uint8_t>& encoded,
                const std::string& media_type) {
  const int image =
      gltf.push("images", {{"bufferView", gltf.add_view(encoded)}, {"mimeType", media_type}});
  return gltf.push("textures", {{"source", image}});
}

}  // namespace emberline::test
