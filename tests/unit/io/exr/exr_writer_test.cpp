// Reads files of ExrWriter back with OpenEXR's own reader. A failure must leave no file.
#include "io/exr/writer.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfChromaticitiesAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfTestFile.h>
#include <OpenEXR/ImfTiledInputFile.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <random>
#include <thread>

#include "renderer/core/errors.h"
#include "unit/output_folder.h"

namespace emberline {
namespace {

namespace fs = std::filesystem;

using ExrWriterTest = OutputFolder;

// A value that depends on the channel and the pixel and is exact in float and in uint.
float expected_value(int x, int y, size_t channel) {
  return float((x * 7 + y * 13 + int(channel) * 101) % 1024);
}

std::vector<Rect> tiles_of(const ExrHeader& header) {
  std::vector<Rect> tiles;
  const Rect& crop = header.data_window;
  for (int y = crop.y0; y < crop.y1; y += header.tile_size) {
    for (int x = crop.x0; x < crop.x1; x += header.tile_size) {
      tiles.push_back(Rect{x, y, x + header.tile_size, y + header.tile_size}.intersect(crop));
    }
  }
  return tiles;
}

std::vector<float> tile_pixels(const ExrHeader& header, const Rect& rect) {
  std::vector<float> pixels;
  for (int y = rect.y0; y < rect.y1; ++y) {
    for (int x = rect.x0; x < rect.x1; ++x) {
      for (size_t c = 0; c < header.channels.size(); ++c) pixels.push_back(expected_value(x, y, c));
    }
  }
  return pixels;
}

// Reads one channel of the data window as floats, with OpenEXR's general reader, which also
// converts.
std::vector<float> read_channel(const std::string& path, const std::string& name) {
  Imf::InputFile file(path.c_str(), 0);
  const Imath::Box2i crop = file.header().dataWindow();
  const size_t width = size_t(crop.max.x - crop.min.x + 1);
  const size_t height = size_t(crop.max.y - crop.min.y + 1);
  std::vector<float> values(width * height, -1.0f);
  Imf::FrameBuffer buffer;
  char* const origin = reinterpret_cast<char*>(values.data()) -
                       4 * (ptrdiff_t(crop.min.x) + ptrdiff_t(crop.min.y) * ptrdiff_t(width));
  buffer.insert(name, Imf::Slice(Imf::FLOAT, origin, 4, 4 * width));
  file.setFrameBuffer(buffer);
  file.readPixels(crop.min.y, crop.max.y);
  return values;
}

ExrHeader cropped_header() {
  ExrHeader header;
  header.width = 200;
  header.height = 150;
  header.data_window = {13, 21, 150, 102};  // not a multiple of the tile size
  header.tile_size = 32;
  header.channels = {{"R"},        {"G"}, {"B"}, {"A"}, {"samples", ChannelType::kUint},
                     {"albedo.R"}, {"Z"}};
  header.attributes = {{"emberline.seed", "7"}, {"emberline.command", "a \"b\"\nc"}};
  return header;
}

TEST_F(ExrWriterTest, TilesInRandomOrderReadBack) {
  const ExrHeader header = cropped_header();
  std::vector<Rect> tiles = tiles_of(header);
  std::shuffle(tiles.begin(), tiles.end(), std::mt19937(3));
  ExrWriter writer(path("a.exr"), header);
  for (const Rect& rect : tiles) writer.write_tile(rect, tile_pixels(header, rect));
  writer.finish();
  EXPECT_EQ(contents(), std::vector<std::string>{"a.exr"});

  for (size_t c = 0; c < header.channels.size(); ++c) {
    const std::vector<float> values = read_channel(path("a.exr"), header.channels[c].name);
    size_t i = 0;
    for (int y = header.data_window.y0; y < header.data_window.y1; ++y) {
      for (int x = header.data_window.x0; x < header.data_window.x1; ++x, ++i) {
        ASSERT_EQ(values[i], expected_value(x, y, c))
            << header.channels[c].name << " at " << x << "," << y;
      }
    }
  }
}

// Some tiles compress to exactly their own size. Readers take such tiles for uncompressed data.
TEST_F(ExrWriterTest, TilesThatHardlyCompressReadBack) {
  ExrHeader header;
  header.width = header.height = 512;
  header.data_window = {0, 0, 512, 512};
  header.tile_size = 8;
  header.channels = {{"Z"}};
  std::mt19937 random(7);
  std::vector<float> pixels(512 * 512);
  const std::vector<Rect> tiles = tiles_of(header);
  for (size_t t = 0; t < tiles.size(); ++t) {
    for (int i = 0; i < 64; ++i) {
      // The more equal values a tile has, the shorter its code.
      const bool noisy = i >= int(t % 16);
      const int x = tiles[t].x0 + i % 8, y = tiles[t].y0 + i / 8;
      pixels[size_t(y) * 512 + size_t(x)] =
          noisy ? std::bit_cast<float>(uint32_t(random()) & 0xbfffffffu) : 1.0f;
    }
  }
  for (const NamedValue<ExrCompression>& compression : exr_compression_table()) {
    if (is_lossy(compression.value)) continue;
    header.compression = compression.value;
    write_exr_file(path("a.exr"), header, pixels);
    EXPECT_TRUE(read_channel(path("a.exr"), "Z") == pixels) << compression.name;
  }
}

TEST_F(ExrWriterTest, HeaderDescribesTheFrame) {
  const ExrHeader header = cropped_header();
  ExrWriter writer(path("a.exr"), header);
  writer.finish();

  bool tiled = false, deep = false, multi_part = false;
  ASSERT_TRUE(Imf::isOpenExrFile(path("a.exr").c_str(), tiled, deep, multi_part));
  EXPECT_TRUE(tiled);
  EXPECT_FALSE(deep);
  EXPECT_FALSE(multi_part);
  Imf::TiledInputFile file(path("a.exr").c_str(), 0);
  const Imf::Header& read = file.header();
  EXPECT_EQ(read.dataWindow(), Imath::Box2i({13, 21}, {149, 101}));
  EXPECT_EQ(read.displayWindow(), Imath::Box2i({0, 0}, {199, 149}));
  EXPECT_EQ(read.pixelAspectRatio(), 1.0f);
  EXPECT_EQ(read.lineOrder(), Imf::RANDOM_Y);
  EXPECT_EQ(read.compression(), Imf::ZIP_COMPRESSION);
  EXPECT_EQ(file.levelMode(), Imf::ONE_LEVEL);
  EXPECT_EQ(file.tileXSize(), 32u);
  EXPECT_EQ(file.tileYSize(), 32u);
  ASSERT_TRUE(Imf::hasChromaticities(read));
  EXPECT_EQ(Imf::chromaticities(read).red, Imath::V2f(0.64f, 0.33f));
  EXPECT_EQ(Imf::chromaticities(read).white, Imath::V2f(0.3127f, 0.3290f));
  EXPECT_EQ(read.typedAttribute<Imf::StringAttribute>("emberline.seed").value(), "7");
  EXPECT_EQ(read.typedAttribute<Imf::StringAttribute>("emberline.command").value(), "a \"b\"\nc");
  EXPECT_EQ(read.channels().findChannel("R")->type, Imf::FLOAT);
  EXPECT_EQ(read.channels().findChannel("samples")->type, Imf::UINT);
  EXPECT_EQ(read.channels().findChannel("Z")->type, Imf::FLOAT);
  EXPECT_TRUE(file.isComplete());
}

TEST_F(ExrWriterTest, AttributesThatAreKnownAtTheEnd) {
  ExrHeader header = cropped_header();
  header.attributes = {{"first", "one"},
                       {"emberline:complete", "false"},
                       {"emberline:samples", std::string(8, ' ')},
                       {"last", "emberline:complete"}};
  ExrWriter writer(path("a.exr"), header);
  for (const Rect& rect : tiles_of(header)) writer.write_tile(rect, tile_pixels(header, rect));
  writer.set_attribute("emberline:samples", "1234");
  writer.set_attribute("emberline:complete", "true");
  writer.finish();
  Imf::TiledInputFile file(path("a.exr").c_str());
  const auto value = [&](const char* name) {
    return file.header().typedAttribute<Imf::StringAttribute>(name).value();
  };
  EXPECT_EQ(value("first"), "one");
  EXPECT_EQ(value("emberline:complete"), "true ");
  EXPECT_EQ(value("emberline:samples"), "1234    ");
  EXPECT_EQ(value("last"), "emberline:complete");
}

TEST_F(ExrWriterTest, MissingTilesAreZero) {
  const ExrHeader header = cropped_header();
  const std::vector<Rect> tiles = tiles_of(header);
  ExrWriter writer(path("a.exr"), header);
  writer.write_tile(tiles[4], tile_pixels(header, tiles[4]));
  writer.finish();
  const std::vector<float> values = read_channel(path("a.exr"), "Z");
  size_t i = 0;
  for (int y = header.data_window.y0; y < header.data_window.y1; ++y) {
    for (int x = header.data_window.x0; x < header.data_window.x1; ++x, ++i) {
      ASSERT_EQ(values[i], tiles[4].contains(x, y) ? expected_value(x, y, 6) : 0.0f);
    }
  }
}

TEST_F(ExrWriterTest, ValuesOutsideTheChannelType) {
  ExrHeader header;
  header.width = header.height = 4;
  header.data_window = {0, 0, 4, 4};
  header.tile_size = 4;
  header.channels = {{"u", ChannelType::kUint}};
  std::vector<float> pixels = {-3.0f, 2.5f, 16777216.0f, 1e12f,
                               std::numeric_limits<float>::quiet_NaN()};
  pixels.resize(16);
  ExrWriter writer(path("a.exr"), header);
  writer.write_tile(header.data_window, pixels);
  writer.finish();
  const std::vector<float> u = read_channel(path("a.exr"), "u");
  EXPECT_EQ(u[0], 0.0f);
  EXPECT_EQ(u[1], 3.0f);
  EXPECT_EQ(u[2], 16777216.0f);
  EXPECT_EQ(u[3], 4294967296.0f);  // 2^32 - 1 as float
  EXPECT_EQ(u[4], 0.0f);
}

TEST_F(ExrWriterTest, ManyThreadsWriteAtOnce) {
  ExrHeader header = cropped_header();
  header.tile_size = 8;
  const std::vector<Rect> tiles = tiles_of(header);
  ExrWriter writer(path("a.exr"), header);
  std::vector<std::thread> threads;
  for (size_t t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (size_t i = t; i < tiles.size(); i += 4) {
        writer.write_tile(tiles[i], tile_pixels(header, tiles[i]));
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  writer.finish();
  const std::vector<float> values = read_channel(path("a.exr"), "albedo.R");
  size_t i = 0;
  for (int y = header.data_window.y0; y < header.data_window.y1; ++y) {
    for (int x = header.data_window.x0; x < header.data_window.x1; ++x, ++i) {
      ASSERT_EQ(values[i], expected_value(x, y, 5));
    }
  }
}

TEST_F(ExrWriterTest, IncompressibleAndLongNames) {
  ExrHeader header;
  header.width = header.height = 64;
  header.data_window = {0, 0, 64, 64};
  const std::string long_name = "a.channel.whose.name.is.longer.than.31.letters";
  header.channels = {{long_name, ChannelType::kFloat}};
  header.attributes = {{"an.attribute.whose.name.is.long.too", "x"}};
  std::vector<float> pixels(64 * 64);
  std::mt19937 random(5);
  for (float& value : pixels) {
    // The bits are those of random finite numbers, so this is noise that ZIP can only store.
    const uint32_t bits = uint32_t(random()) & 0xbfffffffu;
    std::memcpy(&value, &bits, 4);
  }
  ExrWriter writer(path("a.exr"), header);
  writer.write_tile(header.data_window, pixels);
  writer.finish();
  EXPECT_EQ(read_channel(path("a.exr"), long_name), pixels);
}

TEST_F(ExrWriterTest, ReplacesTheOldFileOnlyWhenFinished) {
  { std::ofstream(path("a.exr")) << "old"; }
  const ExrHeader header = cropped_header();
  {
    ExrWriter writer(path("a.exr"), header);
    writer.write_tile(tiles_of(header)[0], tile_pixels(header, tiles_of(header)[0]));
    EXPECT_EQ(read_text(path("a.exr")), "old");
    EXPECT_EQ(contents().size(), 2u);
  }
  EXPECT_EQ(contents(), std::vector<std::string>{"a.exr"});
  EXPECT_EQ(read_text(path("a.exr")), "old");
  ExrWriter writer(path("a.exr"), header);
  writer.finish();
  EXPECT_EQ(read_text(path("a.exr")).substr(0, 4), "\x76\x2f\x31\x01");
  EXPECT_EQ(contents(), std::vector<std::string>{"a.exr"});
}

TEST_F(ExrWriterTest, UnusableTargets) {
  const ExrHeader header = cropped_header();
  fs::create_directory(path("folder.exr"));
  expect_error<RenderError>([&] { ExrWriter(path("folder.exr"), header); }, "it is a folder");
  expect_error<RenderError>([&] { ExrWriter(path("missing/a.exr"), header); },
                            "missing does not exist");
  expect_error<RenderError>([&] { ExrWriter("/dev/null", header); }, "not a regular file");
  expect_error<RenderError>([&] { ExrWriter("", header); }, "empty");
  expect_error<RenderError>([&] { ExrWriter("/proc/a.exr", header); }, "/proc");
  EXPECT_EQ(contents(), std::vector<std::string>{"folder.exr"});
  if (geteuid() != 0) {
    fs::permissions(folder_, fs::perms::owner_read | fs::perms::owner_exec);
    expect_error<RenderError>([&] { ExrWriter(path("a.exr"), header); }, "Permission denied");
    fs::permissions(folder_, fs::perms::owner_all);
  }
}

// Simulates a full disk by a limit on the file size, which makes the same writes fail.
class LimitedFileSize {
 public:
  explicit LimitedFileSize(rlim_t bytes) {
    old_handler_ = std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &old_limit_);
    const rlimit limit = {bytes, old_limit_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~LimitedFileSize() {
    setrlimit(RLIMIT_FSIZE, &old_limit_);
    std::signal(SIGXFSZ, old_handler_);
  }

 private:
  rlimit old_limit_ = {};
  void (*old_handler_)(int) = nullptr;
};

TEST_F(ExrWriterTest, FullDiskIsOneErrorAndLeavesNothing) {
  const ExrHeader header = cropped_header();
  const std::vector<Rect> tiles = tiles_of(header);
  for (const rlim_t limit : {rlim_t(100), rlim_t(1500), rlim_t(9000)}) {
    const LimitedFileSize limited(limit);
    expect_error<RenderError>(
        [&] {
          ExrWriter writer(path("a.exr"), header);
          for (const Rect& rect : tiles) writer.write_tile(rect, tile_pixels(header, rect));
          writer.finish();
        },
        "a.exr: File too large");
    EXPECT_TRUE(contents().empty()) << limit;
  }
}

TEST_F(ExrWriterTest, AfterAFailureEveryCallFails) {
  const ExrHeader header = cropped_header();
  const std::vector<Rect> tiles = tiles_of(header);
  ExrWriter writer(path("a.exr"), header);
  {
    const LimitedFileSize limited(2000);
    expect_error<RenderError>([&] { writer.write_tile(tiles[0], tile_pixels(header, tiles[0])); },
                              "too large");
  }
  // Space is available again, but the file has a hole, so it must not count as complete.
  expect_error<RenderError>([&] { writer.write_tile(tiles[1], tile_pixels(header, tiles[1])); },
                            "too large");
  expect_error<RenderError>([&] { writer.finish(); }, "too large");
  EXPECT_FALSE(fs::exists(path("a.exr")));
}

// Memory does not grow with the frame. The frame's 2048 x 2048 pixels of 20 bytes are 84 MB.
TEST_F(ExrWriterTest, MemoryDoesNotGrowWithTheFrame) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers hold on to freed memory";
#endif
  ExrHeader header;
  header.width = header.height = 2048;
  header.data_window = {0, 0, 2048, 2048};
  header.channels = {{"R"}, {"G"}, {"B"}, {"A"}, {"samples", ChannelType::kUint}};
  const std::vector<Rect> tiles = tiles_of(header);
  const std::vector<float> pixels = tile_pixels(header, tiles[0]);
  rusage before = {}, after = {};
  ExrWriter writer(path("a.exr"), header);
  writer.write_tile(tiles[0], pixels);  // one-time allocations are done now
  getrusage(RUSAGE_SELF, &before);
  for (size_t i = 1; i < tiles.size(); ++i) writer.write_tile(tiles[i], pixels);
  writer.finish();
  getrusage(RUSAGE_SELF, &after);
  EXPECT_LT(after.ru_maxrss - before.ru_maxrss, 8 * 1024) << "KiB";
}

TEST_F(ExrWriterTest, SaysWhereAndWhen) {
  ExrHeader header = cropped_header();
  ExrView::Matrices camera = {};
  for (size_t i = 0; i < 16; ++i) camera.world_to_camera[i] = float(i);
  camera.world_to_ndc[11] = -2.5f;
  header.view = {camera, frame_rate_fraction(24000.0 / 1001), smpte_time_code(108001, 30)};
  ExrWriter(path("view.exr"), header).finish();
  const Imf::InputFile file(path("view.exr").c_str());
  EXPECT_EQ(Imf::worldToCamera(file.header())[1][2], 6.0f);
  EXPECT_EQ(Imf::worldToNDC(file.header())[2][3], -2.5f);
  EXPECT_EQ(Imf::framesPerSecond(file.header()), Imf::Rational(24000, 1001));
  const Imf::TimeCode code = Imf::timeCode(file.header());
  EXPECT_EQ(code.hours(), 1);
  EXPECT_EQ(code.minutes(), 0);
  EXPECT_EQ(code.seconds(), 0);
  EXPECT_EQ(code.frame(), 1);
  EXPECT_FALSE(code.dropFrame());
}

TEST_F(ExrWriterTest, HasNoTimeCodeOutsideItsRange) {
  EXPECT_EQ(smpte_time_code(24 * 3600 * 24 - 1, 24), 0x23595923u);
  EXPECT_EQ(smpte_time_code(24 * 3600 * 24, 24), std::nullopt);
  EXPECT_EQ(smpte_time_code(-1, 24), std::nullopt);
  EXPECT_EQ(smpte_time_code(0, 60), std::nullopt);
  EXPECT_EQ(smpte_time_code(0, std::numeric_limits<double>::quiet_NaN()), std::nullopt);
}

ExrHeader layered_header() {
  ExrHeader header = cropped_header();
  header.channels = {{"R"},
                     {"G"},
                     {"B"},
                     {"A"},
                     {"samples", ChannelType::kUint},
                     {"albedo.R", ChannelType::kHalf},
                     {"albedo.G", ChannelType::kHalf},
                     {"albedo.B", ChannelType::kHalf},
                     {"Z"},
                     {"CryptoObject00.R"},
                     {"CryptoObject00.G"},
                     {"N.X"},
                     {"N.Y"},
                     {"light.key.R"}};
  return header;
}

// Reads with OpenEXR's multi-part reader. The values of tile_pixels() are exact in half floats.
void expect_layers(const std::string& path, const ExrHeader& header, double lossy_error) {
  Imf::MultiPartInputFile file(path.c_str());
  std::map<std::string, std::string> part_of;
  for (int p = 0; p < file.parts(); ++p) {
    Imf::InputPart part(file, p);
    const Imf::Header& read = part.header();
    if (file.parts() > 1) {
      ASSERT_TRUE(read.hasName() && read.hasType() && read.hasChunkCount());
      EXPECT_EQ(read.type(), "tiledimage");
    }
    const Imath::Box2i crop = read.dataWindow();
    const int width = crop.max.x - crop.min.x + 1, height = crop.max.y - crop.min.y + 1;
    for (auto i = read.channels().begin(); i != read.channels().end(); ++i) {
      if (file.parts() > 1) part_of[i.name()] = read.name();
      std::vector<float> values(size_t(width) * size_t(height), -1.0f);
      Imf::FrameBuffer buffer;
      buffer.insert(i.name(),
                    Imf::Slice::Make(Imf::FLOAT, values.data(), crop, 4, 4 * size_t(width)));
      part.setFrameBuffer(buffer);
      part.readPixels(crop.min.y, crop.max.y);
      const auto channel = std::ranges::find(header.channels, i.name(), &PictureChannel::name);
      ASSERT_NE(channel, header.channels.end()) << i.name();
      const auto c = size_t(channel - header.channels.begin());
      const Imf::PixelType type = channel->type == ChannelType::kHalf   ? Imf::HALF
                                  : channel->type == ChannelType::kUint ? Imf::UINT
                                                                        : Imf::FLOAT;
      EXPECT_EQ(i.channel().type, type) << i.name();
      const bool exact =
          !(is_lossy(header.compression) && is_colour(channel->name)) || channel->name == "A";
      double worst = 0;
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          const double wanted = double(expected_value(crop.min.x + x, crop.min.y + y, c));
          const double found = double(values[size_t(y * width + x)]);
          worst = std::max(worst, std::abs(found - wanted) / (1 + wanted));
        }
      }
      EXPECT_LE(worst, exact ? 0.0 : lossy_error) << i.name();
    }
  }
  if (file.parts() == 1) return;
  for (const PictureChannel& channel : header.channels) {
    EXPECT_EQ(part_of[channel.name], layer_of(channel.name));
  }
  EXPECT_EQ(part_of["G"], "RGBA");
  EXPECT_EQ(part_of["light.key.R"], "light.key");
}

TEST_F(ExrWriterTest, PartsTypesAndCompressions) {
  for (const NamedValue<ExrParts>& parts : exr_parts_table()) {
    for (const NamedValue<ExrCompression>& compression : exr_compression_table()) {
      ExrHeader header = layered_header();
      header.parts = parts.value;
      header.compression = compression.value;
      if (is_lossy(compression.value) && parts.value == ExrParts::kOne) {
        std::erase_if(header.channels, [](const PictureChannel& channel) {
          return channel.name.starts_with("Crypto") || channel.name.starts_with("N.");
        });
      }
      SCOPED_TRACE(testing::Message() << parts.name << ", " << compression.name);
      std::vector<Rect> tiles = tiles_of(header);
      std::shuffle(tiles.begin(), tiles.end(), std::mt19937(3));
      ExrWriter writer(path("a.exr"), header);
      std::vector<std::thread> threads;
      for (size_t t = 0; t < 3; ++t) {
        threads.emplace_back([&, t] {
          for (size_t i = t; i < tiles.size(); i += 3) {
            writer.write_tile(tiles[i], tile_pixels(header, tiles[i]));
          }
        });
      }
      for (std::thread& thread : threads) thread.join();
      writer.set_attribute("emberline.seed", "8");
      writer.finish();
      expect_layers(path("a.exr"), header, 0.3);
      if (HasFailure()) return;
      Imf::MultiPartInputFile file(path("a.exr").c_str());
      EXPECT_EQ(file.header(0).typedAttribute<Imf::StringAttribute>("emberline.seed").value(), "8");
    }
  }
}

// With lossy compression, a part with ids or vectors is still lossless, and so is a file of a
// single part.
TEST_F(ExrWriterTest, NumbersAreNeverBlurred) {
  ExrHeader header = layered_header();
  header.compression = ExrCompression::kDwaa;
  for (const ExrParts parts : {ExrParts::kOne, ExrParts::kLayers}) {
    header.parts = parts;
    ExrWriter writer(path("a.exr"), header);
    for (const Rect& rect : tiles_of(header)) writer.write_tile(rect, tile_pixels(header, rect));
    writer.finish();
    Imf::MultiPartInputFile file(path("a.exr").c_str());
    for (int p = 0; p < file.parts(); ++p) {
      const Imf::Header& read = file.header(p);
      const bool colour =
          parts == ExrParts::kLayers && !read.name().starts_with("Crypto") && read.name() != "N";
      EXPECT_EQ(read.compression(), colour ? Imf::DWAA_COMPRESSION : Imf::ZIP_COMPRESSION);
    }
  }
}

TEST_F(ExrWriterTest, HalvesStayFinite) {
  ExrHeader header = cropped_header();
  header.data_window = {0, 0, 4, 1};
  header.channels = {{"Z", ChannelType::kHalf}};
  write_exr_file(path("h.exr"), header, std::vector<float>{1e10f, -1e10f, 65519.0f, 1.0f / 3});
  EXPECT_EQ(read_channel(path("h.exr"), "Z"),
            (std::vector<float>{65504.0f, -65504.0f, 65504.0f, float(Imath::half(1.0f / 3))}));
}

TEST_F(ExrWriterTest, PartsNeverWrittenAreBlack) {
  ExrHeader header = layered_header();
  header.parts = ExrParts::kLayers;
  header.compression = ExrCompression::kDwab;
  const std::vector<Rect> tiles = tiles_of(header);
  ExrWriter writer(path("a.exr"), header);
  writer.write_tile(tiles[4], tile_pixels(header, tiles[4]));
  writer.finish();
  Imf::MultiPartInputFile file(path("a.exr").c_str());
  for (int p = 0; p < file.parts(); ++p) EXPECT_TRUE(file.partComplete(p));
}

}  // namespace
}  // namespace emberline
