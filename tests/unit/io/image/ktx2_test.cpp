// KTX 2 pictures equal those of the reference decoder bit for bit, and unsupported pictures are
// reported.
#include <gtest/gtest.h>

#include "io/image/input.h"
#include "io/image/ktx2/block_rows.h"
#include "io/image/ktx2/huffman.h"
#include "renderer/core/errors.h"
#include "support/ktx2_files.h"

namespace emberline {
namespace {

using Ktx2Bytes = std::vector<uint8_t>;

std::shared_ptr<const Image> decode_ktx2(const Ktx2Bytes& bytes) {
  return decode_image(bytes, "place").image;
}

std::string ktx2_message(const Ktx2Bytes& bytes) {
  try {
    decode_ktx2(bytes);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

// Returns a channel of pixel `i` in the layout of the reference, which has four channels. A missing
// alpha is 1.
std::byte channel_at(const Image& image, size_t i, int channel) {
  if (channel >= image.channels) return std::byte(255);
  return image.texels[i * size_t(image.channels) + size_t(channel)];
}

TEST(Ktx2, PixelsMatchTheReferenceDecoder) {
  for (const std::string name : test::kKtx2Files) {
    const auto image = decode_ktx2(test::ktx2_file(name));
    const auto reference = decode_image(test::ktx2_reference(name), name).image;
    ASSERT_EQ(image->width, reference->width) << name;
    ASSERT_EQ(image->height, reference->height) << name;
    ASSERT_EQ(reference->channels, 4) << name;
    EXPECT_EQ(image->type, TexelType::kUint8);
    size_t different = 0;
    for (size_t i = 0; i < size_t(image->width) * size_t(image->height); ++i) {
      for (int c = 0; c < 4; ++c) {
        different += channel_at(*image, i, c) != channel_at(*reference, i, c);
      }
    }
    EXPECT_EQ(different, 0u) << name;
  }
}

// The image has the channels of its descriptor: alpha if the descriptor has it, a single channel
// for red alone, and green for a second component.
TEST(Ktx2, ChannelsMatchTheDescriptor) {
  const Ktx2Bytes uastc = test::ktx2_file("uastc_gradient"), etc1s = test::ktx2_file("etc1s_alpha");
  const auto uastc_rgba = decode_ktx2(uastc), etc1s_rgba = decode_ktx2(etc1s);
  ASSERT_EQ(uastc_rgba->channels, 4);
  ASSERT_EQ(etc1s_rgba->channels, 4);
  const auto expect = [](const Ktx2Bytes& bytes, const Image& rgba,
                         const std::vector<int>& sources) {
    const auto image = decode_ktx2(bytes);
    ASSERT_EQ(size_t(image->channels), sources.size());
    for (size_t i = 0; i < size_t(rgba.width) * size_t(rgba.height); ++i) {
      for (size_t c = 0; c < sources.size(); ++c) {
        const std::byte wanted = sources[c] < 0 ? std::byte(0) : channel_at(rgba, i, sources[c]);
        ASSERT_EQ(channel_at(*image, i, int(c)), wanted) << i;
      }
    }
  };
  const std::vector<std::pair<uint8_t, std::vector<int>>> kinds = {
      {0, {0, 1, 2}}, {4, {0}}, {5, {0, 3, -1}}, {6, {0, 1, -1}}};
  for (const auto& [channel, sources] : kinds) {
    Ktx2Bytes changed = uastc;
    changed[test::channel_of(uastc, 0)] = channel;
    expect(changed, *uastc_rgba, sources);
  }
  Ktx2Bytes two = etc1s;
  two[test::channel_of(etc1s, 0)] = 3;
  two[test::channel_of(etc1s, 1)] = 4;
  expect(two, *etc1s_rgba, {0, 3, -1});
}

// An encoder may share an end point between alpha and colour, so an alpha slice is not always grey.
// Here the picture's own colours replace it, for each kind of picture with a second slice.
TEST(Ktx2, ASecondSliceCountsByItsGreen) {
  Ktx2Bytes shared = test::ktx2_file("etc1s_alpha");
  // BasisLZ's global data start with a header of 20 bytes. For the image of each level, its flags
  // follow, and then the offset and size of its colour and of its alpha.
  const size_t image = test::word_at(shared, 64) + 20;
  for (const size_t word : {4u, 8u}) {
    test::set_word(shared, image + word + 8, test::word_at(shared, image + word));
  }
  const auto rgba = decode_ktx2(shared);
  size_t coloured = 0;
  for (size_t i = 0; i < size_t(rgba->width) * size_t(rgba->height); ++i) {
    ASSERT_EQ(channel_at(*rgba, i, 3), channel_at(*rgba, i, 1)) << i;
    coloured += channel_at(*rgba, i, 0) != channel_at(*rgba, i, 1);
  }
  EXPECT_GT(coloured, 100u);
  Ktx2Bytes two = shared;
  two[test::channel_of(two, 0)] = 3;
  two[test::channel_of(two, 1)] = 4;
  const auto red_green = decode_ktx2(two);
  for (size_t i = 0; i < size_t(rgba->width) * size_t(rgba->height); ++i) {
    ASSERT_EQ(channel_at(*red_green, i, 0), channel_at(*rgba, i, 0)) << i;
    ASSERT_EQ(channel_at(*red_green, i, 1), channel_at(*rgba, i, 1)) << i;
  }
}

TEST(Ktx2, TheTransferFunctionIsPassedOn) {
  EXPECT_EQ(decode_image(test::ktx2_file("etc1s_odd"), "place").transfer, "sRGB");
  EXPECT_EQ(decode_image(test::ktx2_file("etc1s_linear"), "place").transfer, "linear");
  EXPECT_EQ(decode_image(test::ktx2_reference("etc1s_odd"), "place").transfer, "");
}

TEST(Ktx2, UnsupportedFeaturesAreNamed) {
  const Ktx2Bytes plain = test::ktx2_file("uastc_nozstd");
  const size_t descriptor = test::descriptor_of(plain), texts = test::word_at(plain, 56) + 4;
  const auto expect = [&](size_t offset, std::string_view written, const char* expected_message) {
    Ktx2Bytes bytes = plain;
    std::copy(written.begin(), written.end(), bytes.begin() + std::ptrdiff_t(offset));
    const std::string message = ktx2_message(bytes);
    EXPECT_EQ(message.rfind("place: ", 0), 0u) << message;
    EXPECT_NE(message.find(expected_message), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  };
  expect(12, "\x91", "VkFormat 145");
  expect(28, "\x02", "several layers, faces or slices");
  expect(32, "\x01", "several layers, faces or slices");
  expect(36, "\x06", "several layers, faces or slices");
  expect(40, "\x07", "7 levels");
  expect(44, "\x03", "colour model 166 and supercompression 3");
  expect(descriptor + 8, "\xa7", "colour model 167 and supercompression 0");
  expect(descriptor + 10, "\x04", "transfer function 4");
  expect(descriptor + 11, "\x01", "premultiplied alpha");
  expect(descriptor + 12, "\x07", "blocks that are not 4 x 4 pixels");
  expect(test::channel_of(plain, 0), "\x02", "the channels 2");
  expect(texts, std::string_view("KTXswizzle\0rrra\0", 16), "swizzled channels");
  expect(texts, std::string_view("KTXorientation\0ru\0", 18), "an orientation other than top-left");
  Ktx2Bytes harmless = plain;
  const std::string_view given("KTXorientation\0rd\0", 18);
  std::copy(given.begin(), given.end(), harmless.begin() + std::ptrdiff_t(texts));
  EXPECT_EQ(ktx2_message(harmless), "no error");

  Ktx2Bytes video = test::ktx2_file("etc1s_odd");
  video[test::word_at(video, 64) + 20] = 2;
  EXPECT_NE(ktx2_message(video).find("video frames"), std::string::npos);
}

// By the specification, "Mode Index" 19 is reserved, "ETC2M cannot be zero", and patterns must be
// within their table.
TEST(Ktx2, BlocksThatMeanNothingAreOfTheColourOfErrors) {
  const auto is_error = [](std::array<uint8_t, 16> block) {
    const ktx2::BlockPixels pixels = ktx2::decode_uastc(block);
    return std::ranges::all_of(pixels, [](const auto& p) {
      return p == std::array<uint8_t, 4>{255, 0, 255, 255};
    });
  };
  EXPECT_TRUE(is_error({0x45}));
  EXPECT_TRUE(is_error({0x00}));               // mode 11, ETC2M of 0
  EXPECT_FALSE(is_error({0x00, 0x80}));        // mode 11, ETC2M of 1 in bits 15 to 18
  EXPECT_FALSE(is_error({0x03, 0, 0xa0}));     // mode 3, pattern 10 in bits 20 to 23
  EXPECT_TRUE(is_error({0x03, 0, 0xb0}));      // mode 3, pattern 11
  EXPECT_FALSE(is_error({0x07, 0, 0x20, 1}));  // mode 7, pattern 18 in bits 20 to 24
  EXPECT_TRUE(is_error({0x07, 0, 0x30, 1}));   // mode 7, pattern 19
}

// RFC 1951, section 3.2.2, has an example with the lengths (3, 3, 3, 3, 3, 2, 4, 4) for A to H.
TEST(Ktx2, HuffmanCodesAreCanonical) {
  const std::array<uint8_t, 8> lengths = {3, 3, 3, 3, 3, 2, 4, 4};
  const std::array<std::string_view, 8> codes = {"010", "011", "100",  "101",
                                                 "110", "00",  "1110", "1111"};
  const ktx2::HuffmanTable table(lengths, "place");
  for (size_t symbol = 0; symbol < codes.size(); ++symbol) {
    std::array<uint8_t, 2> stream = {};
    for (size_t i = 0; i < codes[symbol].size(); ++i) {
      if (codes[symbol][i] == '1') stream[0] = uint8_t(stream[0] | 1 << i);
    }
    ktx2::BitReader bits(stream, "place", "bits");
    EXPECT_EQ(table.decode(bits), symbol);
  }
  const std::array<uint8_t, 3> too_many = {1, 1, 1}, too_few = {2, 2, 2};
  EXPECT_THROW(ktx2::HuffmanTable(too_many, "place"), InputError);
  EXPECT_THROW(ktx2::HuffmanTable(too_few, "place"), InputError);
}

}  // namespace
}  // namespace emberline
