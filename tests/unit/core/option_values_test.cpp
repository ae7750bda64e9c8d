#include "renderer/core/option_values.h"

#include <gtest/gtest.h>

namespace emberline {
namespace {

TEST(OptionValues, SizesHaveBinaryAndDecimalUnits) {
  EXPECT_EQ(parse_size("4096"), 4096u);
  for (const char* text : {"8G", "8g", "8GiB", "8gib"}) {
    EXPECT_EQ(parse_size(text), uint64_t(8) << 30) << text;
  }
  for (const char* text : {"8GB", "8gb", "8000MB", "8000000kB"}) {
    EXPECT_EQ(parse_size(text), 8'000'000'000u) << text;
  }
  EXPECT_EQ(parse_size("1.5M"), 3u << 19);
  EXPECT_EQ(parse_size("1.5MB"), 1'500'000u);
  for (const char* text :
       {"", "B", "iB", "GB", "GiB", "4B", "4iB", "4GBB", "4Gi", "4 GB", "-1GB"}) {
    EXPECT_EQ(parse_size(text), std::nullopt) << text;
  }
}

TEST(OptionValues, SharesMayBePercentages) {
  EXPECT_EQ(parse_share("2%"), 0.02f);
  EXPECT_EQ(parse_share("0.5%"), parse_share("0.005"));
  EXPECT_EQ(parse_share("1"), 1.0f);
  for (const char* text : {"", "%", "2%%", "2 %", "nan%", "1e300%"}) {
    EXPECT_EQ(parse_share(text), std::nullopt) << text;
  }
}

}  // namespace
}  // namespace emberline
