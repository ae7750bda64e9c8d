// Compares lookups with a naive implementation of the glTF specification.

#include "renderer/shading/texture.h"

#include <Imath/half.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "renderer/core/hash.h"
#include "renderer/shading/srgb.h"

namespace emberline {
namespace {

template <typename T>
std::shared_ptr<Image> make_image(int width, int height, int channels, TexelType type,
                                  const std::vector<T>& texels) {
  auto image = std::make_shared<Image>();
  image->width = width;
  image->height = height;
  image->channels = channels;
  image->type = type;
  image->texels.resize(texels.size() * sizeof(T));
  std::memcpy(image->texels.data(), texels.data(), image->texels.size());
  return image;
}

std::shared_ptr<Image> noise_image(int width, int height, int channels) {
  std::vector<float> texels(size_t(width * height * channels));
  for (size_t i = 0; i < texels.size(); ++i) texels[i] = to_unit_float(hash32(uint32_t(i) + 99));
  return make_image(width, height, channels, TexelType::kFloat, texels);
}

TextureRef wrapped(WrapMode s, WrapMode t) {
  TextureRef ref;
  ref.wrap_s = s;
  ref.wrap_t = t;
  return ref;
}

// Wraps one tap at a time, in integers.
int naive_wrap(int64_t i, int64_t n, WrapMode wrap) {
  if (wrap == WrapMode::kClampToEdge) return int(std::clamp<int64_t>(i, 0, n - 1));
  if (wrap == WrapMode::kRepeat) return int(((i % n) + n) % n);
  const int64_t m = ((i % (2 * n)) + 2 * n) % (2 * n);
  return int(m < n ? m : 2 * n - 1 - m);
}

Vec4f naive_bilinear(const Texture& texture, double u, double v, WrapMode s, WrapMode t) {
  const int w = texture.image().width, h = texture.image().height;
  const double x = u * w - 0.5, y = v * h - 0.5;
  const double fx = x - std::floor(x), fy = y - std::floor(y);
  Vec4f sum(0);
  for (int dy = 0; dy < 2; ++dy)
    for (int dx = 0; dx < 2; ++dx)
      sum += texture.texel(naive_wrap(int64_t(std::floor(x)) + dx, w, s),
                           naive_wrap(int64_t(std::floor(y)) + dy, h, t)) *
             float((dx ? fx : 1 - fx) * (dy ? fy : 1 - fy));
  return sum;
}

const WrapMode kModes[] = {WrapMode::kRepeat, WrapMode::kMirroredRepeat, WrapMode::kClampToEdge};

TEST(Texture, WrapsAndFiltersLikeTheNaiveForm) {
  for (const auto& [w, h] : {std::pair(5, 3), std::pair(1, 1), std::pair(8, 2)})
    for (const WrapMode s : kModes)
      for (const WrapMode t : kModes) {
        const Texture texture(noise_image(w, h, 3), wrapped(s, t), false);
        for (uint32_t i = 0; i < 2000; ++i) {
          const Vec2f uv(to_unit_float(hash32(2 * i)) * 7 - 3,
                         to_unit_float(hash32(2 * i + 1)) * 7 - 3);
          const Vec4f got = texture.bilinear(uv);
          const Vec4f want = naive_bilinear(texture, double(uv.x), double(uv.y), s, t);
          for (int c = 0; c < 4; ++c) ASSERT_NEAR(got[c], want[c], 2e-5) << uv.x << " " << uv.y;
        }
      }
}

TEST(Texture, StochasticLookupsAverageToBilinear) {
  for (const WrapMode mode : kModes) {
    const Texture texture(noise_image(6, 7, 4), wrapped(mode, mode), false);
    for (uint32_t k = 0; k < 40; ++k) {
      const Vec2f uv(to_unit_float(hash32(k)) * 3 - 1, to_unit_float(hash32(k + 1000)) * 3 - 1);
      Vec4f sum(0);
      const int n = 1 << 14;  // stratified: the two choices flip at three points of [0, 1)
      for (int i = 0; i < n; ++i) sum += texture.lookup(uv, (float(i) + .5f) / n);
      const Vec4f want = texture.bilinear(uv);
      for (int c = 0; c < 4; ++c) EXPECT_NEAR(sum[c] / n, want[c], 8.0 / n);
    }
  }
}

TEST(Texture, NearestTakesTheTexelUnderThePoint) {
  TextureRef ref;
  ref.nearest = true;
  const Texture texture(noise_image(4, 4, 3), ref, false);
  for (uint32_t i = 0; i < 500; ++i) {
    const Vec2f uv(to_unit_float(hash32(i)), to_unit_float(hash32(i + 7777)));
    const Vec4f want = texture.texel(int(uv.x * 4), int(uv.y * 4));
    EXPECT_EQ(texture.lookup(uv, .37f), want);
    EXPECT_EQ(texture.bilinear(uv), want);
  }
}

TEST(Texture, DecodesEveryFormat) {
  const std::vector<uint8_t> bytes = {0, 64, 128, 255};
  const Texture color(make_image(1, 1, 4, TexelType::kUint8, bytes), {.image = 0}, true);
  const Texture data(make_image(1, 1, 4, TexelType::kUint8, bytes), {.image = 0}, false);
  for (int c = 0; c < 4; ++c) {
    const double encoded = bytes[size_t(c)] / 255.0;
    EXPECT_NEAR(data.texel(0, 0)[c], encoded, 1e-6);
    EXPECT_NEAR(color.texel(0, 0)[c], c == 3 ? encoded : srgb_to_linear(encoded), 1e-6);
  }
  const std::vector<uint16_t> words = {0, 1000, 40000, 65535};
  const Texture words_color(make_image(1, 1, 4, TexelType::kUint16, words), {.image = 0}, true);
  const Texture words_data(make_image(1, 1, 4, TexelType::kUint16, words), {.image = 0}, false);
  for (int c = 0; c < 4; ++c) {
    const double encoded = words[size_t(c)] / 65535.0;
    EXPECT_NEAR(words_data.texel(0, 0)[c], encoded, 1e-6);
    EXPECT_NEAR(words_color.texel(0, 0)[c], c == 3 ? encoded : srgb_to_linear(encoded), 1e-6);
  }
  const std::vector<uint16_t> halves = {Imath::half(2.5f).bits(), Imath::half(-1.0f).bits(), 0x7c00,
                                        0x7e00};
  const Texture half(make_image(1, 1, 4, TexelType::kHalf, halves), {.image = 0}, true);
  EXPECT_EQ(half.texel(0, 0), Vec4f(2.5f, -1, 0, 0));  // infinity and NaN read as 0
  const std::vector<float> floats = {1e30f, -std::numeric_limits<float>::infinity()};
  const Texture grey(make_image(1, 1, 2, TexelType::kFloat, floats), {.image = 0}, true);
  EXPECT_EQ(grey.texel(0, 0), Vec4f(1e30f, 1e30f, 1e30f, 0));
}

TEST(Texture, MissingChannelsAreGreyAndOpaque) {
  for (int channels = 1; channels <= 4; ++channels) {
    const std::vector<uint8_t> bytes = {51, 102, 153, 204};
    const Texture t(make_image(1, 1, channels, TexelType::kUint8,
                               std::vector<uint8_t>(bytes.begin(), bytes.begin() + channels)),
                    {.image = 0}, false);
    const Vec4f want = channels == 1   ? Vec4f(.2f, .2f, .2f, 1)
                       : channels == 2 ? Vec4f(.2f, .2f, .2f, .4f)
                       : channels == 3 ? Vec4f(.2f, .4f, .6f, 1)
                                       : Vec4f(.2f, .4f, .6f, .8f);
    for (int c = 0; c < 4; ++c) EXPECT_NEAR(t.lookup(Vec2f(.5f), .5f)[c], want[c], 1e-6);
    EXPECT_NEAR(t.bilinear_alpha(Vec2f(.5f)), want.w, 1e-6);
  }
}

TEST(Texture, SrgbTablesFollowTheCurve) {
  for (int i = 0; i < 256; ++i) {
    const double e = i / 255.0;
    const double want = e <= 0.04045 ? e / 12.92 : std::pow((e + 0.055) / 1.055, 2.4);
    EXPECT_NEAR(double(srgb8_table()[size_t(i)]), want, 1e-7);
    EXPECT_NEAR(double(srgb16_table()[size_t(i * 257)]), want, 1e-7);
  }
}

TEST(Texture, ExtremeCoordinatesAreDefined) {
  const float inf = std::numeric_limits<float>::infinity();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float values[] = {0,     -0.f,   1,     -1,     1e-30f, -1e-9f, 0.99999994f,
                          1e10f, -1e10f, 3e38f, -3e38f, inf,    -inf,   nan};
  TextureRef refs[4];
  for (int i = 0; i < 3; ++i) refs[i] = wrapped(kModes[i], kModes[i]);
  refs[3].uv_transform = {1e30f, 1e30f, 3e38f, -1e30f, 0, inf};
  for (TextureRef ref : refs)
    for (const bool nearest : {false, true})
      for (const float u : values)
        for (const float v : values) {
          ref.nearest = nearest;
          const Texture texture(noise_image(3, 5, 3), ref, false);
          for (const float r : {0.0f, 0.5f, 0.99999994f})
            for (const Vec4f& got : {texture.lookup({u, v}, r), texture.bilinear({u, v})})
              for (int c = 0; c < 3; ++c) ASSERT_TRUE(got[c] >= 0 && got[c] <= 1) << u << " " << v;
          const Rgb mean = texture.mean_over_triangle({u, v}, {v, u}, {0, 1});
          ASSERT_TRUE(mean.x >= 0 && mean.x <= 1) << u << " " << v;
        }
}

TEST(Texture, TransformIsApplied) {
  TextureRef ref;
  ref.uv_transform = {0, 2, .25f, -3, 0, .5f};
  const Texture plain(noise_image(16, 16, 3), TextureRef{}, false);
  const Texture transformed(noise_image(16, 16, 3), ref, false);
  for (uint32_t i = 0; i < 100; ++i) {
    const Vec2f uv(to_unit_float(hash32(i)), to_unit_float(hash32(i + 100)));
    const Vec4f a = transformed.bilinear(uv), b = plain.bilinear({2 * uv.y + .25f, .5f - 3 * uv.x});
    EXPECT_NEAR(a.x, b.x, 1e-5);
  }
  EXPECT_FALSE(plain.same_use(transformed));
}

// A single lit texel is found wherever it is, because the mean is over texels and not over sample
// points.
TEST(Texture, TriangleMeanSeesEveryTexel) {
  const int n = 512;
  std::vector<float> texels(size_t(n * n));
  texels[size_t(300 * n + 77)] = 1000;
  const Texture texture(make_image(n, n, 1, TexelType::kFloat, texels), {.image = 0}, false);
  const Rgb a = texture.mean_over_triangle({0, 0}, {1, 0}, {0, 1});
  const Rgb b = texture.mean_over_triangle({1, 1}, {1, 0}, {0, 1});
  EXPECT_NEAR(a.x, 2 * 1000.0 / (n * n), 1e-4);  // 377 < 512: the texel is in the first half
  EXPECT_EQ(b.x, 0);
  // The triangle covers half of 3 x 3 tiles, has the other winding order and is shifted by whole
  // tiles.
  const Rgb tiled = texture.mean_over_triangle({-3, 0}, {-3, 3}, {0, 0});
  EXPECT_NEAR(tiled.x, 1000.0 / (n * n), 1000.0 / (n * n) * 0.4);  // 3 or 6 whole tiles of 4.5
  // A small triangle uses filtered points.
  const Texture noise(noise_image(8, 8, 3), TextureRef{}, false);
  const Vec2f p(.3f, .4f);
  const Rgb point = noise.mean_over_triangle(p, p, p);
  EXPECT_NEAR(point.x, noise.bilinear(p).x, 1e-5);
}

// The triangle is a sliver with hardly any area, along a row of about 1e9 texels.
TEST(Texture, TriangleMeanOfASliver) {
  const Texture texture(noise_image(1024, 1, 3), TextureRef{}, false);
  const Rgb along = texture.mean_over_triangle({0, .5f}, {878900, .5f}, {0, .5000001f});
  const Rgb whole = texture.mean_over_triangle({0, 0}, {1, 0}, {0, 1});
  EXPECT_GT(along.x, 0.3f * whole.x);
  EXPECT_LT(along.x, 3.0f * whole.x);
}

template <typename T>
void expect_finds_texel(TexelType type, T opaque, T nearly) {
  for (const int channels : {1, 2, 3, 4}) {
    std::vector<T> texels(size_t(90 * 100 * channels), opaque);
    const auto is_opaque = [&] {
      return Texture(make_image(90, 100, channels, type, texels), TextureRef{}, false).is_opaque();
    };
    EXPECT_TRUE(is_opaque());
    for (const size_t texel : {0, 5000, 8999}) {
      T& last = texels[(texel + 1) * size_t(channels) - 1];
      last = nearly;
      EXPECT_EQ(is_opaque(), channels % 2 == 1) << channels << ", " << texel;
      last = opaque;
    }
  }
}

TEST(Texture, OneTexelMakesItSeeThrough) {
  expect_finds_texel<uint8_t>(TexelType::kUint8, 255, 254);
  expect_finds_texel<uint16_t>(TexelType::kUint16, 65535, 65534);
  expect_finds_texel<float>(TexelType::kFloat, 1.0f, 0.999f);
}

// Returns the image in the layout of a memory-mapped file.
std::shared_ptr<Image> in_tiles(const Image& image) {
  auto tiled = std::make_shared<Image>(image);
  const size_t texel = size_t(image.byte_count()) / size_t(image.width) / size_t(image.height);
  const auto bytes = std::make_shared<std::vector<std::byte>>(image.texels.size());
  const std::byte* from = image.texels.data();
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x, from += texel) {
      std::copy_n(from, texel, &(*bytes)[texel * tiled_index(image.width, image.height, x, y)]);
    }
  }
  tiled->texels.clear();
  tiled->mapped = std::make_shared<MappedTexels>(
      std::shared_ptr<const std::byte>(bytes, bytes->data()), bytes->size());
  return tiled;
}

