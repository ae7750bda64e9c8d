#include "renderer/output/flip_picture.h"

#include <cmath>

#include "io/image/output.h"
#include "renderer/statistics/colour_map.h"

namespace emberline {

void write_flip_picture(const std::string& path, const RgbImage& image,
                        const std::vector<float>& flip, const std::vector<uint8_t>& masked) {
  ByteImage picture;
  picture.width = image.width;
  picture.height = image.height;
  picture.values.reserve(3 * flip.size());
  for (size_t i = 0; i < flip.size(); ++i) {
    const Rgb8 colour = colour_of(ColourMap::kMagma, masked[i] ? NAN : double(flip[i]));
    picture.values.insert(picture.values.end(), colour.begin(), colour.end());
  }
  write_image(path, picture);
}

}  // namespace emberline
