// Reads EXR files of every compression and layout, and compares each value with the one written, or
// for lossy compressions with the values that OpenEXR's own InputFile reads.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfTiledOutputFile.h>
#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <array>
#include <fstream>
#include <iterator>

#include "io/image/input.h"
#include "renderer/core/errors.h"
#include "unit/output_folder.h"

namespace emberline {
namespace {

constexpr int kWidth = 67, kHeight = 90;  // neither whole blocks nor whole tiles
using Names = std::vector<std::string>;

constexpr std::array<const char*, 4> kNames = {"R", "G", "B", "id"};

struct Layout {
  Imf::Compression compression;
  int tile;  // 0: rows
  Imf::LevelMode levels;
};

// Values that differ between pixels and channels and are exact in half.
float value_at(int x, int y, size_t channel) {
  return float((x * 5 + y * 11 + int(channel) * 37) % 512) / 4;
}

class ExrDecoderTest : public OutputFolder {
 protected:
  std::string file() const { return path("a.exr"); }

  // Writes a picture whose data window begins at (-3, 17) of a display window from (1, 20). The
  // channel `id` is UINT, G is FLOAT, and the others are HALF.
  void write(const Layout& layout) {
    Imf::Header header(kWidth, kHeight);
    header.dataWindow() = {{-3, 17}, {kWidth - 4, kHeight + 16}};
    header.displayWindow() = {{1, 20}, {30, 40}};
    header.compression() = layout.compression;
    header.channels().insert("R", Imf::Channel(Imf::HALF));
    header.channels().insert("G", Imf::Channel(Imf::FLOAT));
    header.channels().insert("B", Imf::Channel(Imf::HALF));
    header.channels().insert("id", Imf::Channel(Imf::UINT));
    std::vector<float> floats;
    std::vector<unsigned> ids;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        for (size_t c = 0; c < 3; ++c) floats.push_back(value_at(x, y, c));
        ids.push_back(unsigned(4 * value_at(x, y, 3)));
      }
    }
    std::vector<Imath::half> halves(floats.begin(), floats.end());
    Imf::FrameBuffer buffer;
    const auto add = [&](const char* name, Imf::PixelType type, void* values, size_t pixel) {
      buffer.insert(name, Imf::Slice::Make(type, values, header.dataWindow(), pixel));
    };
    add("R", Imf::HALF, halves.data(), 6);
    add("G", Imf::FLOAT, floats.data() + 1, 12);
    add("B", Imf::HALF, halves.data() + 2, 6);
    add("id", Imf::UINT, ids.data(), 4);
    if (layout.tile == 0) {
      Imf::OutputFile out(file().c_str(), header);
      out.setFrameBuffer(buffer);
      out.writePixels(kHeight);
      return;
    }
    header.setTileDescription({unsigned(layout.tile), unsigned(layout.tile), layout.levels});
    Imf::TiledOutputFile out(file().c_str(), header);
    out.setFrameBuffer(buffer);
    out.writeTiles(0, out.numXTiles() - 1, 0, out.numYTiles() - 1);
  }

  // The file's values as InputFile reads them.
  std::vector<float> values_of_library() const {
    std::vector<float> values(size_t(kWidth) * kHeight * kNames.size());
    Imf::InputFile in(file().c_str());
    Imf::FrameBuffer buffer;
    for (size_t c = 0; c < kNames.size(); ++c) {
      buffer.insert(kNames[c], Imf::Slice::Make(Imf::FLOAT, values.data() + c,
                                                in.header().dataWindow(), 4 * kNames.size()));
    }
    in.setFrameBuffer(buffer);
    in.readPixels(in.header().dataWindow().min.y, in.header().dataWindow().max.y);
    return values;
  }
};

