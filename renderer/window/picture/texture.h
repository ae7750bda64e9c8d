// The texture of a picture, which can be drawn with interpolation or pixel by pixel.
#pragma once

#include <cstdint>
#include <vector>

namespace emberline {

// The window's OpenGL context must be current.
class PictureTexture {
 public:
  PictureTexture() = default;
  ~PictureTexture();
  PictureTexture(const PictureTexture&) = delete;
  PictureTexture& operator=(const PictureTexture&) = delete;

  // `rgba8` has four bytes per pixel, top row first. Reuses the texture's memory while the size
  // stays the same.
  void upload(int width, int height, const std::vector<uint8_t>& rgba8);
  // `pixelated` switches interpolation off, for enlarged pixels or a scale of 1:1.
  void set_pixelated(bool pixelated);

  bool empty() const { return width_ == 0; }
  void* id() const;  // an ImTextureID

 private:
  void set_filter() const;

  std::vector<uint32_t> words_;  // the picture in the graphics card's byte order
  unsigned name_ = 0;
  int width_ = 0, height_ = 0;
  bool is_pixelated_ = false;
};

}  // namespace emberline
