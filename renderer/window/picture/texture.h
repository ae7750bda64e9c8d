// A picture on the graphics card: uploaded where it changed, drawn smooth or pixel by pixel.
#pragma once

#include <cstdint>
#include <vector>

namespace emberline {

// To be used with its OpenGL context current.
class PictureTexture {
 public:
  PictureTexture() = default;
  ~PictureTexture();
  PictureTexture(const PictureTexture&) = delete;
  PictureTexture& operator=(const PictureTexture&) = delete;

  // Rows from the top, four bytes a pixel. Memory on the card is kept while the size is.
  void upload(int width, int height, const std::vector<uint8_t>& rgba8);
  // Single pixels, instead of a smooth transition between them: drawn enlarged, or one to one.
  void show_pixels(bool pixels);

  bool empty() const { return width_ == 0; }
  int width() const { return width_; }
  int height() const { return height_; }
  void* id() const;  // an ImTextureID

 private:
  void set_filter() const;

  std::vector<uint32_t> words_;  // the picture in the card's order, while it is handed over
  unsigned name_ = 0;
  int width_ = 0, height_ = 0;
  bool pixels_ = false;
};

}  // namespace emberline
