#include "renderer/shading/texture.h"

#include <Imath/half.h>

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstring>

#include "renderer/core/branch_free.h"
#include "renderer/shading/srgb.h"

namespace emberline {

namespace {

constexpr std::array<float, 6> kNoTransform = {1, 0, 0, 0, 1, 0};

// The image readers replace texels that are not finite. This is a second guard, so that no such
// texel can corrupt a path.
float finite_or_zero(float x) { return std::isfinite(x) ? x : 0.0f; }

template <typename T>
T load_texel(const std::byte* texels, size_t index) {
  T value;
  std::memcpy(&value, texels + index * sizeof(T), sizeof(T));
  return value;
}

float half_to_float(uint16_t bits) {
  Imath::half h;
  h.setBits(bits);
  return float(h);
}

// Folds a texture coordinate into [0, 1]. NaN and infinity become 0, except that clamping makes
// +infinity 1.
float fold(float c, WrapMode wrap) {
  switch (wrap) {
    case WrapMode::kRepeat:
      c -= std::floor(c);
      break;
    case WrapMode::kMirroredRepeat:
      c -= 2.0f * std::floor(0.5f * c);
      c = c > 1.0f ? 2.0f - c : c;
      break;
    case WrapMode::kClampToEdge:
      break;
  }
  return c > 0.0f ? std::min(c, 1.0f) : 0.0f;
}

}  // namespace

Texture::Texture(std::shared_ptr<const Image> image, const TextureRef& ref, bool srgb)
    : image_(std::move(image)),
      mapped_(image_->mapped.get()),
      texels_(mapped_ ? mapped_->data() : image_->texels.data()),
      width_(image_->width),
      height_(image_->height),
      channels_(image_->channels),
      wrap_s_(ref.wrap_s),
      wrap_t_(ref.wrap_t),
      nearest_(ref.nearest),
      has_transform_(ref.uv_transform != kNoTransform),
      uv_set_(ref.uv_set),
      transform_(ref.uv_transform) {
  assert(width_ > 0 && height_ > 0 && channels_ >= 1 && channels_ <= 4);
  size_t bytes = 1;
  switch (image_->type) {
    case TexelType::kUint8:
      format_ = Format::kByte;
      table_ = srgb ? srgb8_table().data() : linear8_table().data();
      break;
    case TexelType::kUint16:
      format_ = srgb ? Format::kWordSrgb : Format::kWord;
      if (srgb) table_ = srgb16_table().data();
      bytes = 2;
      break;
    case TexelType::kHalf:
      format_ = Format::kHalf;
      bytes = 2;
      break;
    case TexelType::kFloat:
      format_ = Format::kFloat;
      bytes = 4;
      break;
  }
  texel_bytes_ = size_t(channels_) * bytes;
  assert(image_->mapped || image_->texels.size() == image_->byte_count());
}

bool Texture::same_use(const Texture& o) const {
  return image_ == o.image_ && table_ == o.table_ && format_ == o.format_ &&
         same_parametrisation(o);
}

bool Texture::same_parametrisation(const Texture& o) const {
  return width_ == o.width_ && height_ == o.height_ && wrap_s_ == o.wrap_s_ &&
         wrap_t_ == o.wrap_t_ && nearest_ == o.nearest_ && !mapped_ == !o.mapped_ &&
         uv_set_ == o.uv_set_ && transform_ == o.transform_;
}

Vec2f Texture::transformed(const Vec2f& uv) const {
  if (!has_transform_) return uv;
  const auto& m = transform_;
  return {fma(m[0], uv.x, fma(m[1], uv.y, m[2])), fma(m[3], uv.x, fma(m[4], uv.y, m[5]))};
}

// Texel i's centre is at (i + 0.5) / size.
Texture::Taps Texture::taps(float coordinate, int size, WrapMode wrap) const {
  const float folded = fold(coordinate, wrap);
  if (nearest_) {
    const int i = std::min(int(folded * float(size)), size - 1);
    return {i, i, 0.0f};
  }
  const float shifted = fma(folded, float(size), -0.5f);
  const float lower = std::floor(shifted);
  int first = int(lower);  // [-1, size - 1]
  int second = first + 1;  // [0, size]
  // Mirroring reflects about the edge, so the texel beyond the edge is the edge texel, as it is
  // with clamping.
  const bool repeat = wrap == WrapMode::kRepeat;
  if (first < 0) first = repeat ? size - 1 : 0;
  if (second >= size) second = repeat ? 0 : size - 1;
  return {first, second, shifted - lower};
}

template <typename Load>
Vec4f Texture::gather(size_t offset, const Load& load) const {
  switch (channels_) {
    case 1: {
      const float grey = load.color(offset);
      return {grey, grey, grey, 1.0f};
    }
    case 2: {
      const float grey = load.color(offset);
      return {grey, grey, grey, load.alpha(offset + 1)};
    }
    case 3:
      return {load.color(offset), load.color(offset + 1), load.color(offset + 2), 1.0f};
    default:
      return {load.color(offset), load.color(offset + 1), load.color(offset + 2),
              load.alpha(offset + 3)};
  }
}

namespace {

struct LoadByte {
  const std::byte* texels;
  const float* table;
  float color(size_t i) const { return table[uint8_t(texels[i])]; }
  float alpha(size_t i) const { return float(uint8_t(texels[i])) * (1.0f / 255.0f); }
};
struct LoadWord {
  const std::byte* texels;
  float color(size_t i) const { return alpha(i); }
  float alpha(size_t i) const { return float(load_texel<uint16_t>(texels, i)) * (1.0f / 65535.0f); }
};
struct LoadWordSrgb {
  const std::byte* texels;
  const float* table;
  float color(size_t i) const { return table[load_texel<uint16_t>(texels, i)]; }
  float alpha(size_t i) const { return LoadWord{texels}.alpha(i); }
};
struct LoadHalf {
  const std::byte* texels;
  float color(size_t i) const {
    return finite_or_zero(half_to_float(load_texel<uint16_t>(texels, i)));
  }
  float alpha(size_t i) const { return color(i); }
};
struct LoadFloat {
  const std::byte* texels;
  float color(size_t i) const { return finite_or_zero(load_texel<float>(texels, i)); }
  float alpha(size_t i) const { return color(i); }
};

}  // namespace

template <typename Use>
auto Texture::decoded(const Use& use) const {
  switch (format_) {
    case Format::kByte:
      return use(LoadByte{texels_, table_});
    case Format::kWord:
      return use(LoadWord{texels_});
    case Format::kWordSrgb:
      return use(LoadWordSrgb{texels_, table_});
    case Format::kHalf:
      return use(LoadHalf{texels_});
    case Format::kFloat:
      break;
  }
  return use(LoadFloat{texels_});
}

Vec4f Texture::read(size_t place) const {
  return decoded([&](const auto& load) { return gather(place * size_t(channels_), load); });
}

size_t Texture::choose(const TexelCorners& corners, float u_texture) const {
  // One number chooses both the column and the row: after the first choice, the rescaled remainder
  // is uniform again.
  const bool right = u_texture < corners.right;
  const float rest = (u_texture - select(right, 0.0f, corners.right)) /
                     select(right, corners.right, 1.0f - corners.right);
  const bool below = rest < corners.below;
  return place(select(right, corners.column[1], corners.column[0]),
               select(below, corners.row[1], corners.row[0]));
}

TexelCorners Texture::corners(const Vec2f& uv) const {
  const Vec2f at = transformed(uv);
  const Taps s = taps(at.x, width_, wrap_s_);
  const Taps t = taps(at.y, height_, wrap_t_);
  return {{t.first, t.second}, {s.first, s.second}, s.fraction, t.fraction};
}

Vec4f Texture::read(const TexelCorners& c) const {
  return decoded([&](const auto& load) {
    const auto texel = [&](int x, int y) { return gather(place(x, y) * size_t(channels_), load); };
    const auto across = [&](int row) {
      return fma(texel(c.column[1], row), c.right, texel(c.column[0], row) * (1.0f - c.right));
    };
    return fma(across(c.row[1]), c.below, across(c.row[0]) * (1.0f - c.below));
  });
}

float Texture::alpha_texel(int x, int y) const {
  const size_t i = (place(x, y) + 1) * size_t(channels_) - 1;
  return decoded([&](const auto& load) { return load.alpha(i); });
}

bool Texture::is_opaque() const {
  if (!has_alpha_channel()) return true;
  const size_t count = size_t(width_) * size_t(height_), channels = size_t(channels_);
  return decoded([&](const auto& load) {
    constexpr size_t kBlock = 4096;
    for (size_t begin = 0; begin < count; begin += kBlock) {
      bool opaque = true;
      for (size_t i = begin; i < std::min(count, begin + kBlock); ++i) {
        opaque &= load.alpha((i + 1) * channels - 1) >= 1.0f;
      }
      if (!opaque) return false;
    }
    return true;
  });
}

float Texture::bilinear_alpha(const Vec2f& uv) const {
  if (!has_alpha_channel()) return 1.0f;
  const TexelCorners c = corners(uv);
  const auto across = [&](int row) {
    return lerp(alpha_texel(c.column[0], row), alpha_texel(c.column[1], row), c.right);
  };
  return lerp(across(c.row[0]), across(c.row[1]), c.below);
}

}  // namespace emberline
