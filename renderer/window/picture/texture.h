// A picture's texture, drawn with interpolation or pixel by pixel.
#pragma once

#include <cstdint>
#include <vector>

namespace emberline {

// Use with its OpenGL context current.
class PictureTexture {
 public:
  PictureTexture() = default;
  ~PictureTexture();
  PictureTexture(const PictureTexture&) = delete;
  PictureTexture& operator=(const PictureTexture&) = delete;

  // Four bytes per pixel, top row first. Texture memory is reused while the size stays the same.
  void upload(int width, int height, const std::vector<uint8_t>& rgba8);
  // Disables interpolation: for enlarged pixels, or one to one.
  void set_pixelated(bool pixelated);

  bool empty() const { return width_ == 0; }
  int width() const { return width_; }
  int height() const { return height_; }
  void* id() const;  // an ImTextureID

 private:
  void set_filter() const;

  std::vector<uint32_t> words_;  // the picture in the card's byte order
  unsigned name_ = 0;
  int width_ = 0, height_ = 0;
  bool is_pixelated_ = false;
};

}  // namespace emberline
