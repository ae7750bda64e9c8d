#include "renderer/window/picture/texture.h"

#define GLFW_INCLUDE_GLEXT  // some versions of gl.h end at OpenGL 1.1
#include <GLFW/glfw3.h>

namespace emberline {
namespace {

// Blue is in the lowest byte of a word. This is the native layout of graphics cards and windows, so
// drawing needs no conversion.
constexpr GLenum kFormat = GL_BGRA, kType = GL_UNSIGNED_INT_8_8_8_8_REV;

void convert(const std::vector<uint8_t>& rgba8, std::vector<uint32_t>& words) {
  words.resize(rgba8.size() / 4);
  for (size_t i = 0; i < words.size(); ++i) {
    const uint8_t* const in = &rgba8[4 * i];
    words[i] = uint32_t(in[3]) << 24 | uint32_t(in[0]) << 16 | uint32_t(in[1]) << 8 | in[2];
  }
}

}  // namespace

PictureTexture::~PictureTexture() {
  if (name_) glDeleteTextures(1, &name_);
}

void PictureTexture::upload(int width, int height, const std::vector<uint8_t>& rgba8) {
  if (!name_) glGenTextures(1, &name_);
  glBindTexture(GL_TEXTURE_2D, name_);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  convert(rgba8, words_);
  if (width == width_ && height == height_) {
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, width, height, kFormat, kType, words_.data());
    return;
  }
  // GL_RGBA lets the driver choose the layout. With GL_RGBA8, some drivers do not keep the byte
  // order of kFormat.
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, width, height, 0, kFormat, kType, words_.data());
  set_filter();
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  width_ = width;
  height_ = height;
}

void PictureTexture::set_pixelated(bool pixelated) {
  if (pixelated == is_pixelated_) return;
  is_pixelated_ = pixelated;
  if (!name_) return;
  glBindTexture(GL_TEXTURE_2D, name_);
  set_filter();
}

// Uses the same filter for minification and magnification, so that the driver need not distinguish
// them. Pictures drawn pixel by pixel are never minified.
void PictureTexture::set_filter() const {
  const GLint filter = is_pixelated_ ? GL_NEAREST : GL_LINEAR;
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
}

void* PictureTexture::id() const { return reinterpret_cast<void*>(uintptr_t(name_)); }

}  // namespace emberline
