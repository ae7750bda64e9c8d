#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "renderer/description/scene_description.h"
#include "renderer/shading/material.h"

namespace emberline::test {

// Creates an image from bytes, which are in row order.
inline std::shared_ptr<Image> byte_image(int width, int height, int channels,
                                         const std::vector<uint8_t>& values) {
  auto image = std::make_shared<Image>();
  image->width = width;
  image->height = height;
  image->channels = channels;
  for (const uint8_t v : values) image->texels.push_back(std::byte(v));
  return image;
}

inline SurfaceAttributes at(float u, float v) {
  SurfaceAttributes a;
  a.uv.fill(Vec2f(u, v));
  return a;
}

inline TexelPositions texels_of(const Material& material, const SurfaceAttributes& a,
                                float u_texture) {
  TexelPositions texels;
  material.find_texels(a, u_texture, &texels);
  return texels;
}

inline MaterialPoint evaluated(const Material& material, const SurfaceAttributes& a,
                               float u_texture) {
  MaterialPoint point;
  material.evaluate(a, texels_of(material, a, u_texture), point);
  return point;
}

inline MaterialLayers evaluated_layers(const Material& material, const SurfaceAttributes& a,
                                       float u_texture) {
  MaterialLayers layers;
  material.evaluate_layers(texels_of(material, a, u_texture), layers);
  return layers;
}

}  // namespace emberline::test
