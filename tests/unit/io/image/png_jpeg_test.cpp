// Tests every kind of PNG and JPEG, encoded by the libraries themselves. PNG is compared with the
// original samples, and JPEG with OpenImageIO's decoder.
#include <gtest/gtest.h>
#include <jpeglib.h>
#include <png.h>

#include <cstring>
#include <random>

#include "io/image/input.h"
#include "renderer/core/errors.h"
#include "support/encoded_images.h"

namespace emberline {
namespace {

constexpr int kPictureWidth = 13, kPictureHeight = 11;  // not multiples of the coding blocks

struct PngKind {
  int colour, depth;
  bool interlaced, transparent;

  int stored() const {  // samples per pixel
    return colour == PNG_COLOR_TYPE_RGB          ? 3
           : colour == PNG_COLOR_TYPE_RGB_ALPHA  ? 4
           : colour == PNG_COLOR_TYPE_GRAY_ALPHA ? 2
                                                 : 1;
  }
};

std::vector<PngKind> png_kinds() {
  std::vector<PngKind> kinds;
  for (const bool interlaced : {false, true}) {
    for (const bool transparent : {false, true}) {
      for (const int depth : {1, 2, 4, 8, 16}) {
        kinds.push_back({PNG_COLOR_TYPE_GRAY, depth, interlaced, transparent});
        if (depth <= 8) kinds.push_back({PNG_COLOR_TYPE_PALETTE, depth, interlaced, transparent});
        if (depth >= 8) kinds.push_back({PNG_COLOR_TYPE_RGB, depth, interlaced, transparent});
        if (depth < 8 || transparent) continue;
        kinds.push_back({PNG_COLOR_TYPE_GRAY_ALPHA, depth, interlaced, false});
        kinds.push_back({PNG_COLOR_TYPE_RGB_ALPHA, depth, interlaced, false});
      }
    }
  }
  return kinds;
}

uint8_t palette_value(size_t entry, size_t channel) {
  return uint8_t(37 * entry + 91 * channel + 5);
}

// `samples` holds the stored values, one number each.
std::vector<uint8_t> png_of(const PngKind& kind, const std::vector<uint16_t>& samples) {
  std::vector<uint8_t> out;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(
      png, &out,
      [](png_structp p, png_bytep bytes, size_t count) {
        auto& to = *static_cast<std::vector<uint8_t>*>(png_get_io_ptr(p));
        to.insert(to.end(), bytes, bytes + count);
      },
      nullptr);
  png_set_IHDR(png, info, kPictureWidth, kPictureHeight, kind.depth, kind.colour,
               kind.interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_color palette[256];
  png_byte alpha[2] = {0, 100};  // of the first two palette entries
  if (kind.colour == PNG_COLOR_TYPE_PALETTE) {
    const size_t entries = size_t(1) << kind.depth;
    for (size_t i = 0; i < entries; ++i) {
      palette[i] = {palette_value(i, 0), palette_value(i, 1), palette_value(i, 2)};
    }
    png_set_PLTE(png, info, palette, int(entries));
  }
  png_color_16 clear = {0, samples[0], samples[1], samples[2], samples[0]};  // the first pixel's
  if (kind.transparent) png_set_tRNS(png, info, alpha, 2, &clear);
  png_write_info(png, info);
  if (kind.depth < 8) png_set_packing(png);
  if (kind.depth == 16) png_set_swap(png);
  const size_t row = size_t(kPictureWidth) * size_t(kind.stored());
  const int passes = png_set_interlace_handling(png);
  for (int pass = 0; pass < passes; ++pass) {
    for (size_t y = 0; y < size_t(kPictureHeight); ++y) {
      std::vector<uint8_t> line;
      for (size_t i = 0; i < row; ++i) {
        const uint16_t sample = samples[y * row + i];
        line.push_back(uint8_t(sample));
        if (kind.depth == 16) line.push_back(uint8_t(sample >> 8));
      }
      png_write_row(png, line.data());
    }
  }
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return out;
}

// Returns the texture that the PNG specification (sections 4.3 and 13.12) defines.
std::vector<uint16_t> expanded(const PngKind& kind, const std::vector<uint16_t>& samples) {
  const size_t stored = size_t(kind.stored());
  const int largest = (1 << kind.depth) - 1, opaque = kind.depth == 16 ? 65535 : 255;
  std::vector<uint16_t> texels;
  for (size_t i = 0; i < samples.size(); i += stored) {
    if (kind.colour == PNG_COLOR_TYPE_PALETTE) {
      const size_t entry = samples[i];
      for (size_t c = 0; c < 3; ++c) texels.push_back(palette_value(entry, c));
      if (kind.transparent) texels.push_back(entry == 0 ? 0 : entry == 1 ? 100 : 255);
      continue;
    }
    bool is_clear = true;
    for (size_t c = 0; c < stored; ++c) {
      const int sample = samples[i + c];
      texels.push_back(uint16_t(kind.depth < 8 ? sample * 255 / largest : sample));
      is_clear = is_clear && sample == samples[c];
    }
    if (kind.transparent) texels.push_back(uint16_t(is_clear ? 0 : opaque));
  }
  return texels;
}

TEST(PngJpeg, EveryKindOfPngIsExpanded) {
  std::mt19937 random(7);
  const std::vector<PngKind> kinds = png_kinds();
  EXPECT_EQ(kinds.size(), 52u);
  for (const PngKind& kind : kinds) {
    SCOPED_TRACE("colour type " + std::to_string(kind.colour) + ", depth " +
                 std::to_string(kind.depth) + (kind.interlaced ? ", interlaced" : "") +
                 (kind.transparent ? ", tRNS" : ""));
    std::vector<uint16_t> samples(size_t(kPictureWidth * kPictureHeight * kind.stored()));
    for (uint16_t& sample : samples) sample = uint16_t(random() & ((1u << kind.depth) - 1));
    const std::vector<uint8_t> png = png_of(kind, samples);
    const std::shared_ptr<const Image> image = decode_image(png, "it").image;
    const std::vector<uint16_t> expected = expanded(kind, samples);
    ASSERT_EQ(image->type, kind.depth == 16 ? TexelType::kUint16 : TexelType::kUint8);
    ASSERT_EQ(size_t(image->channels) * size_t(kPictureWidth * kPictureHeight), expected.size());
    std::vector<uint16_t> texels;
    for (size_t i = 0; i < expected.size(); ++i) {
      uint16_t texel = uint16_t(image->texels[i % image->texels.size()]);
      if (kind.depth == 16) std::memcpy(&texel, image->texels.data() + 2 * i, 2);
      texels.push_back(texel);
    }
    ASSERT_EQ(texels, expected);

    // Reads the same picture as linear values, as `compare` does.
    const test::TempFolder folder;
    test::write_bytes(folder / "it.png", png);
    const FloatImage read = read_float_image(folder / "it.png");
    ASSERT_EQ(read.values.size(), expected.size());
    const size_t channels = size_t(read.channels());
    const double largest = kind.depth == 16 ? 65535 : 255;
    for (size_t i = 0; i < expected.size(); ++i) {
      const bool alpha = channels % 2 == 0 && i % channels == channels - 1;
      const double v = expected[i] / largest;
      const double linear = alpha          ? v
                            : v <= 0.04045 ? v / 12.92
                                           : std::pow((v + 0.055) / 1.055, 2.4);
      ASSERT_NEAR(read.values[i], linear, 2e-6);
    }
  }
}

struct JpegKind {
  J_COLOR_SPACE colour;
  int subsampling;  // of chroma, in both directions
  bool progressive;
};

std::vector<uint8_t> jpeg_of(const JpegKind& kind, const std::vector<uint8_t>& pixels,
                             size_t channels, int quality) {
  jpeg_compress_struct info = {};
  jpeg_error_mgr errors = {};
  info.err = jpeg_std_error(&errors);
  jpeg_create_compress(&info);
  unsigned char* bytes = nullptr;
  unsigned long count = 0;
  jpeg_mem_dest(&info, &bytes, &count);
  info.image_width = JDIMENSION(kPictureWidth);
  info.image_height = JDIMENSION(kPictureHeight);
  info.input_components = int(channels);
  info.in_color_space = channels == 1   ? JCS_GRAYSCALE
                        : channels == 2 ? JCS_UNKNOWN
                        : channels == 3 ? JCS_RGB
                                        : JCS_CMYK;
  jpeg_set_defaults(&info);
  jpeg_set_colorspace(&info, kind.colour);
  jpeg_set_quality(&info, quality, TRUE);
  for (const size_t c : {size_t(0), channels - 1}) {  // luminance and, with four channels, black
    if (c > 0 && channels != 4) continue;
    info.comp_info[c].h_samp_factor = info.comp_info[c].v_samp_factor = kind.subsampling;
  }
  if (kind.progressive) jpeg_simple_progression(&info);
  jpeg_start_compress(&info, TRUE);
  for (size_t y = 0; y < size_t(kPictureHeight); ++y) {
    JSAMPROW row = const_cast<uint8_t*>(pixels.data()) + y * size_t(kPictureWidth) * channels;
    jpeg_write_scanlines(&info, &row, 1);
  }
  jpeg_finish_compress(&info);
  jpeg_destroy_compress(&info);
  std::vector<uint8_t> out(bytes, bytes + count);
  std::free(bytes);
  return out;
}

TEST(PngJpeg, JpegHasTheBitsOfOpenImageIo) {
  std::mt19937 random(7);
  const test::TempFolder folder;
  for (const J_COLOR_SPACE colour : {JCS_GRAYSCALE, JCS_YCbCr, JCS_RGB, JCS_CMYK, JCS_YCCK}) {
    const size_t channels = colour == JCS_GRAYSCALE                    ? 1
                            : colour == JCS_YCbCr || colour == JCS_RGB ? 3
                                                                       : 4;
    for (const int subsampling : {1, 2}) {
      for (const bool progressive : {false, true}) {
        SCOPED_TRACE(std::to_string(colour) + ", " + std::to_string(subsampling) +
                     (progressive ? ", progressive" : ""));
        std::vector<uint8_t> pixels(size_t(kPictureWidth * kPictureHeight) * channels);
        for (uint8_t& value : pixels) value = uint8_t(random());
        const std::vector<uint8_t> jpeg =
            jpeg_of({colour, subsampling, progressive}, pixels, channels, 80);
        const std::shared_ptr<const Image> image = decode_image(jpeg, "it").image;
        test::write_bytes(folder / "it.jpg", jpeg);
        const auto input = OIIO::ImageInput::open(folder / "it.jpg");
        ASSERT_TRUE(input) << OIIO::geterror();
        ASSERT_EQ(image->channels, input->spec().nchannels);
        std::vector<std::byte> expected(image->texels.size());
        ASSERT_TRUE(input->read_image(0, 0, 0, -1, OIIO::TypeDesc::UINT8, expected.data()));
        ASSERT_EQ(std::vector<std::byte>(image->texels.begin(), image->texels.end()), expected);
      }
    }
  }
}

// The inks are stored as in Adobe's programs, where 255 is no ink.
TEST(PngJpeg, CmykBecomesRgb) {
  const uint8_t inks[4] = {200, 90, 250, 180};
  std::vector<uint8_t> pixels;
  for (int i = 0; i < kPictureWidth * kPictureHeight; ++i)
    pixels.insert(pixels.end(), inks, inks + 4);
  const auto image = decode_image(jpeg_of({JCS_CMYK, 1, false}, pixels, 4, 100), "it").image;
  ASSERT_EQ(image->channels, 3);
  for (size_t i = 0; i < image->texels.size(); ++i) {
    ASSERT_NEAR(int(image->texels[i]), inks[i % 3] * inks[3] / 255.0, 1.6);
  }
}

TEST(PngJpeg, ComponentsWithoutAMeaningAreRefused) {
  const std::vector<uint8_t> pixels(size_t(kPictureWidth * kPictureHeight) * 2, 90);
  const std::vector<uint8_t> two = jpeg_of({JCS_UNKNOWN, 1, false}, pixels, 2, 80);
  try {
    decode_image(two, "it");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("2 components"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace emberline
