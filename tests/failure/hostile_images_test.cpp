// Images with valid pixels but hostile metadata, images that announce more than they hold, and
// files of unsupported formats.
#include <OpenEXR/OpenEXRConfig.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstring>
#include <limits>
#include <thread>

#include "io/image/encoded_image.h"
#include "io/image/input.h"
#include "renderer/core/errors.h"
#include "support/metadata_images.h"

namespace emberline {
namespace {

using OIIO::ImageSpec;
using OIIO::TypeDesc;
using test::ByteList;
using test::operator+;
using test::TempFolder;

template <class Read>
std::string message_of(const Read& read) {
  try {
    read();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

std::string decode_message(const ByteList& encoded) {
  return message_of([&] { decode_image(encoded, "place"); });
}

#define EXPECT_SAYS(message, part) EXPECT_NE((message).find(part), std::string::npos) << (message)

// OpenImageIO 2.4 parses colour profiles with tables that threads share without a lock (its issue
// 3756), and trusts the profiles' offsets (its pull request 4557). Both faults crash the process,
// so profiles must be removed first.
TEST(HostileImages, MetadataIsNotReadOnAnyThread) {
  const std::vector<ByteList> images = test::images_with_hostile_metadata();
  ASSERT_EQ(images.size(), 60u);
  const DecodedImage jpeg = decode_image(test::small_jpeg(), "jpeg");
  const DecodedImage png = decode_image(test::small_png(), "png");
  std::vector<std::thread> threads;
  std::vector<std::string> faults(4);
  for (size_t t = 0; t < faults.size(); ++t) {
    threads.emplace_back([&, t] {
      for (size_t round = 0; round < 20; ++round) {
        for (size_t i = 0; i < images.size(); ++i) {
          const size_t index = (i + 15 * t) % images.size();
          const bool is_png = images[index][0] == 0x89;
          const std::string place = "image " + std::to_string(index);
          try {
            const DecodedImage decoded = decode_image(images[index], place);
            if (decoded.image->texels != (is_png ? png : jpeg).image->texels) faults[t] = place;
          } catch (const InputError& error) {
            faults[t] = error.what();
          }
        }
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const std::string& fault : faults) EXPECT_EQ(fault, "");
}

TEST(HostileImages, DecodersSeeNoMetadata) {
  for (const ByteList& image : test::images_with_hostile_metadata()) {
    const CleanImage clean = clean_image(sniff_image_format(image), image, "place");
    const std::string text(clean.bytes.begin(), clean.bytes.end());
    for (const char* name :
         {"ICC_PROFILE", "acsp", "Exif", "ns.adobe", "Photoshop", "iCCP", "zTXt"}) {
      EXPECT_EQ(text.find(name), std::string::npos) << name;
    }
  }
}

// Metadata that affects the samples must stay: Adobe's segment says whether three components are
// YCbCr or RGB, and tRNS makes colours transparent.
TEST(HostileImages, DataThatAffectsSamplesIsKept) {
  const ByteList adobe = test::jpeg_segment(
      0xee, test::bytes_of("Adobe") + ByteList{0, 100, 0, 0, 0, 0, 0});  // transform 0: RGB
  const ByteList jpeg = test::small_jpeg();
  ByteList without_jfif(jpeg.begin(), jpeg.begin() + 2);
  ASSERT_EQ(jpeg[3], 0xe0);
  without_jfif.insert(without_jfif.end(), jpeg.begin() + 4 + jpeg[4] * 256 + jpeg[5], jpeg.end());
  const auto as_rgb = decode_image(test::with_segments(without_jfif, adobe), "rgb");
  const auto as_ycbcr = decode_image(jpeg, "ycbcr");
  EXPECT_NE(as_rgb.image->texels, as_ycbcr.image->texels);

  ImageSpec grey(1, 1, 1, TypeDesc::UINT8);
  const ByteList png = test::encode_image<uint8_t>("png", grey, {7});
  const auto clear = decode_image(test::with_chunks(png, test::png_chunk("tRNS", {0, 7})), "png");
  EXPECT_EQ(clear.image->channels, 2);
  EXPECT_EQ(clear.image->texels[1], std::byte(0));
}

TEST(HostileImages, ACutJpegIsRefusedOrNamed) {
  const std::vector<uint8_t> noise = [] {
    std::mt19937 random(1);
    std::vector<uint8_t> texels(64 * 64 * 3);
    for (uint8_t& texel : texels) texel = uint8_t(random());
    return texels;
  }();
  const ByteList jpeg =
      test::encode_image<uint8_t>("jpg", ImageSpec(64, 64, 3, TypeDesc::UINT8), noise);
  const ByteList behind = jpeg + ByteList(1000, 0xff);
  EXPECT_EQ(decode_message(behind), "no error");  // bytes after the image are ignored
  int taken = 0;
  for (size_t size = 2; size < jpeg.size(); size += 37) {
    const ByteList cut(jpeg.begin(), jpeg.begin() + long(size));
    EXPECT_EQ(decode_message(cut).rfind("place: ", 0), 0u) << size;
    try {
      EXPECT_TRUE(decode_image(cut, "place", true).truncated);
      ++taken;
    } catch (const InputError&) {
      EXPECT_LT(size, jpeg.size() / 2);  // too short even for a header
    }
  }
  EXPECT_GT(taken, 10);
  ByteList cut = jpeg;
  cut.resize(jpeg.size() / 2);
  EXPECT_SAYS(decode_message(cut), "truncated; use lenient");
}

// A header that announces a large picture without data must not cause a large allocation.
TEST(HostileImages, HeadersAreCheckedAgainstTheFileSize) {
  const TempFolder folder;
  const std::string head = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n";
  test::write_text(folder / "a.hdr", head + "-Y 20000 +X 30000\n" + std::string(8000, '\2'));
  const auto read = [&] { read_environment(folder / "a.hdr", nullptr); };
  EXPECT_SAYS(message_of(read), "30000 x 20000 pixels do not fit into 80");
  test::write_text(folder / "a.hdr", head + "-Y 99999999999 +X 4\n");
  EXPECT_SAYS(message_of(read), "no resolution line");
  test::write_text(folder / "a.hdr", "#?RADIANCE\n" + std::string(1 << 20, 'x'));
  EXPECT_SAYS(message_of(read), "header of the HDR is longer than");

  ByteList jpeg = test::small_jpeg();
  for (size_t i = 0; i + 8 < jpeg.size(); ++i) {
    if (jpeg[i] != 0xff || jpeg[i + 1] != 0xc0) continue;
    jpeg[i + 5] = jpeg[i + 6] = jpeg[i + 7] = jpeg[i + 8] = 0xf0;  // height, width
  }
  EXPECT_SAYS(decode_message(jpeg), "do not fit into");
  EXPECT_EQ(decode_message(test::small_png()), "no error");
}

// The budget is checked before any byte of the image is decoded.
TEST(HostileImages, SizesAreCheckedAgainstTheBudget) {
  const auto budget = std::make_shared<MemoryBudget>(uint64_t(1) << 20);
  LoadProgress progress({}, {}, {.memory = budget, .timeout_s = {}, .scene = {}});
  const ByteList webp = test::encode_image<uint8_t>(
      "webp", ImageSpec(1024, 1024, 4, TypeDesc::UINT8), ByteList(size_t(1) << 22, 9));
  ASSERT_LT(webp.size(), 10000u);
  const std::string message = message_of([&] { decode_image(webp, "place", false, progress); });
  EXPECT_SAYS(message, "raise memory-limit");
  EXPECT_EQ(budget->reserved(), 0u);
}

TEST(HostileImages, OnlyKnownFormatsAreOpened) {
  const TempFolder folder;
  const auto read = [&](const char* name) {
    return message_of([&] { read_float_image(folder / name); });
  };
  test::write_text(folder / "a.iff", "FOR4\0\0\0\10CIMG");
  test::write_text(folder / "a.dpx", "SDPX and more of it");
  test::write_text(folder / "a.exr", "GIF89a and more of it");
  for (const char* name : {"a.iff", "a.dpx", "a.exr"}) {
    EXPECT_SAYS(read(name), "the image is not EXR, HDR, PNG, JPEG, WebP or TIFF");
  }
  test::write_bytes(folder / "a.png", test::small_png());
  EXPECT_SAYS(message_of([&] { read_environment(folder / "a.png", nullptr); }),
              "the image is PNG, not EXR or HDR");
  const ByteList tiff =
      test::encode_image<uint8_t>("tif", ImageSpec(1, 1, 3, TypeDesc::UINT8), {255, 255, 255});
  EXPECT_SAYS(decode_message(tiff), "the image is TIFF, not PNG");
}

// OpenImageIO would parse options from these names.
TEST(HostileImages, FileNamesHaveNoOptions) {
  const TempFolder folder;
  for (const char* name : {"a?subimage=3.exr", "a&b.exr", "a b\n.exr"}) {
    test::write_bytes(
        folder / name,
        test::encode_image<float>("exr", ImageSpec(2, 1, 3, TypeDesc::FLOAT), {1, 2, 3, 4, 5, 6}));
    EXPECT_EQ(read_float_image(folder / name).values, (std::vector<float>{1, 2, 3, 4, 5, 6}));
  }
}

TEST(HostileImages, DeepExrIsRefused) {
  ByteList exr = test::encode_image<float>("exr", ImageSpec(1, 1, 3, TypeDesc::FLOAT), {1, 2, 3});
  exr[5] |= 0x08;
  EXPECT_SAYS(decode_message(exr), "deep EXR is not supported");
}

// OpenEXR trusts the type of a value, whereas our code trusts its size. So the excess bytes of a
// value would be read as another value, here as a text of 1.9 GB.
TEST(HostileImages, ExrValuesHaveTheSizeOfTheirType) {
  const ByteList exr =
      test::encode_image<float>("exr", ImageSpec(1, 1, 3, TypeDesc::FLOAT), {1, 2, 3});
  const auto word = [](uint32_t value) {
    return ByteList{uint8_t(value), uint8_t(value >> 8), uint8_t(value >> 16),
                    uint8_t(value >> 24)};
  };
  const auto name = [](const std::string& text) { return test::bytes_of(text) + ByteList{0}; };
  const auto value = [&](const std::string& type, const ByteList& bytes) {
    return name("a " + type) + name(type) + word(uint32_t(bytes.size())) + bytes;
  };
  // A table follows the header. It has one offset, that of the only row.
  const auto with = [&](const ByteList& attributes) {
    ByteList out = exr;
    out.insert(out.begin() + 8, attributes.begin(), attributes.end());
    const ByteList offset = word(uint32_t(out.size() - 20));
    std::copy(offset.begin(), offset.end(), out.end() - 28);
    return out;
  };
  const ByteList hidden = name("y") + name("string") + word(0x70000000);
  const ByteList channel = name("Z") + word(2) + word(0) + word(1) + word(1);
  const std::vector<std::pair<std::string, ByteList>> wrong = {
      {"box2i", ByteList(16, 0) + hidden},
      {"int", word(1) + hidden},
      {"v3i", ByteList(8, 0)},
      {"m44d", ByteList(72, 0)},
      {"chlist", channel + ByteList{0} + hidden},
      {"chlist", channel},
      {"preview", word(1) + word(1) + word(0) + hidden},
      {"preview", word(1u << 31) + word(1u << 31)},
      {"stringvector", word(0x70000000) + hidden},
      {"stringvector", word(1) + ByteList{'a', 0}},
  };
  for (const auto& [type, bytes] : wrong) {
    const std::string message = decode_message(with(value(type, bytes)));
    EXPECT_TRUE(message.find("an attribute of type " + type + " with the wrong size") !=
                    message.npos ||
                message.find("the header of the EXR is longer") != message.npos)
        << message;
  }
  const ByteList right =
      value("v3i", ByteList(12, 0)) + value("preview", word(1) + word(1) + word(0)) +
      value("stringvector", word(1) + ByteList{'a'}) + value("ours", ByteList(5, 7));
  EXPECT_EQ(decode_message(with(right)), "no error");
}

// An offset of -1 must not make the decoder read just before the buffer. OpenEXR 3.4 rebuilds a
// table that holds -1, and finds the row.
TEST(HostileImages, ExrOffsetsStayInsideTheFile) {
  const TempFolder folder;
  ImageSpec spec(4, 1, 3, TypeDesc::FLOAT);
  spec.attribute("compression", "none");
  constexpr bool kTablesAreMadeAnew = OPENEXR_VERSION_HEX >= 0x03040000;
  const std::vector<float> honest(12, 1.0f);
  ByteList exr = test::encode_image<float>("exr", spec, honest);
  constexpr size_t kRow = 8 + 12 * sizeof(float), kOffset = 8;
  // The file is placed right behind a page without read access.
  const size_t page = size_t(::sysconf(_SC_PAGESIZE));
  ASSERT_LT(exr.size(), page);
  auto* const pages = static_cast<uint8_t*>(
      ::mmap(nullptr, 2 * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
  ASSERT_NE(pages, MAP_FAILED);
  ASSERT_EQ(::mprotect(pages, page, PROT_NONE), 0);
  const int64_t size = int64_t(exr.size());
  for (const int64_t offset :
       {int64_t(-1), int64_t(-2), int64_t(-4), int64_t(-8), int64_t(-100), -size, size - 1, size,
        size + 1, int64_t(1) << 40, std::numeric_limits<int64_t>::min(),
        std::numeric_limits<int64_t>::max()}) {
    SCOPED_TRACE(offset);
    std::memcpy(exr.data() + exr.size() - kRow - kOffset, &offset, sizeof(offset));
    std::ranges::copy(exr, pages + page);
    const std::span<const uint8_t> guarded(pages + page, exr.size());
    test::write_bytes(folder / "a.exr", exr);
    if (kTablesAreMadeAnew && offset == -1) {
      EXPECT_EQ(read_float_image(folder / "a.exr").values, honest);
      EXPECT_EQ(decode_image(guarded, "place").image->texels.size(), 12 * sizeof(float));
      continue;
    }
    EXPECT_SAYS(message_of([&] { decode_image(guarded, "place"); }), "place");
    EXPECT_SAYS(message_of([&] { read_float_image(folder / "a.exr"); }), "a.exr");
  }
  ::munmap(pages, 2 * page);
}

// A tile is decoded whole, so a tiny image with huge tiles would take gigabytes.
TEST(HostileImages, TilesAreCheckedAgainstTheBudgetAndTheImage) {
  const TempFolder folder;
  const auto budget = std::make_shared<MemoryBudget>(uint64_t(32) << 20);
  for (const char* suffix : {"exr", "tif"}) {
    SCOPED_TRACE(suffix);
    const std::string path = folder / (std::string("tiled.") + suffix);
    ImageSpec spec(32, 32, 3, TypeDesc::FLOAT);
    spec.tile_width = spec.tile_height = 16;
    const ByteList honest =
        test::encode_image<float>(suffix, spec, std::vector<float>(32 * 32 * 3, 0.5f));
    const auto message = [&](uint32_t side, const LoadLimits& limits) {
      ByteList image = honest;
      const std::string_view text(reinterpret_cast<const char*>(image.data()), image.size());
      if (std::string_view(suffix) == "exr") {
        const size_t at = text.find("tiledesc") + 13;
        std::memcpy(&image[at], &side, 4);
        std::memcpy(&image[at + 4], &side, 4);
      } else {
        for (const char* tag : {"\x42\x01", "\x43\x01"}) {  // 322, 323: from SHORT to LONG
          const size_t at = text.find(std::string(tag, 2) + std::string("\3\0\1\0\0\0", 6));
          EXPECT_NE(at, text.npos);
          image[at + 2] = 4;
          std::memcpy(&image[at + 8], &side, 4);
        }
      }
      test::write_bytes(path, image);
      return message_of([&] { read_float_image(path, LoadProgress({}, {}, limits)); });
    };
    EXPECT_EQ(message(16, {}), "no error");
    for (const uint32_t side : {4097u, 13000u, 32768u, 0x7ffffff0u}) {
      EXPECT_SAYS(message(side, {}), "larger than the image");
    }
    EXPECT_SAYS(message(4096, {.memory = budget, .timeout_s = {}, .scene = {}}),
                "raise memory-limit");
    EXPECT_EQ(budget->reserved(), 0u);
  }
}

// Rows are decoded in the blocks in which they are compressed, with all channels.
TEST(HostileImages, JointlyCodedRowsAreCheckedAgainstTheBudget) {
  const TempFolder folder;
  const std::string path = folder / "wide.exr";
  constexpr int kWidth = 4096, kRows = 16, kChannels = 60;  // 16 MB
  test::write_bytes(path, test::encode_image<float>(
                              "exr", ImageSpec(kWidth, kRows, kChannels, TypeDesc::FLOAT),
                              std::vector<float>(size_t(kWidth) * kRows * kChannels, 0.0f)));
  const auto budget = std::make_shared<MemoryBudget>(uint64_t(24) << 20);
  const auto read = [&](const LoadLimits& limits) {
    return message_of([&] { read_float_image(path, LoadProgress({}, {}, limits)); });
  };
  EXPECT_EQ(read({}), "no error");
  EXPECT_SAYS(read({.memory = budget, .timeout_s = {}, .scene = {}}), "raise memory-limit");
}

// If the components of a JPEG come one after another, its decoder must keep all coefficients.
TEST(HostileImages, CoefficientsOfAJpegAreCounted) {
  const auto bytes_per_pixel = [](uint8_t frame, uint8_t in_a_scan) {
    ByteList jpeg = {0xff, 0xd8, 0xff, frame, 0, 17, 8, 3, 32, 3, 32, 3};  // 800 x 800
    for (uint8_t c = 1; c <= 3; ++c) jpeg.insert(jpeg.end(), {c, 0x11, 0});
    jpeg.insert(jpeg.end(), {0xff, 0xda, 0, uint8_t(6 + 2 * in_a_scan), in_a_scan});
    for (uint8_t c = 1; c <= in_a_scan; ++c) jpeg.insert(jpeg.end(), {c, 0});
    jpeg.insert(jpeg.end(), {0, 63, 0});
    jpeg.resize(jpeg.size() + 4000);
    jpeg.insert(jpeg.end(), {0xff, 0xd9});
    return clean_image(ImageFormat::kJpeg, jpeg, "place").header.decoder_bytes_per_pixel;
  };
  EXPECT_EQ(bytes_per_pixel(0xc0, 3), 0);
  EXPECT_EQ(bytes_per_pixel(0xc0, 1), 6);
  EXPECT_EQ(bytes_per_pixel(0xc1, 2), 6);
  EXPECT_EQ(bytes_per_pixel(0xc2, 3), 6);
}

// OpenImageIO reads header lines in pieces of 127 bytes. After a line of that length it finds the
// line's end, takes it for an empty line, and takes the next line for the size. Our reader must not
// do that.
TEST(HostileImages, AnHdrHasOneSize) {
  const TempFolder folder;
  const std::string path = folder / "a.hdr";
  for (const size_t length : {126, 127, 128, 254, 255}) {
    std::string text = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nA=" + std::string(length - 2, 'x') +
                       "\n-Y 3000 +X 3000\n\n-Y 4 +X 8\n";
    text.resize(text.size() + 4 * 8 * 4, '\x40');
    test::write_bytes(path, test::bytes_of(text));
    const FloatImage image = read_float_image(path);
    EXPECT_EQ(image.width, 8);
    EXPECT_EQ(image.height, 4);
  }
}

TEST(HostileImages, HdrRowsHaveTheImagesWidth) {
  const TempFolder folder;
  const std::string head = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 8\n";
  const auto message = [&](std::initializer_list<int> row) {
    ByteList bytes = test::bytes_of(head);
    for (const int byte : row) bytes.push_back(uint8_t(byte));
    test::write_bytes(folder / "a.hdr", bytes);
    return message_of([&] { read_float_image(folder / "a.hdr"); });
  };
  EXPECT_EQ(message({2, 2, 0, 8, 136, 1, 136, 2, 136, 3, 136, 128}), "no error");
  EXPECT_SAYS(message({2, 2, 0, 9, 136, 1, 136, 2, 136, 3, 136, 128}), "the wrong width");
  EXPECT_SAYS(message({2, 2, 0, 8, 137, 1, 136, 2, 136, 3, 136, 128}),
              "a run extends beyond its row");
  EXPECT_SAYS(message({2, 2, 0, 8, 135, 1, 2, 0, 0, 136, 2, 136, 3, 136, 128}), "a run extends");
  EXPECT_SAYS(message({2, 2, 0, 8, 0, 0, 0, 0, 0, 0, 0, 0, 0}), "a run extends beyond its row");
  EXPECT_SAYS(message({2, 2, 0, 8, 136, 1, 136, 2, 136, 3, 8, 128}), "is truncated");
  EXPECT_SAYS(message({3, 2, 0, 8, 136, 1, 136, 2, 136, 3, 136, 128}), "is truncated");  // flat
  test::write_text(folder / "xyz.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n1234");
  EXPECT_SAYS(message_of([&] { read_float_image(folder / "xyz.hdr"); }),
              "pixels of the HDR file are not stored as RGBE");
}

// Tests the limits on structures whose repetition multiplies the processing time.
TEST(HostileImages, RepeatedScansAreBounded) {
  // Values of an EXR's header are searched linearly.
  ByteList exr = test::encode_image<float>("exr", ImageSpec(1, 1, 3, TypeDesc::FLOAT), {1, 2, 3});
  ByteList values;
  for (int i = 0; i < 5000; ++i) {
    values = values + test::bytes_of("v" + std::to_string(i)) + ByteList{0} +
             test::bytes_of("int") + ByteList{0, 4, 0, 0, 0, 1, 0, 0, 0};
  }
  exr.insert(exr.begin() + 8, values.begin(), values.end());
  EXPECT_SAYS(decode_message(exr), "more than 4000 attributes");
  // Each scan of a progressive JPEG visits all pixels.
  ImageSpec spec(16, 16, 3, TypeDesc::UINT8);
  spec.attribute("jpeg:progressive", 1);
  ByteList jpeg = test::encode_image<uint8_t>("jpg", spec, std::vector<uint8_t>(16 * 16 * 3, 99));
  size_t last = 0, frame = 0;
  for (size_t i = 0; i + 1 < jpeg.size(); ++i) {
    if (jpeg[i] == 0xff && jpeg[i + 1] == 0xda) last = i;
    if (jpeg[i] == 0xff && jpeg[i + 1] == 0xc2) frame = i;
  }
  ASSERT_GT(frame, 0u);
  const ByteList scan(jpeg.begin() + ptrdiff_t(last), jpeg.end() - 2);
  for (int i = 0; i < 30; ++i) jpeg.insert(jpeg.end() - 2, scan.begin(), scan.end());
  EXPECT_EQ(decode_message(jpeg).find("scans"), std::string::npos);
  for (const size_t at : {frame + 5, frame + 7}) {  // height, width
    jpeg[at] = 0x40;
    jpeg[at + 1] = 0;
  }
  EXPECT_SAYS(decode_message(jpeg), "more than 20 scans");
  // A WebP with a single colour is equally short for any size.
  ImageSpec lossless(4, 4, 3, TypeDesc::UINT8);
  lossless.attribute("compression", "lossless");
  ByteList webp = test::encode_image<uint8_t>("webp", lossless, ByteList(4 * 4 * 3, 7));
  const std::string_view text(reinterpret_cast<const char*>(webp.data()), webp.size());
  const size_t size = text.find("VP8L") + 9;
  ASSERT_LT(size, webp.size());
  webp[size] = webp[size + 1] = webp[size + 2] = 0xff;
  webp[size + 3] |= 0x0f;
  EXPECT_SAYS(decode_message(webp), "16384 x 16384 pixels do not fit");
}

// clean_tiff() removes the colour profile, EXIF and other metadata from a TIFF's directory.
TEST(HostileImages, TiffKeepsItsPixels) {
  const TempFolder folder;
  ImageSpec spec(2, 1, 3, TypeDesc::UINT16);
  spec.attribute("Exif:FNumber", 2.8f);
  spec.attribute("ICCProfile", TypeDesc(TypeDesc::UINT8, 240),
                 test::icc_profile(3, 200, 16).data());
  test::write_image<uint16_t>(folder / "a.tif", spec, {0, 65535, 0, 65535, 0, 65535});
  const ByteList before = test::read_bytes(folder / "a.tif");
  ByteList after = before;
  clean_tiff(after, "place");
  EXPECT_NE(after, before);
  EXPECT_EQ(read_float_image(folder / "a.tif").values, (std::vector<float>{0, 1, 0, 1, 0, 1}));
  for (size_t size = 0; size < before.size(); size += 3) {
    ByteList cut(before.begin(), before.begin() + long(size));
    test::write_bytes(folder / "cut.tif", cut);
    EXPECT_NE(message_of([&] { read_float_image(folder / "cut.tif"); }), "") << size;
  }
}

}  // namespace
}  // namespace emberline
