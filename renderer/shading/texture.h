// A texture: a material slot's view of an image's texels, which keep their file's bit depth and are
// never copied. The texels are in memory, or in tiled order in a mapped file.
//
// A lookup fetches only one texel. It chooses one of the four neighbours with u_texture, so that
// the expected value is the bilinearly filtered value (Pharr, Wronski, Salvi & Fajardo 2024,
// "Filtering After Shading With Stochastic Texture Filtering"). This adds noise only where a
// texture is magnified. It costs a third as much as reading four texels, and at most a tenth as
// much as a cached texture system (figures in tests/bench/results). Normal maps are filtered before
// shading, with all four texels: otherwise a polished surface under a magnified map would show four
// reflections at once.
//
// uv may be huge, negative, NaN or infinite. NaN and infinite coordinates count as 0, except that
// +infinity with clamping counts as 1. Coordinates that are so large that float cannot resolve a
// texel read an arbitrary texel. All functions are const, pure and thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "renderer/core/mapped_texels.h"
#include "renderer/core/vector.h"
#include "renderer/description/scene_description.h"

namespace emberline {

// The four texels around a point, rows from the top, with their weights.
struct TexelCorners {
  int row[2], column[2];
  float right, below;  // weights of the second column and row
};

class Texture {
 public:
  // `srgb` tells whether the colour (not the alpha) of an image with integer texels is
  // sRGB-encoded. It is ignored for half and float images, which are linear. `image` must not be
  // empty and must hold width * height * channels texels (asserted).
  Texture(std::shared_ptr<const Image> image, const TextureRef& ref, bool srgb);

  // Returns one texel as linear rgba. Its mean over uniform u_texture in [0, 1) is bilinear(uv). If
  // channels are missing, grey is replicated and alpha is 1. Non-finite texels read as 0. `uv` is
  // the vertex attribute; KHR_texture_transform is applied here.
  Vec4f lookup(const Vec2f& uv, float u_texture) const { return read(place(uv, u_texture)); }

  // place() and read() are the two steps of lookup(), for callers that do many lookups at once:
  // find the texel's position, then read its value. Textures with same_parametrisation() have the
  // same positions.
  size_t place(const Vec2f& uv, float u_texture) const { return choose(corners(uv), u_texture); }
  size_t choose(const TexelCorners& corners, float u_texture) const;
  void prefetch(size_t place) const {
    if (mapped_) [[unlikely]]
      return mapped_->prefetch(place * texel_bytes_);
    __builtin_prefetch(texels_ + place * texel_bytes_);
  }
  Vec4f read(size_t place) const;

  // Returns the exactly filtered value of four texels. With nearest filtering, all four are the
  // same texel.
  Vec4f bilinear(const Vec2f& uv) const { return read(corners(uv)); }
  TexelCorners corners(const Vec2f& uv) const;
  void prefetch(const TexelCorners& corners) const {
    for (int row : corners.row) prefetch(place(corners.column[0], row));  // columns are adjacent
  }
  Vec4f read(const TexelCorners& corners) const;
  // Whether all texels are opaque. The search stops soon after the first texel that is not.
  bool is_opaque() const;
  // Returns only the alpha of bilinear(); 1 for an image without alpha.
  float bilinear_alpha(const Vec2f& uv) const;

  // Returns the mean colour over a triangle in uv, from the texels whose centres are inside. It
  // uses all of these texels if there are at most 4 Mi, otherwise a regular subset. If the triangle
  // covers only a few texels, it uses 16 filtered points instead. Deterministic; used for light
  // power.
  Rgb mean_over_triangle(const Vec2f& uv0, const Vec2f& uv1, const Vec2f& uv2) const;

  // Whether both textures use the same image in the same way.
  bool same_use(const Texture& other) const;
  // Whether the images have the same size and order of texels, and the same parametrisation (UV
  // set, transform, wrapping and filtering).
  bool same_parametrisation(const Texture& other) const;

  const Image& image() const { return *image_; }
  int uv_set() const { return uv_set_; }
  bool has_alpha_channel() const { return channels_ == 2 || channels_ == 4; }

  // The texel at (x, y) after decoding; 0 <= x < width, 0 <= y < height.
  Vec4f texel(int x, int y) const { return read(place(x, y)); }

 private:
  enum class Format : uint8_t { kByte, kWord, kWordSrgb, kHalf, kFloat };

  size_t place(int x, int y) const {
    if (mapped_) [[unlikely]]
      return tiled_index(width_, height_, x, y);
    return size_t(y) * size_t(width_) + size_t(x);
  }
  Vec2f transformed(const Vec2f& uv) const;
  // The two neighbours along one axis; `fraction` is the weight of the second.
  struct Taps {
    int first, second;
    float fraction;
  };
  Taps taps(float coordinate, int size, WrapMode wrap) const;
  float alpha_texel(int x, int y) const;
  template <typename Use>
  auto decoded(const Use& use) const;
  template <typename Load>
  Vec4f gather(size_t offset, const Load& load) const;

  std::shared_ptr<const Image> image_;
  const MappedTexels* mapped_;  // null if in memory
  const std::byte* texels_;
  const float* table_ = nullptr;  // decodes integer colour
  int width_, height_, channels_;
  size_t texel_bytes_;
  Format format_;
  WrapMode wrap_s_, wrap_t_;
  bool nearest_;
  bool has_transform_;
  int uv_set_;
  std::array<float, 6> transform_;
};

}  // namespace emberline