TEST_F(ExrDecoderTest, EveryCompressionAndLayout) {
  for (int compression = 0; compression < Imf::NUM_COMPRESSION_METHODS; ++compression) {
    for (const auto& [tile, levels] :
         {std::pair(0, Imf::ONE_LEVEL), std::pair(16, Imf::ONE_LEVEL),
          std::pair(16, Imf::MIPMAP_LEVELS), std::pair(100, Imf::ONE_LEVEL)}) {
      SCOPED_TRACE(testing::Message()
                   << "compression " << compression << ", tile " << tile << ", levels " << levels);
      write({Imf::Compression(compression), tile, levels});
      const std::vector<float> expected = values_of_library();
      for (const int threads : {1, 4}) {
        FloatImage image;
        tbb::task_arena(threads).execute([&] { image = read_float_image(file()); });
        ASSERT_EQ(image.channel_names, Names(kNames.begin(), kNames.end()));
        EXPECT_EQ(image.data_window, (Rect{-4, -3, kWidth - 4, kHeight - 3}));
        EXPECT_EQ(image.values, expected) << threads << " threads";
      }
      const bool is_lossy = compression >= Imf::PXR24_COMPRESSION;
      for (size_t i = 0; i < expected.size() && !is_lossy; ++i) {
        const int x = int(i / 4) % kWidth, y = int(i / 4) / kWidth;
        ASSERT_EQ(expected[i], value_at(x, y, i % 4) * (i % 4 == 3 ? 4 : 1)) << x << ", " << y;
      }
    }
  }
}

// The orders are those of OpenImageIO.
TEST_F(ExrDecoderTest, ColoursComeFirstInEachLayer) {
  for (const Names& expected :
       {Names{"R", "G", "B", "A", "Z", "depth", "id"}, Names{"R", "G", "B", "X", "Y", "Z", "A"},
        Names{"red", "green", "blue", "A", "Depth"}, Names{"Y", "A", "Z"},
        Names{"Y", "N.X", "N.Y", "N.Z", "sky.R", "sky.G", "sky.B"}, Names{"N.Y", "N.Z"},
        Names{"P.u", "P.v", "P.w"}}) {
    Imf::Header header(1, 1);
    Imf::FrameBuffer buffer;
    float value = 1;
    for (const std::string& name : expected) {
      header.channels().insert(name, Imf::Channel(Imf::FLOAT));
      buffer.insert(name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(&value), 4, 4));
    }
    {
      Imf::OutputFile out(file().c_str(), header);
      out.setFrameBuffer(buffer);
      out.writePixels(1);
    }
    EXPECT_EQ(read_float_image(file()).channel_names, expected);
  }
}

// A later part with the same pixels is joined, whatever its order of lines; one with other channels
// of the same names is not.
TEST_F(ExrDecoderTest, PartsAreReadByAnyThread) {
  constexpr int kSide = 100;
  std::vector<Imf::Header> headers;
  for (const char* name : {"colour", "depth", "again"}) {
    Imf::Header header(kSide, kSide);
    header.setName(name);
    header.setType(Imf::SCANLINEIMAGE);
    header.lineOrder() = name[0] == 'd' ? Imf::DECREASING_Y : Imf::INCREASING_Y;
    header.compression() = Imf::ZIPS_COMPRESSION;
    header.channels().insert(name[0] == 'd' ? "Z" : "R", Imf::Channel(Imf::FLOAT));
    headers.push_back(header);
  }
  std::vector<float> values(size_t(kSide) * kSide);
  for (size_t i = 0; i < values.size(); ++i) values[i] = float(i);
  {
    Imf::MultiPartOutputFile out(file().c_str(), headers.data(), int(headers.size()));
    for (int p = 0; p < int(headers.size()); ++p) {
      Imf::FrameBuffer buffer;
      buffer.insert(
          p == 1 ? "Z" : "R",
          Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values.data()), 4, 4 * size_t(kSide)));
      Imf::OutputPart part(out, p);
      part.setFrameBuffer(buffer);
      part.writePixels(kSide);
    }
  }
  for (const int threads : {1, 3}) {
    FloatImage image;
    tbb::task_arena(threads).execute([&] { image = read_float_image(file()); });
    EXPECT_EQ(image.channel_names, (Names{"R", "Z"}));
    ASSERT_EQ(image.parts.size(), 3u);
    EXPECT_EQ(image.parts[2].first, -1);
    for (size_t i = 0; i < values.size(); ++i) {
      ASSERT_EQ(image.values[2 * i], values[i]);
      ASSERT_EQ(image.values[2 * i + 1], values[i]);
    }
  }
}

