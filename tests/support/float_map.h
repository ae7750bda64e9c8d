// Creates a float image for environments. A function computes its texels.
#pragma once

#include <cstring>
#include <memory>
#include <vector>

#include "renderer/description/scene_description.h"

namespace emberline::test {

// texel(column, row) must return an Rgb. It is called row by row from the top.
template <class Texel>
std::shared_ptr<const Image> float_map(int width, int height, const Texel& texel) {
  auto image = std::make_shared<Image>();
  image->width = width;
  image->height = height;
  image->channels = 3;
  image->type = TexelType::kFloat;
  std::vector<Rgb> texels;
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) texels.push_back(texel(column, row));
  }
  image->texels.resize(texels.size() * sizeof(Rgb));
  std::memcpy(image->texels.data(), texels.data(), image->texels.size());
  return image;
}

}  // namespace emberline::test
