// Tests image decoding (depth, alpha, odd formats, bombs), environments, and images for comparison.
#include "io/image/input.h"

#include <Imath/half.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "io/display/working_space.h"
#include "io/exr/writer.h"
#include "renderer/core/errors.h"
#include "renderer/core/hash.h"
#include "support/embedded_images.h"
#include "support/encoded_images.h"

namespace emberline {
namespace {

using OIIO::ImageSpec;
using OIIO::TypeDesc;
using test::TempFolder;

std::shared_ptr<const Image> decode(const std::vector<uint8_t>& encoded,
                                    uint64_t* non_finite = nullptr) {
  const DecodedImage decoded = decode_image(encoded, "place");
  if (non_finite) *non_finite += decoded.non_finite;
  return decoded.image;
}

template <class T>
std::vector<T> texels(const Image& image) {
  std::vector<T> values(image.texels.size() / sizeof(T));
  std::memcpy(values.data(), image.texels.data(), image.texels.size());
  return values;
}

std::string message_of(const std::vector<uint8_t>& encoded) {
  try {
    decode(encoded);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(ImageInput, PngKeepsDepthChannelsAndUnmultipliedAlpha) {
  ImageSpec rgba(2, 1, 4, TypeDesc::UINT8);
  rgba.attribute("oiio:UnassociatedAlpha", 1);
  const auto image =
      decode(test::encode_image<uint8_t>("png", rgba, {200, 100, 50, 0, 10, 20, 30, 128}));
  EXPECT_EQ(image->name, "place");
  EXPECT_EQ(image->width, 2);
  EXPECT_EQ(image->height, 1);
  EXPECT_EQ(image->channels, 4);
  EXPECT_EQ(texels<uint8_t>(*image), (std::vector<uint8_t>{200, 100, 50, 0, 10, 20, 30, 128}));

  const auto deep = decode(
      test::encode_image<uint16_t>("png", ImageSpec(1, 1, 3, TypeDesc::UINT16), {1, 256, 65535}));
  EXPECT_EQ(deep->type, TexelType::kUint16);
  EXPECT_EQ(texels<uint16_t>(*deep), (std::vector<uint16_t>{1, 256, 65535}));

  const auto grey =
      decode(test::encode_image<uint8_t>("png", ImageSpec(2, 2, 1, TypeDesc::UINT8), {1, 2, 3, 4}));
  EXPECT_EQ(grey->channels, 1);
  EXPECT_EQ(texels<uint8_t>(*grey), (std::vector<uint8_t>{1, 2, 3, 4}));
}

TEST(ImageInput, JpegInColourAndGrey) {
  const auto color = decode(test::encode_image<uint8_t>("jpg", ImageSpec(8, 8, 3, TypeDesc::UINT8),
                                                        std::vector<uint8_t>(8 * 8 * 3, 120)));
  EXPECT_EQ(color->channels, 3);
  EXPECT_NEAR(texels<uint8_t>(*color)[0], 120, 2);
  const auto grey = decode(test::encode_image<uint8_t>("jpg", ImageSpec(8, 8, 1, TypeDesc::UINT8),
                                                       std::vector<uint8_t>(8 * 8, 120)));
  EXPECT_EQ(grey->channels, 1);
}

// OpenImageIO's writer would premultiply, so libwebp made these 38 bytes. They are lossless and
// hold 4 x 4 pixels of (200, 100, 50) with alpha 128.
TEST(ImageInput, WebpWithAlphaIsNotPremultiplied) {
  const std::vector<uint8_t> webp = {0x52, 0x49, 0x46, 0x46, 0x1e, 0x00, 0x00, 0x00, 0x57, 0x45,
                                     0x42, 0x50, 0x56, 0x50, 0x38, 0x4c, 0x11, 0x00, 0x00, 0x00,
                                     0x2f, 0x03, 0xc0, 0x00, 0x10, 0x07, 0x50, 0xb2, 0x22, 0x57,
                                     0xa6, 0x80, 0x81, 0x88, 0xe8, 0x7f, 0x00, 0x00};
  const auto image = decode(webp);
  EXPECT_EQ(image->channels, 4);
  const auto read = texels<uint8_t>(*image);
  EXPECT_NEAR(read[0], 200, 1);
  EXPECT_NEAR(read[1], 100, 1);
  EXPECT_NEAR(read[2], 50, 1);
  EXPECT_EQ(read[3], 128);
}

TEST(ImageInput, FloatImagesAreRepairedAndCounted) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  uint64_t count = 0;
  const auto image = decode(test::encode_image<float>("exr", ImageSpec(2, 1, 3, TypeDesc::FLOAT),
                                                      {1, nan, -2, inf, -inf, 1e30f}),
                            &count);
  EXPECT_EQ(image->type, TexelType::kFloat);
  EXPECT_EQ(count, 3u);
  EXPECT_EQ(texels<float>(*image), (std::vector<float>{1, 0, -2, 0, 0, 1e30f}));
  const auto half =
      decode(test::encode_image<float>("exr", ImageSpec(1, 1, 3, TypeDesc::HALF), {1, 0.5f, 2}));
  EXPECT_EQ(half->type, TexelType::kHalf);
  EXPECT_EQ(half->texels.size(), 6u);
  const auto hdr = decode(test::encode_image<float>("hdr", ImageSpec(16, 1, 3, TypeDesc::FLOAT),
                                                    std::vector<float>(16 * 3, 4.0f)));
  EXPECT_EQ(hdr->type, TexelType::kFloat);
  EXPECT_NEAR(texels<float>(*hdr)[0], 4.0f, 0.05f);
}

TEST(ImageInput, NonImagesAreRefused) {
  EXPECT_NE(message_of({}).find("place: the image is empty"), std::string::npos);
  EXPECT_NE(message_of({1, 2, 3}).find("not PNG, JPEG, WebP"), std::string::npos);
  const std::vector<uint8_t> png = test::small_png();
  for (const char* suffix : {"png", "jpg", "webp", "exr", "hdr"}) {
    const bool is_float = std::string(suffix) == "exr" || std::string(suffix) == "hdr";
    const ImageSpec spec(16, 16, 3, is_float ? TypeDesc::FLOAT : TypeDesc::UINT8);
    const std::vector<uint8_t> whole =
        is_float ? test::encode_image<float>(suffix, spec, std::vector<float>(16 * 16 * 3, 0.5f))
                 : test::encode_image<uint8_t>(suffix, spec, std::vector<uint8_t>(16 * 16 * 3, 77));
    ASSERT_EQ(message_of(whole), "no error") << suffix;
    const std::vector<uint8_t> head(whole.begin(), whole.begin() + 16);
    const std::string message = message_of(head);
    EXPECT_EQ(message.rfind("place: ", 0), 0u) << suffix << ": " << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

// A PNG header with impossible dimensions must fail before memory is allocated.
TEST(ImageInput, DecompressionBombsAreRefused) {
  std::vector<uint8_t> png = test::small_png();
  const auto announce = [&](uint32_t width, uint32_t height) {
    for (int i = 0; i < 4; ++i) {
      png[16 + size_t(i)] = uint8_t(width >> (24 - 8 * i));
      png[20 + size_t(i)] = uint8_t(height >> (24 - 8 * i));
    }
    // The CRC-32 of the IHDR chunk (type and 13 bytes), which libpng checks.
    uint32_t crc = 0xffffffffu;
    for (size_t i = 12; i < 29; ++i) {
      crc ^= png[i];
      for (int k = 0; k < 8; ++k) crc = crc & 1 ? 0xedb88320u ^ (crc >> 1) : crc >> 1;
    }
    crc = ~crc;
    for (int i = 0; i < 4; ++i) png[29 + size_t(i)] = uint8_t(crc >> (24 - 8 * i));
    return png;
  };
  const std::string message = message_of(announce(60000, 60000));
  EXPECT_NE(message.find("60000 x 60000 pixels do not fit into"), std::string::npos) << message;
  EXPECT_NE(message_of(announce(70000, 1)).find("too large"), std::string::npos);
  EXPECT_NE(message_of(announce(0, 5)), "no error");
}

TEST(ReadEnvironment, HdrIsFloatExrKeepsHalf) {
  const TempFolder folder;
  test::write_image<float>(folder / "a.hdr", ImageSpec(16, 8, 3, TypeDesc::FLOAT),
                           std::vector<float>(16 * 8 * 3, 2.0f));
  uint64_t repaired = 0;
  auto image = read_environment(folder / "a.hdr", &repaired);
  EXPECT_EQ(image->type, TexelType::kFloat);
  EXPECT_EQ(image->channels, 3);
  EXPECT_EQ(image->width, 16);
  EXPECT_EQ(repaired, 0u);

  std::vector<float> values(16 * 8 * 4, 1.0f);
  values[0] = 65504.0f;
  test::write_image<float>(folder / "a.exr", ImageSpec(16, 8, 4, TypeDesc::HALF), values);
  image = read_environment(folder / "a.exr", &repaired);
  EXPECT_EQ(image->type, TexelType::kHalf);
  EXPECT_EQ(image->channels, 3);  // alpha is dropped
  EXPECT_EQ(image->texels.size(), size_t(16 * 8 * 3 * 2));
  EXPECT_EQ(float(texels<Imath::half>(*image)[0]), 65504.0f);
}

// The reader reads several tiles at a time, so that a load can be cancelled in between.
TEST(ReadFloatImage, RowsOfManyTiles) {
  const TempFolder folder;
  ImageSpec spec(4000, 300, 3, TypeDesc::FLOAT);
  spec.tile_width = spec.tile_height = 256;
  std::vector<float> values(size_t(4000) * 300 * 3);
  for (size_t i = 0; i < values.size(); ++i) values[i] = float(i % 8191);
  test::write_image(folder / "tiled.exr", spec, values);
  EXPECT_EQ(read_float_image(folder / "tiled.exr").values, values);
  test::write_image(folder / "tiled.tif", spec, values);
  EXPECT_EQ(read_float_image(folder / "tiled.tif").values, values);
}

TEST(ReadEnvironment, TiledAndDwabExr) {
  const TempFolder folder;
  ImageSpec tiled(64, 32, 3, TypeDesc::FLOAT);
  tiled.tile_width = tiled.tile_height = 16;
  std::vector<float> ramp(64 * 32 * 3);
  for (size_t i = 0; i < ramp.size(); ++i) ramp[i] = float(i);
  test::write_image<float>(folder / "tiled.exr", tiled, ramp);
  EXPECT_EQ(texels<float>(*read_environment(folder / "tiled.exr", nullptr)), ramp);
  ImageSpec dwab(64, 32, 3, TypeDesc::HALF);
  dwab.attribute("compression", "dwab");
  test::write_image<float>(folder / "dwab.exr", dwab, std::vector<float>(64 * 32 * 3, 0.5f));
  EXPECT_NEAR(float(texels<Imath::half>(*read_environment(folder / "dwab.exr", nullptr))[100]),
              0.5f, 0.01f);
}

TEST(ReadEnvironment, BadTexelsBecomeZeroAndAreCounted) {
  const TempFolder folder;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  for (const TypeDesc::BASETYPE type : {TypeDesc::FLOAT, TypeDesc::HALF}) {
    std::vector<float> values(4 * 2 * 3, 1.0f);
    values[0] = nan;
    values[1] = inf;
    values[2] = -1.0f;
    values[3] = -0.0f;  // harmless
    test::write_image<float>(folder / "a.exr", ImageSpec(4, 2, 3, type), values);
    uint64_t repaired = 0;
    const auto image = read_environment(folder / "a.exr", &repaired);
    EXPECT_EQ(repaired, 3u);
    const float first =
        type == TypeDesc::HALF ? float(texels<Imath::half>(*image)[1]) : texels<float>(*image)[1];
    EXPECT_EQ(first, 0.0f);
  }
}

// The primaries are those of SMPTE ST 2065-1 (AP0, whose blue has a negative y), the Academy's
// S-2014-004 (AP1) and ITU-R BT.2020. Rec. 709 colours that are written in these primaries are read
// back unchanged.
TEST(ReadEnvironment, OtherPrimariesAreConverted) {
  const TempFolder folder;
  const Chromaticities ap0 = {0.7347f, 0.2653f, 0, 1, 0.0001f, -0.077f, 0.32168f, 0.33767f};
  const Chromaticities rec2020 = {0.708f, 0.292f, 0.17f, 0.797f, 0.131f, 0.046f, 0.3127f, 0.329f};
  const auto read = [&](const Chromaticities& primaries, const std::vector<float>& values,
                        TypeDesc::BASETYPE type, uint64_t& repaired) {
    ImageSpec spec(int(values.size() / 3), 1, 3, type);
    spec.attribute("chromaticities", TypeDesc(TypeDesc::FLOAT, 8), primaries.data());
    test::write_image<float>(folder / "a.exr", spec, values);
    const auto image = read_environment(folder / "a.exr", &repaired);
    if (image->type == TexelType::kFloat) return texels<float>(*image);
    const std::vector<Imath::half> halves = texels<Imath::half>(*image);
    return std::vector<float>(halves.begin(), halves.end());
  };
  uint64_t repaired = 0;

  // White stays white, whatever the colour temperature of the primaries' white.
  for (const Chromaticities& primaries : {ap0, rec2020, chromaticities_of(WorkingSpace::kAcesCg)}) {
    for (const float value :
         read(primaries, {1, 1, 1, 5e4f, 5e4f, 5e4f}, TypeDesc::FLOAT, repaired)) {
      EXPECT_NEAR(value < 2.0f ? value : value / 5e4f, 1.0f, 1e-5f);
    }
  }
  // OpenColorIO's matrix converts to AP1, and ours converts back.
  const Rgb orange(0.8f, 0.3f, 0.05f), there = *to_working_space(WorkingSpace::kAcesCg) * orange;
  const auto back = read(chromaticities_of(WorkingSpace::kAcesCg), {there.x, there.y, there.z},
                         TypeDesc::FLOAT, repaired);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(back[size_t(c)], orange[c], 1e-4f);
  // BT.2087-0, table 1, gives the red of Rec. 709 in Rec. 2020.
  const auto red = read(rec2020, {0.6274f, 0.0691f, 0.0164f}, TypeDesc::FLOAT, repaired);
  EXPECT_NEAR(red[0], 1.0f, 1e-3f);
  EXPECT_NEAR(red[1], 0.0f, 1e-3f);
  EXPECT_NEAR(red[2], 0.0f, 1e-3f);
  EXPECT_EQ(repaired, 0u);
  // Greens outside Rec. 709 are counted, and the largest half stays finite.
  const auto green = read(rec2020, {0, 65504.0f, 0}, TypeDesc::HALF, repaired);
  EXPECT_EQ(green, (std::vector<float>{0, 65504.0f, 0}));
  EXPECT_EQ(repaired, 2u);
}

TEST(ReadEnvironment, PrimariesThatSpanNoColoursAreErrors) {
  const TempFolder folder;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const Chromaticities& primaries :
       {Chromaticities{}, Chromaticities{0.3f, 0.3f, 0.4f, 0.4f, 0.5f, 0.5f, 0.3f, 0.3f},
        Chromaticities{0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0},
        Chromaticities{0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.64f, 0.33f},
        Chromaticities{nan, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.329f},
        Chromaticities{3e38f, 0.33f, 0.30f, 0.60f, 0.15f, 3e38f, 0.3127f, 0.329f}}) {
    ImageSpec spec(2, 1, 3, TypeDesc::FLOAT);
    spec.attribute("chromaticities", TypeDesc(TypeDesc::FLOAT, 8), primaries.data());
    test::write_image<float>(folder / "a.exr", spec, {1, 1, 1, 1, 1, 1});
    EXPECT_THROW(read_environment(folder / "a.exr", nullptr), InputError);
  }
}

TEST(ReadEnvironment, GreyIsExpandedOthersAreErrors) {
  const TempFolder folder;
  ImageSpec grey(2, 1, 1, TypeDesc::FLOAT);
  grey.channelnames = {"Y"};
  test::write_image<float>(folder / "grey.exr", grey, {0.5f, 2.0f});
  EXPECT_EQ(texels<float>(*read_environment(folder / "grey.exr", nullptr)),
            (std::vector<float>{0.5f, 0.5f, 0.5f, 2, 2, 2}));
  const auto message = [](const std::string& path) -> std::string {
    try {
      read_environment(path, nullptr);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  };
  ImageSpec two(2, 1, 2, TypeDesc::FLOAT);
  two.channelnames = {"U", "V"};
  test::write_image<float>(folder / "two.exr", two, {1, 2, 3, 4});
  EXPECT_NE(message(folder / "two.exr").find("its channels are U, V"), std::string::npos);
  test::write_bytes(folder / "a.png", test::small_png());
  EXPECT_NE(message(folder / "a.png").find("is PNG, not EXR or HDR"), std::string::npos);
  EXPECT_NE(message(folder / "none.hdr").find("none.hdr"), std::string::npos);
  test::write_text(folder / "text.hdr", "not a picture");
  EXPECT_NE(message(folder / "text.hdr"), "no error");
  EXPECT_NE(message(folder.path().string()), "no error");
  std::vector<uint8_t> cut = test::encode_image<float>("exr", ImageSpec(64, 64, 3, TypeDesc::FLOAT),
                                                       std::vector<float>(64 * 64 * 3, 0.1f));
  cut.resize(cut.size() / 2);
  test::write_bytes(folder / "cut.exr", cut);
  EXPECT_NE(message(folder / "cut.exr"), "no error");
}

TEST(ReadEnvironment, ReadsTheDisplayWindow) {
  const TempFolder folder;
  ImageSpec spec(4, 2, 3, TypeDesc::FLOAT);
  std::vector<float> values(4 * 2 * 3);
  for (size_t i = 0; i < values.size(); ++i) values[i] = float(i / 3);
  // The file has two more columns than the frame on the left, and one more row above.
  spec.x = -2;
  spec.y = -1;
  spec.full_width = 2;
  spec.full_height = 1;
  test::write_image<float>(folder / "overscan.exr", spec, values);
  const auto image = read_environment(folder / "overscan.exr", nullptr);
  EXPECT_EQ(image->width, 2);
  EXPECT_EQ(image->height, 1);
  EXPECT_EQ(texels<float>(*image), (std::vector<float>{6, 6, 6, 7, 7, 7}));
  spec.full_width = 5;
  test::write_image<float>(folder / "crop.exr", spec, values);
  try {
    read_environment(folder / "crop.exr", nullptr);
    ADD_FAILURE() << "read";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("4 x 2 from (-2, -1) in 5 x 1"), std::string::npos)
        << error.what();
  }
}

// The rows have parts with and without runs, as OpenImageIO writes them. All values are exact in
// this format.
TEST(ReadFloatImage, HdrKeepsItsValues) {
  const TempFolder folder;
  for (const int width : {1, 7, 8, 127, 128, 129, 300, 1000}) {
    std::vector<float> values;
    for (int x = 0; x < 3 * width; ++x) {
      // There are long runs of equal pixels, and stretches without any.
      const uint32_t bits = hash32(x / 3 % 400 < 200 ? uint32_t(x % 3) : uint32_t(x));
      const int exponent = int(hash32(x / 3 % 400 < 200 ? 7u : uint32_t(x / 3)) % 200) - 100;
      const int mantissa = x % 3 == 0 ? 128 + int(bits % 128) : int(bits % 256);
      values.push_back(std::ldexp(float(mantissa), exponent));
    }
    test::write_image<float>(folder / "a.hdr", ImageSpec(width, 1, 3, TypeDesc::FLOAT), values);
    const FloatImage image = read_float_image(folder / "a.hdr");
    EXPECT_EQ(image.channel_names, (std::vector<std::string>{"R", "G", "B"}));
    EXPECT_EQ(image.values, values) << width;
  }
}

// A Radiance file specifies the direction of its rows and columns.
TEST(ReadEnvironment, HdrIsTurnedUpright) {
  const TempFolder folder;
  const auto write = [&](const std::string& resolution) {
    // There are no runs, because fewer than eight columns are never run-length encoded. A value is
    // 2^(e - 136) * m.
    std::string text = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n" + resolution + "\n";
    for (int i = 0; i < 4; ++i) text += std::string(3, char(128)) + char(129 + i);
    test::write_text(folder / "a.hdr", text);
    const auto values = texels<float>(*read_environment(folder / "a.hdr", nullptr));
    std::vector<int> order;
    for (size_t i = 0; i < values.size(); i += 3) order.push_back(int(std::log2(values[i])));
    return order;
  };
  EXPECT_EQ(write("-Y 2 +X 2"), (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(write("+Y 2 +X 2"), (std::vector<int>{2, 3, 0, 1}));
  EXPECT_EQ(write("-Y 2 -X 2"), (std::vector<int>{1, 0, 3, 2}));
  EXPECT_EQ(write("+Y 2 -X 2"), (std::vector<int>{3, 2, 1, 0}));
  EXPECT_THROW(write("+X 2 +Y 2"), InputError);
}

TEST(ReadFloatImage, NamesChannelsAndDecodesSrgb) {
  const TempFolder folder;
  ExrHeader header;
  header.width = 2;
  header.height = 1;
  header.data_window = {0, 0, 2, 1};
  header.channels = {{"R"}, {"G"}, {"B"}, {"albedo.G"}, {"samples", ChannelType::kUint}};
  {
    ExrWriter writer(folder / "a.exr", header);
    writer.write_tile({0, 0, 2, 1}, {1, 2, 3, 0.25f, 7, 4, 5, 6, 0.75f, 16777215});
    writer.finish();
  }
  const FloatImage exr = read_float_image(folder / "a.exr");
  EXPECT_EQ(exr.width, 2);
  EXPECT_EQ(exr.height, 1);
  ASSERT_EQ(exr.channels(), 5);
  EXPECT_EQ(exr.find_channel("nothing"), -1);
  EXPECT_EQ(exr.values[size_t(exr.find_channel("B"))], 3.0f);
  EXPECT_EQ(exr.values[size_t(exr.find_channel("albedo.G"))], 0.25f);
  // Counts are not converted.
  EXPECT_EQ(exr.values[size_t(exr.find_channel("samples"))], 7.0f);
  EXPECT_EQ(exr.values[5 + size_t(exr.find_channel("samples"))], 16777215.0f);

  ImageSpec rgba(1, 1, 4, TypeDesc::UINT8);
  rgba.attribute("oiio:UnassociatedAlpha", 1);
  test::write_image<uint8_t>(folder / "a.png", rgba, {0, 188, 255, 128});
  const FloatImage png = read_float_image(folder / "a.png");
  EXPECT_EQ(png.values[0], 0.0f);
  // IEC 61966-2-1 gives ((188/255 + 0.055) / 1.055)^2.4. Alpha is already linear.
  EXPECT_NEAR(png.values[size_t(png.find_channel("G"))], 0.5028865f, 1e-5f);
  EXPECT_NEAR(png.values[size_t(png.find_channel("B"))], 1.0f, 1e-6f);
  EXPECT_NEAR(png.values[size_t(png.find_channel("A"))], 128.0f / 255.0f, 1e-6f);
  EXPECT_THROW(read_float_image(folder / "none.exr"), InputError);
}

}  // namespace
}  // namespace emberline