// Another part may have any size, since it is not decoded: no memory is reserved for its tile.
TEST_F(ExrDecoderTest, PartsOfOtherSizesCostNothing) {
  std::vector<Imf::Header> headers(2, Imf::Header(1, 1));
  headers[0].setName("picture");
  headers[0].setType(Imf::SCANLINEIMAGE);
  headers[0].channels().insert("Y", Imf::Channel(Imf::FLOAT));
  constexpr int kHuge = 1 << 29;
  headers[1] = Imf::Header(kHuge, kHuge);
  headers[1].setName("huge");
  headers[1].setType(Imf::TILEDIMAGE);
  headers[1].setTileDescription({unsigned(kHuge), unsigned(kHuge), Imf::ONE_LEVEL});
  headers[1].channels().insert("Z", Imf::Channel(Imf::FLOAT));
  float value = 0.5f;
  {
    Imf::MultiPartOutputFile out(file().c_str(), headers.data(), 2, true);
    Imf::FrameBuffer buffer;
    buffer.insert("Y", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(&value), 4, 4));
    Imf::OutputPart part(out, 0);
    part.setFrameBuffer(buffer);
    part.writePixels(1);
  }
  LoadLimits limits;
  limits.memory = std::make_shared<MemoryBudget>(uint64_t(1) << 20);
  const FloatImage image = read_float_image(file(), LoadProgress({}, {}, limits));
  EXPECT_EQ(image.values, std::vector<float>{value});
  ASSERT_EQ(image.parts.size(), 2u);
  EXPECT_EQ(image.parts[1].first, -1);
}

// A picture in rows may have the attribute `tiles`, which counts for nothing.
TEST_F(ExrDecoderTest, RowsMayStateTiles) {
  Imf::Header header(40, 40);
  header.setType(Imf::SCANLINEIMAGE);
  header.channels().insert("Y", Imf::Channel(Imf::FLOAT));
  header.setTileDescription({8, 8, Imf::ONE_LEVEL});
  std::vector<float> values(1600, 0.5f);
  Imf::FrameBuffer buffer;
  buffer.insert("Y", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values.data()), 4, 160));
  {
    Imf::OutputFile out(file().c_str(), header);
    out.setFrameBuffer(buffer);
    out.writePixels(40);
  }
  // OpenEXR takes the header for that of a tiled file. This clears the flag.
  std::fstream flags(file(), std::ios::binary | std::ios::in | std::ios::out);
  flags.seekp(5);
  flags.put('\0');
  flags.close();
  EXPECT_EQ(read_float_image(file()).values, values);
}

// Whatever the number of threads, the message is about the first damaged block.
TEST_F(ExrDecoderTest, DamageHasOneMessage) {
  write({Imf::ZIP_COMPRESSION, 0, Imf::ONE_LEVEL});
  std::ifstream in(file(), std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), {}};
  std::fill(bytes.begin() + std::ptrdiff_t(bytes.size() / 3), bytes.end(), '\x55');
  std::ofstream(file(), std::ios::binary) << bytes;
  std::vector<std::string> messages;
  for (const int threads : {1, 2, 5}) {
    tbb::task_arena(threads).execute([&] {
      try {
        read_float_image(file());
      } catch (const InputError& error) {
        messages.emplace_back(error.what());
      }
    });
  }
  ASSERT_EQ(messages.size(), 3u);
  EXPECT_NE(messages[0].find(file() + ": cannot decode the image: "), std::string::npos);
  EXPECT_EQ(messages[0].find('\n'), std::string::npos);
  EXPECT_EQ(messages[0], messages[1]);
  EXPECT_EQ(messages[0], messages[2]);
}

TEST_F(ExrDecoderTest, SubsampledChannelsAreRefused) {
  Imf::Header header(4, 4);
  header.channels().insert("Y", Imf::Channel(Imf::HALF));
  header.channels().insert("BY", Imf::Channel(Imf::HALF, 2, 2));
  std::vector<Imath::half> zeros(16);
  Imf::FrameBuffer buffer;
  buffer.insert("Y", Imf::Slice(Imf::HALF, reinterpret_cast<char*>(zeros.data()), 2, 8));
  buffer.insert("BY", Imf::Slice(Imf::HALF, reinterpret_cast<char*>(zeros.data()), 2, 4, 2, 2));
  {
    Imf::OutputFile out(file().c_str(), header);
    out.setFrameBuffer(buffer);
    out.writePixels(4);
  }
  expect_error<InputError>([&] { read_float_image(file()); }, "the channel BY is subsampled");
}

}  // namespace
}  // namespace emberline
