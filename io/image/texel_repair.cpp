#include "io/image/texel_repair.h"

#include <Imath/half.h>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>

#include "renderer/core/parallel.h"

namespace emberline {
namespace {

// A half has 1 sign bit, 5 exponent bits and 10 mantissa bits. A float has 1, 8 and 23. This code
// works on the bits, so that no build flag can disable the NaN test.
template <class Bits>
uint64_t repair_range(Bits* begin, Bits* end, TexelRange range) {
  constexpr Bits kExponent = sizeof(Bits) == 2 ? Bits(0x7C00u) : Bits(0x7F800000u);
  constexpr Bits kSign = sizeof(Bits) == 2 ? Bits(0x8000u) : Bits(0x80000000u);
  uint64_t count = 0;
  for (Bits* bits = begin; bits != end; ++bits) {
    const bool non_finite = (*bits & kExponent) == kExponent;
    const bool negative = (*bits & kSign) != 0 && *bits != kSign;
    if (non_finite || (negative && range == TexelRange::kRadiance)) {
      *bits = 0;
      ++count;
    }
  }
  return count;
}

template <class Bits>
uint64_t repair_all(Image& image, TexelRange range) {
  Bits* texels = reinterpret_cast<Bits*>(image.texels.data());
  const size_t count = image.texels.size() / sizeof(Bits);
  std::atomic<uint64_t> repaired{0};
  parallel_ranges(count, size_t(1) << 16, [&](size_t begin, size_t end) {
    repaired.fetch_add(repair_range(texels + begin, texels + end, range),
                       std::memory_order_relaxed);
  });
  return repaired.load();
}

// `scale` is the stored number that stands for 1.
template <class T>
void unpremultiply_all(Image& image, float scale) {
  T* texels = reinterpret_cast<T*>(image.texels.data());
  const size_t channels = size_t(image.channels);
  const size_t pixels = size_t(image.width) * size_t(image.height);
  for (T* pixel = texels; pixel != texels + pixels * channels; pixel += channels) {
    const float alpha = float(pixel[channels - 1]) / scale;
    if (!(alpha > 0.0f)) continue;
    for (size_t c = 0; c + 1 < channels; ++c) {
      const float value = float(pixel[c]) / alpha;
      pixel[c] = std::is_integral_v<T> ? T(std::min(value + 0.5f, scale)) : T(value);
    }
  }
}

template <class T>
void convert_all(Image& image, const ColourMatrix& matrix) {
  T* texels = reinterpret_cast<T*>(image.texels.data());
  const auto max_value = float(std::numeric_limits<T>::max());
  parallel_ranges(image.texels.size() / sizeof(T) / 3, size_t(1) << 14,
                  [&](size_t begin, size_t end) {
                    for (T* texel = texels + 3 * begin; texel != texels + 3 * end; texel += 3) {
                      const Rgb from{float(texel[0]), float(texel[1]), float(texel[2])};
                      const Rgb to = matrix * from;
                      const float rounding = -1e-3f * max_component(from);
                      for (int c = 0; c < 3; ++c) {
                        const float value = to[c] < 0.0f && to[c] > rounding ? 0.0f : to[c];
                        texel[c] = T(std::clamp(value, -max_value, max_value));
                      }
                    }
                  });
}

}  // namespace

void convert_primaries(Image& image, const ColourMatrix& matrix) {
  image.type == TexelType::kHalf ? convert_all<Imath::half>(image, matrix)
                                 : convert_all<float>(image, matrix);
}

void unpremultiply(Image& image) {
  switch (image.type) {
    case TexelType::kUint8:
      return unpremultiply_all<uint8_t>(image, 255.0f);
    case TexelType::kUint16:
      return unpremultiply_all<uint16_t>(image, 65535.0f);
    case TexelType::kHalf:
      return unpremultiply_all<Imath::half>(image, 1.0f);
    case TexelType::kFloat:
      return unpremultiply_all<float>(image, 1.0f);
  }
}

uint64_t repair_texels(Image& image, TexelRange range) {
  if (image.type == TexelType::kHalf) return repair_all<uint16_t>(image, range);
  if (image.type == TexelType::kFloat) return repair_all<uint32_t>(image, range);
  return 0;
}

void expand_grey(Image& image) {
  const size_t size = image.type == TexelType::kUint8 ? 1 : image.type == TexelType::kFloat ? 4 : 2;
  const size_t count = size_t(image.width) * size_t(image.height);
  std::vector<std::byte> expanded(count * 3 * size);
  for (size_t i = 0; i < count * 3; ++i) {
    std::memcpy(&expanded[i * size], &image.texels[i / 3 * size], size);
  }
  image.texels = std::move(expanded);
  image.channels = 3;
}

float srgb_to_linear(float encoded) {
  if (encoded <= 0.04045f) return encoded / 12.92f;
  return float(std::pow((double(encoded) + 0.055) / 1.055, 2.4));
}

}  // namespace emberline
