// KTX 2 files that are truncated, have flipped bits, or announce sizes beyond their data.
#include <gtest/gtest.h>

#include <random>

#include "io/image/input.h"
#include "renderer/core/errors.h"
#include "support/ktx2_files.h"

namespace emberline {
namespace {

using Ktx2File = std::vector<uint8_t>;

// Decodes `bytes` within `limit` bytes of memory. Returns the error's message, or "" if there is no
// error. The only exception allowed is an InputError with one line.
std::string decode_limited(std::span<const uint8_t> bytes, uint64_t limit) {
  const auto budget = std::make_shared<MemoryBudget>(limit);
  const LoadProgress progress({}, {}, {budget, std::nullopt, "scene"});
  try {
    const auto image = decode_image(bytes, "place", false, progress).image;
    EXPECT_EQ(image->texels.size(),
              size_t(image->width) * size_t(image->height) * size_t(image->channels));
    return "";
  } catch (const InputError& error) {
    EXPECT_EQ(std::string_view(error.what()).find('\n'), std::string_view::npos) << error.what();
    return error.what();
  }
}

constexpr uint64_t kSufficientMemory = uint64_t(4) << 20;

// Levels are stored from the smallest to the largest, so every byte is needed.
TEST(HostileKtx2, EveryPrefixIsRefused) {
  for (const std::string name : test::kKtx2Files) {
    const Ktx2File whole = test::ktx2_file(name);
    ASSERT_EQ(decode_limited(whole, kSufficientMemory), "") << name;
    for (size_t size = 0; size < whole.size(); ++size) {
      // Copies the bytes, so that AddressSanitizer detects reads past their end.
      const Ktx2File bytes(whole.begin(), whole.begin() + std::ptrdiff_t(size));
      ASSERT_NE(decode_limited(bytes, kSufficientMemory), "") << name << ", " << size << " bytes";
    }
  }
}

// Half of the flips hit the first kilobyte: headers, palettes, Huffman tables.
TEST(HostileKtx2, FlippedBitsAreRefusedOrDecoded) {
  for (const std::string name : test::kKtx2Files) {
    const Ktx2File whole = test::ktx2_file(name);
    for (uint32_t round = 0; round < 400; ++round) {
      std::mt19937 random(round);
      Ktx2File bytes = whole;
      for (auto flips = 1 + random() % 3; flips > 0; --flips) {
        const size_t reach =
            random() % 2 == 0 ? bytes.size() : std::min<size_t>(bytes.size(), 1000);
        const size_t bit = random() % (8 * reach);
        bytes[bit / 8] = uint8_t(bytes[bit / 8] ^ 1 << bit % 8);
      }
      SCOPED_TRACE(name + ", round " + std::to_string(round));
      decode_limited(bytes, kSufficientMemory);
    }
  }
}

TEST(HostileKtx2, SizesAreCheckedAgainstTheBytesAndTheBudget) {
  Ktx2File etc1s = test::ktx2_file("etc1s_odd");
  test::set_word(etc1s, 20, 65536);
  test::set_word(etc1s, 24, 65536);
  EXPECT_NE(decode_limited(etc1s, kSufficientMemory).find("65536 x 65536 pixels do not fit"),
            std::string::npos);
  test::set_word(etc1s, 20, 4096);
  test::set_word(etc1s, 24, 4096);
  EXPECT_NE(decode_limited(etc1s, kSufficientMemory).find("memory"), std::string::npos);

  // This Zstandard frame requests a window of 64 MiB. Byte 5 of its header holds the window's
  // exponent, 16 above 2^10.
  Ktx2File uastc = test::ktx2_file("uastc_gradient");
  const size_t level = test::word_at(uastc, 80);
  ASSERT_EQ(test::word_at(uastc, level), 0xfd2fb528u);
  uastc[level + 4] = 0;
  uastc[level + 5] = 16 << 3;
  EXPECT_NE(decode_limited(uastc, kSufficientMemory).find("memory"), std::string::npos);
  uastc[level + 5] = 31 << 3;
  EXPECT_NE(decode_limited(uastc, kSufficientMemory).find("window"), std::string::npos);
}

TEST(HostileKtx2, HugeOffsetsDoNotOverflow) {
  for (const size_t offset : {48, 52, 56, 60, 64, 68, 72, 76, 80, 84, 88, 92, 96, 100}) {
    for (const std::string name : {"etc1s_odd", "uastc_nozstd"}) {
      if (name == "uastc_nozstd" && (offset == 64 || offset == 68)) continue;  // unused offsets
      for (const uint32_t value : {0xffffffffu, 0xfffffff0u, 0x80000000u}) {
        Ktx2File bytes = test::ktx2_file(name);
        test::set_word(bytes, offset, value);
        EXPECT_NE(decode_limited(bytes, kSufficientMemory), "") << name << " at " << offset;
      }
    }
  }
}

}  // namespace
}  // namespace emberline
