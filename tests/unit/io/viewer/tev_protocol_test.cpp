// Compares packets byte by byte with tev's published layout, and tests the supported addresses.
#include "io/viewer/tev_protocol.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "renderer/core/errors.h"

namespace emberline {
namespace {

using namespace std::string_literals;  // "..."s keeps embedded zeros

std::string text(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

TEST(TevPackets, CreateImage) {
  const std::string expected =
      "\x20\0\0\0"      // in total: 4 + 1 + 1 + 6 + 4 + 4 + 4 + 8 bytes
      "\x04"            // CreateImage
      "\x01"            // bring to the front
      "a.exr\0"         // name
      "\x00\x05\0\0"    // width 1280
      "\xd0\x02\0\0"    // height 720
      "\x04\0\0\0"      // channels
      "R\0G\0B\0A\0"s;  // their names
  EXPECT_EQ(text(tev_create_image("a.exr", 1280, 720)), expected);
}

TEST(TevPackets, UpdateImage) {
  // The layout has 3 x 2 pixels from (600, 7). Its pixel (x', y') has the values 10 x' + y' + c /
  // 4.
  const Rect layout{600, 7, 603, 9};
  std::vector<float> rgba;
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 3; ++x) {
      for (int c = 0; c < 4; ++c) rgba.push_back(float(10 * x + y) + 0.25f * float(c));
    }
  }
  const std::string expected =
      "\x84\0\0\0"              // in total: 4 + 1 + 1 + 2 + 4 + 8 + 16 + 32 + 32 + 2 x 16 bytes
      "\x06"                    // UpdateImage with strides
      "\0"                      // do not bring to the front
      "p\0"                     // name
      "\x04\0\0\0"              // channels
      "R\0G\0B\0A\0"            // their names
      "\x59\x02\0\0\x08\0\0\0"  // at (601, 8)
      "\x02\0\0\0\x01\0\0\0"    // 2 x 1 pixels
      "\0\0\0\0\0\0\0\0"        // offsets 0 1 2 3
      "\x01\0\0\0\0\0\0\0"
      "\x02\0\0\0\0\0\0\0"
      "\x03\0\0\0\0\0\0\0"
      "\x04\0\0\0\0\0\0\0"  // strides 4 4 4 4
      "\x04\0\0\0\0\0\0\0"
      "\x04\0\0\0\0\0\0\0"
      "\x04\0\0\0\0\0\0\0"
      "\0\0\x30\x41\0\0\x34\x41"    // 11, 11.25: 0x41300000, 0x41340000
      "\0\0\x38\x41\0\0\x3c\x41"    // 11.5, 11.75
      "\0\0\xa8\x41\0\0\xaa\x41"    // 21, 21.25
      "\0\0\xac\x41\0\0\xae\x41"s;  // 21.5, 21.75
  EXPECT_EQ(text(tev_update_image("p", {601, 8, 603, 9}, rgba, layout)), expected);
}

TEST(TevPackets, UpdateOfSeveralRows) {
  const Rect layout{0, 0, 3, 3};
  std::vector<float> rgba(36);
  for (size_t i = 0; i < rgba.size(); ++i) rgba[i] = float(i);
  const std::string packet = text(tev_update_image("p", {1, 1, 2, 3}, rgba, layout));
  std::vector<float> sent(8);
  ASSERT_EQ(packet.size(), 100u + 32u);
  std::copy_n(packet.data() + 100, 32, reinterpret_cast<char*>(sent.data()));
  EXPECT_EQ(sent, (std::vector<float>{16, 17, 18, 19, 28, 29, 30, 31}));
}

TEST(TevUrl, HostsAndPorts) {
  EXPECT_EQ(parse_tev_url("tev://localhost"), (TevAddress{"localhost", 14158}));
  EXPECT_EQ(parse_tev_url("tev://render-7.lan_a:80"), (TevAddress{"render-7.lan_a", 80}));
  EXPECT_EQ(parse_tev_url("TEV://127.0.0.1:65535"), (TevAddress{"127.0.0.1", 65535}));
  EXPECT_EQ(parse_tev_url("tev://[::1]:1"), (TevAddress{"::1", 1}));
  EXPECT_EQ(parse_tev_url("tev://[fe80::1%eth0]"), (TevAddress{"fe80::1%eth0", 14158}));
}

TEST(TevUrl, RoundTrips) {
  for (const char* url : {"tev://localhost:14158", "tev://[::1]:9", "tev://10.0.0.1:700"}) {
    EXPECT_EQ(parse_tev_url(url).url(), url);
  }
}

TEST(TevUrl, MalformedOnesNameTheValidForm) {
  for (const char* url : {"tev:",
                          "tev:/",
                          "tev://",
                          "tev:host",
                          "tev:/host:1",
                          "tev://:14158",
                          "tev://host:",
                          "tev://host:0",
                          "tev://host:65536",
                          "tev://host:99999",
                          "tev://host:-1",
                          "tev://host:+1",
                          "tev://host:1x",
                          "tev://host:0x10",
                          "tev://host: 1",
                          "tev://host/",
                          "tev://host:1/",
                          "tev://ho st",
                          "tev://user@host",
                          "tev://::1",
                          "tev://::1:14158",
                          "tev://[::1",
                          "tev://[]",
                          "tev://[]:1",
                          "tev://[host]",
                          "tev://[127.0.0.1]",
                          "tev://[::1]1",
                          "tev://[::1]]:1",
                          "tev://[::1%]",
                          "tev://[12345::]"}) {
    ASSERT_TRUE(is_tev_url(url));
    try {
      parse_tev_url(url);
      ADD_FAILURE() << url << " is taken";
    } catch (const UsageError& error) {
      const std::string message = error.what();
      EXPECT_NE(message.find("tev://HOST:PORT"), std::string::npos) << message;
      EXPECT_NE(message.find("'"s + url + "'"), std::string::npos) << message;
    }
  }
}

TEST(TevUrl, OpenColorIODisplaysAreNotUrls) {
  for (const char* name : {"", "sRGB", "te", "tev", "Rec.2020", "ACES tev:"}) {
    EXPECT_FALSE(is_tev_url(name)) << name;
  }
  EXPECT_TRUE(is_tev_url("Tev:x"));
}

}  // namespace
}  // namespace emberline
