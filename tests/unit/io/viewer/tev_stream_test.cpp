// Tests the data that a viewer receives, and streams whose viewer is slow, silent or gone.
#include "io/viewer/tev_stream.h"

#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <vector>

#include "renderer/core/log.h"
#include "support/sanitized.h"
#include "support/tev_server.h"

namespace emberline::test {
namespace {

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Channel c of pixel (x, y) in the n-th version of a picture.
float value(int x, int y, int c, int n) {
  return float(x) + 0.001f * float(y) + 1000.0f * float(c) + 10000.0f * float(n);
}

std::vector<float> pixels(const Rect& rect, int n) {
  std::vector<float> rgba;
  for (int y = rect.y0; y < rect.y1; ++y) {
    for (int x = rect.x0; x < rect.x1; ++x) {
      for (int c = 0; c < 4; ++c) rgba.push_back(value(x, y, c, n));
    }
  }
  return rgba;
}

void expect_version(const TevImage& image, const Rect& rect, int n) {
  constexpr const char* kChannels[] = {"R", "G", "B", "A"};
  for (int y = rect.y0; y < rect.y1; ++y) {
    for (int x = rect.x0; x < rect.x1; ++x) {
      for (int c = 0; c < 4; ++c) {
        ASSERT_EQ(image.at(kChannels[c], x, y), value(x, y, c, n)) << x << "," << y;
      }
    }
  }
}

// Waits until the viewer is connected, or a minute has passed.
bool wait_for_connection(const TevServer& server) {
  for (const double end = seconds() + 60; seconds() < end; ::usleep(1000)) {
    if (server.connected()) return true;
  }
  return false;
}

bool warned_of(const std::string& part) {
  for (const std::string& warning : warnings_so_far()) {
    if (warning.find(part) != std::string::npos) return true;
  }
  return false;
}

TEST(TevStream, TilesArriveAtTheirPlaces) {
  for (const bool ipv6 : {false, true}) {
    TevServer server({.ipv6 = ipv6});
    if (server.port() == 0) continue;  // IPv6 is unavailable
    TevStream stream(parse_tev_url(server.url()), {"name with spaces", 700, 300});
    // One tile is larger than a packet, one has a single pixel, and one is at the edge.
    const Rect tiles[] = {{100, 20, 500, 290}, {3, 4, 4, 5}, {690, 299, 700, 300}};
    for (const Rect& tile : tiles) stream.add(tile, pixels(tile, 1));
    stream.finish({});
    EXPECT_EQ(server.wait(), "");
    ASSERT_EQ(server.images().size(), 1u);
    const TevImage& image = server.images().at("name with spaces");
    EXPECT_EQ(image.width, 700);
    EXPECT_EQ(image.height, 300);
    for (const Rect& tile : tiles) expect_version(image, tile, 1);
    EXPECT_EQ(image.at("R", 99, 20), 0.0f);
    EXPECT_EQ(image.at("G", 500, 20), 0.0f);
    EXPECT_EQ(image.at("A", 4, 4), 0.0f);
  }
}

TEST(TevStream, TheNewestPixelsWin) {
  TevServer server({.reads = false});
  TevStream stream(parse_tev_url(server.url()), {"image", 512, 512});
  ASSERT_TRUE(wait_for_connection(server));
  const Rect crop{32, 16, 512, 500}, tile{96, 80, 160, 144};
  for (int n = 1; n <= 40; ++n) stream.add_picture(crop, 64, pixels(crop, n));
  stream.add(tile, pixels(tile, 41));
  server.start_reading();
  stream.finish({.stalled_s = 60, .total_s = 60});
  EXPECT_EQ(server.wait(), "");
  const TevImage& image = server.image();
  expect_version(image, tile, 41);
  expect_version(image, {32, 16, 512, 80}, 40);
  expect_version(image, {160, 80, 512, 500}, 40);
  // There are 64 tiles in 40 versions, and a queue would send all 2560. The stream sends only 64,
  // and those that the system buffered before (4 MiB, which is at most 64 tiles).
  EXPECT_GE(image.updates.size(), 64u);
  EXPECT_LE(image.updates.size(), 64u + 64u + 1u);
  EXPECT_LE(stream.peak_bytes(), uint64_t(crop.area()) * 16);
}

TEST(TevStream, KeepsOnlyUnsentData) {
  TevServer server;
  TevStream stream(parse_tev_url(server.url()), {"image", 64, 6400});
  ASSERT_TRUE(wait_for_connection(server));
  for (int y = 0; y < 6400; y += 64) {
    stream.add({0, y, 64, y + 64}, pixels({0, y, 64, y + 64}, 1));
    ::usleep(2000);
  }
  stream.finish({});
  EXPECT_EQ(server.wait(), "");
  expect_version(server.image(), {0, 0, 64, 6400}, 1);
  EXPECT_LT(stream.peak_bytes(), uint64_t(64 * 6400) * 16 / 2) << "of a viewer that keeps up";
}

// A blocking call would wait until the test times out.
TEST(TevStream, SlowViewerBlocksNothing) {
  TevServer server({.reads = false});
  TevStream stream(parse_tev_url(server.url()), {"silent", 2048, 2048});
  ASSERT_TRUE(wait_for_connection(server));
  const Rect crop{0, 0, 2048, 2048};
  for (int n = 0; n < 5; ++n) {
    stream.add_picture(crop, 64, pixels(crop, n));
    ::usleep(20000);
  }
  EXPECT_TRUE(stream.open());
  EXPECT_LE(stream.peak_bytes(), uint64_t(crop.area()) * 16);
  stream.finish({.stalled_s = 0.2, .total_s = 1000});
  EXPECT_FALSE(stream.open());
  EXPECT_TRUE(warned_of(server.url() + ": the viewer stopped reading"));
}

TEST(TevStream, PatienceEndsWithASlowReaderToo) {
  TevServer server({.pause_us = 50000});
  TevStream stream(parse_tev_url(server.url()), {"slow", 2048, 2048});
  const Rect crop{0, 0, 2048, 2048};
  stream.add_picture(crop, 64, pixels(crop, 1));
  stream.finish({.stalled_s = 1000, .total_s = 0.3});
  EXPECT_TRUE(warned_of(server.url()));
}

TEST(TevStream, AbandonedItIsGoneAtOnceWithoutAWord) {
  TevServer server({.reads = false});
  {
    TevStream stream(parse_tev_url(server.url()), {"abandoned", 2048, 2048});
    ASSERT_TRUE(wait_for_connection(server));
    const Rect crop{0, 0, 2048, 2048};
    stream.add_picture(crop, 64, pixels(crop, 1));
    ::usleep(200000);  // until the stream is in the middle of sending
  }
  EXPECT_FALSE(warned_of(server.url()));
}

TEST(TevStream, AViewerThatClosesEndsItWithAWarning) {
  TevServer server({.closes_after = 300000});
  TevStream stream(parse_tev_url(server.url()), {"closed", 512, 512});
  const Rect crop{0, 0, 512, 512};
  for (const double end = seconds() + 60; stream.open() && seconds() < end; ::usleep(5000)) {
    stream.add_picture(crop, 64, pixels(crop, 1));
  }
  EXPECT_FALSE(stream.open());
  stream.finish({});  // the stream may close just before the warning appears
  EXPECT_TRUE(warned_of(server.url()));
}

TEST(TevStream, UnreachableHostsAreSoonKnown) {
  std::string free_port;
  {
    TevServer server;
    free_port = std::to_string(server.port());
  }
  for (const std::string& host :
       {std::string("127.0.0.1"), std::string("localhost"), std::string("no-such-host.invalid")}) {
    const std::string url = "tev://" + host + ":" + free_port;
    TevStream stream(parse_tev_url(url), {"unreachable", 16, 16});
    stream.add({0, 0, 16, 16}, pixels({0, 0, 16, 16}, 1));
    stream.finish({.stalled_s = 1000, .total_s = 1000});
    EXPECT_FALSE(stream.open());
    EXPECT_TRUE(warned_of(url)) << url;
  }
}

}  // namespace
}  // namespace emberline::test
