#include "renderer/app/rgb_file.h"

#include <fmt/format.h>

#include <array>

#include "io/image_input.h"
#include "renderer/core/errors.h"

namespace emberline {

RgbImage read_rgb(const std::string& path) {
  const FloatImage file = read_float_image(path);
  std::array<size_t, 3> source{};
  for (size_t c = 0; c < 3; ++c) {
    const int found = file.find_channel(std::string(1, "RGB"[c]));
    if (found < 0) {
      std::string names;
      for (const std::string& name : file.channel_names)
        names += (names.empty() ? "" : ", ") + name;
      throw InputError(
          path, fmt::format("{} x {} pixels, but no channels R, G and B to compare; it has {}",
                            file.width, file.height, names));
    }
    source[c] = size_t(found);
  }
  const size_t pixels = size_t(file.width) * size_t(file.height);
  RgbImage image{file.width, file.height, std::vector<float>(3 * pixels)};
  for (size_t i = 0; i < pixels; ++i) {
    for (size_t c = 0; c < 3; ++c) {
      image.rgb[3 * i + c] = file.values[i * size_t(file.channels()) + source[c]];
    }
  }
  return image;
}

}  // namespace emberline
