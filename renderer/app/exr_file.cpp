#include "renderer/app/exr_file.h"

namespace emberline {

void write_exr_window(ExrWriter& writer, const ExrHeader& header, std::span<const float> values) {
  const Rect& window = header.data_window;
  const size_t channels = header.channels.size();
  const int size = header.tile_size;
  std::vector<float> pixels;
  for (int y = window.y0; y < window.y1; y += size) {
    for (int x = window.x0; x < window.x1; x += size) {
      const Rect tile = Rect{x, y, x + size, y + size}.intersect(window);
      pixels.clear();
      for (int row = tile.y0; row < tile.y1; ++row) {
        const std::span<const float> line = values.subspan(window.index_of(tile.x0, row) * channels,
                                                           size_t(tile.width()) * channels);
        pixels.insert(pixels.end(), line.begin(), line.end());
      }
      writer.write_tile(tile, pixels);
    }
  }
}

void write_exr_file(const std::string& path, const ExrHeader& header,
                    std::span<const float> values) {
  ExrWriter writer(path, header);
  write_exr_window(writer, header, values);
  writer.finish();
}

}  // namespace emberline
