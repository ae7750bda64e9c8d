#include "io/image/file_completeness.h"

#include <ImfRgbaFile.h>
#include <ImfTiledRgbaFile.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "io/exr/writer.h"
#include "io/files/atomic_file.h"
#include "io/image/output.h"
#include "renderer/core/errors.h"
#include "support/temp_folder.h"

namespace emberline {
namespace {

class WholePicture : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_ / name; }

  // Expects that a file truncated to any smaller length is recognised as incomplete.
  void expect_cuts_found(const std::string& name) const {
    SCOPED_TRACE(name);
    EXPECT_TRUE(is_complete_file(path(name)));
    std::vector<uintmax_t> passed;
    for (uintmax_t size = std::filesystem::file_size(path(name)); size-- > 0;) {
      std::filesystem::resize_file(path(name), size);
      if (is_complete_file(path(name))) passed.push_back(size);
    }
    EXPECT_EQ(passed, std::vector<uintmax_t>());
  }
  static ByteImage noise(int width, int height) {
    ByteImage image{.width = width, .height = height, .values = {}, .srgb = true};
    uint32_t state = 1;
    for (int i = 0; i < 3 * width * height; ++i) {
      image.values.push_back(uint8_t((state = state * 1664525 + 1013904223) >> 24));
    }
    return image;
  }

  test::TempFolder folder_;
};

// The files are as after a power loss, or have data appended to them.
TEST_F(WholePicture, AnExrWhoseEndIsZeroOrNotItsOwnIsFound) {
  for (const ExrCompression compression :
       {ExrCompression::kZip, ExrCompression::kPiz, ExrCompression::kDwaa}) {
    const ExrHeader header = {.width = 64,
                              .height = 48,
                              .data_window = Rect{0, 0, 64, 48},
                              .tile_size = 64,
                              .channels = {{"R"}, {"G"}, {"B"}},
                              .compression = compression,
                              .attributes = {{"emberline:complete", "true"}}};
    std::vector<float> pixels(size_t(header.data_window.area()) * 3);
    uint32_t state = 1;
    for (float& value : pixels) {
      value = float((state = state * 1664525 + 1013904223) >> 8) * 0x1p-24f;
    }
    write_exr_file(path("a.exr"), header, pixels);
    ASSERT_TRUE(is_complete_file(path("a.exr")));
    const uintmax_t size = std::filesystem::file_size(path("a.exr"));
    for (const uintmax_t zeros : {8u, 64u, 512u, 4096u}) {
      std::filesystem::resize_file(path("a.exr"), size - zeros);
      std::filesystem::resize_file(path("a.exr"), size);
      EXPECT_FALSE(is_complete_file(path("a.exr"))) << int(compression) << " " << zeros;
      write_exr_file(path("a.exr"), header, pixels);
    }
    std::filesystem::resize_file(path("a.exr"), size + 1);
    EXPECT_FALSE(is_complete_file(path("a.exr")));
  }
}

TEST_F(WholePicture, EveryCutOfOurExrIsFound) {
  for (const ExrParts parts : {ExrParts::kOne, ExrParts::kLayers}) {
    for (const ExrCompression compression : {ExrCompression::kNone, ExrCompression::kZip}) {
      for (const int tile_size : {4, 64}) {
        const ExrHeader header = {.width = 13,
                                  .height = 9,
                                  .data_window = Rect{2, 1, 13, 9},
                                  .tile_size = tile_size,
                                  .channels = {{"R"}, {"G"}, {"B"}, {"albedo.R"}, {"Z"}},
                                  .compression = compression,
                                  .parts = parts,
                                  .attributes = {{"emberline:complete", "true"}}};
        std::vector<float> pixels(size_t(header.data_window.area()) * 5);
        for (size_t i = 0; i < pixels.size(); ++i) pixels[i] = 1.0f / float(i + 1);
        write_exr_file(path("a.exr"), header, pixels);
        expect_cuts_found("a.exr");
      }
    }
  }
}

// The names of mattes may take megabytes.
TEST_F(WholePicture, AHeaderMayBeLong) {
  const ExrHeader header = {.width = 4,
                            .height = 4,
                            .data_window = Rect{0, 0, 4, 4},
                            .channels = {{"R"}},
                            .attributes = {{"names", std::string(3'000'000, 'x')}}};
  write_exr_file(path("a.exr"), header, std::vector<float>(16));
  EXPECT_TRUE(is_complete_file(path("a.exr")));
  std::filesystem::resize_file(path("a.exr"), std::filesystem::file_size(path("a.exr")) - 1);
  EXPECT_FALSE(is_complete_file(path("a.exr")));
}

TEST_F(WholePicture, EveryCutOfAnExrOfOthersIsFound) {
  const std::vector<Imf::Rgba> pixels(20 * 40, Imf::Rgba(1, 2, 3));
  for (const Imf::Compression compression : {Imf::NO_COMPRESSION, Imf::ZIP_COMPRESSION}) {
    Imf::Header header(20, 40);
    header.compression() = compression;
    {
      Imf::RgbaOutputFile file(path("rows.exr").c_str(), header);
      file.setFrameBuffer(pixels.data(), 1, 20);
      file.writePixels(40);
    }
    expect_cuts_found("rows.exr");
    {
      Imf::TiledRgbaOutputFile file(path("levels.exr").c_str(), header, Imf::WRITE_RGBA, 8, 8,
                                    Imf::MIPMAP_LEVELS);
      file.setFrameBuffer(pixels.data(), 1, 20);
      for (int level = 0; level < file.numLevels(); ++level) {
        file.writeTiles(0, file.numXTiles(level) - 1, 0, file.numYTiles(level) - 1, level);
      }
    }
    expect_cuts_found("levels.exr");
  }
}

TEST_F(WholePicture, EveryCutOfAPngAJpegAndAGifIsFound) {
  for (const char* name : {"a.png", "a.jpg"}) {
    write_image(path(name), noise(23, 17));
    expect_cuts_found(name);
  }
  const std::vector<ByteImage> frames = {noise(23, 17), noise(23, 17)};
  const std::vector<unsigned char> gif = encode_animation(frames, 0.5, "a.gif");
  write_file_atomically(path("a.gif"), {reinterpret_cast<const char*>(gif.data()), gif.size()});
  expect_cuts_found("a.gif");
}

TEST_F(WholePicture, OtherFilesAreNotWholePictures) {
  EXPECT_THROW(is_complete_file(path("none.exr")), InputError);
  const std::string_view begins[] = {"",       "no picture",   "\x76\x2f\x31\x01",
                                     "GIF89a", "\xff\xd8\xff", "\x89PNG\r\n\x1a\n"};
  for (const std::string_view begin : begins) {
    for (const char fill : {'\0', '\x01', ';', '\x7f', '\xff'}) {
      write_file_atomically(path("odd"), std::string(begin) + std::string(3000, fill));
      EXPECT_FALSE(is_complete_file(path("odd"))) << begin << " " << int(fill);
    }
  }
}

}  // namespace
}  // namespace emberline