TEST(TiledTexels, EachTexelHasOnePlace) {
  EXPECT_EQ(tiled_index(40, 35, 33, 34), size_t(32 * 40 + 3 * 32 + 2 * 8 + 1));
  for (const auto& [width, height] :
       {std::pair{1, 1}, {1, 70}, {70, 1}, {32, 32}, {33, 31}, {40, 35}, {64, 96}, {127, 65}}) {
    std::vector<bool> taken(size_t(width * height));
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const size_t place = tiled_index(width, height, x, y);
        ASSERT_LT(place, taken.size()) << width << " x " << height << ": " << x << ", " << y;
        ASSERT_FALSE(taken[place]) << width << " x " << height << ": " << x << ", " << y;
        taken[place] = true;
      }
    }
  }
}

TEST(Texture, TilesAreReadAsRowsAre) {
  for (const int channels : {1, 2, 3, 4}) {
    const auto image = noise_image(70, 45, channels);
    for (const WrapMode wrap :
         {WrapMode::kRepeat, WrapMode::kMirroredRepeat, WrapMode::kClampToEdge}) {
      const Texture rows(image, wrapped(wrap, wrap), false);
      const Texture tiles(in_tiles(*image), wrapped(wrap, wrap), false);
      EXPECT_FALSE(rows.same_parametrisation(tiles));
      for (uint32_t i = 0; i < 4000; ++i) {
        const Vec2f uv = {4.0f * to_unit_float(hash32(3 * i)) - 2.0f,
                          4.0f * to_unit_float(hash32(3 * i + 1)) - 2.0f};
        const float u = to_unit_float(hash32(3 * i + 2));
        ASSERT_EQ(rows.lookup(uv, u), tiles.lookup(uv, u)) << i;
        ASSERT_EQ(rows.bilinear(uv), tiles.bilinear(uv)) << i;
        ASSERT_EQ(rows.bilinear_alpha(uv), tiles.bilinear_alpha(uv)) << i;
      }
    }
  }
}

}  // namespace
}  // namespace emberline
