#pragma once

#include "renderer/statistics/error_metrics.h"

namespace emberline::test {

inline RgbImage constant_picture(int width, int height, float r, float g, float b) {
  RgbImage image{width, height, {}};
  for (int i = 0; i < width * height; ++i) image.rgb.insert(image.rgb.end(), {r, g, b});
  return image;
}

}  // namespace emberline::test
