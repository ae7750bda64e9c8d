#include "io/exr_file.h"

namespace emberline {

void write_exr_crop(ExrWriter& writer, const ExrHeader& header, std::span<const float> values) {
  const Rect& crop = header.data_window;
  const size_t channels = header.channels.size();
  const int size = header.tile_size;
  std::vector<float> pixels;
  for (int y = crop.y0; y < crop.y1; y += size) {
    for (int x = crop.x0; x < crop.x1; x += size) {
      const Rect tile = Rect{x, y, x + size, y + size}.intersect(crop);
      pixels.clear();
      for (int row = tile.y0; row < tile.y1; ++row) {
        const std::span<const float> line =
            values.subspan(crop.index_of(tile.x0, row) * channels, size_t(tile.width()) * channels);
        pixels.insert(pixels.end(), line.begin(), line.end());
      }
      writer.write_tile(tile, pixels);
    }
  }
}

void write_exr_file(const std::string& path, const ExrHeader& header,
                    std::span<const float> values) {
  ExrWriter writer(path, header);
  write_exr_crop(writer, header, values);
  writer.finish();
}

}  // namespace emberline
