#include "renderer/core/readable.h"

#include <gtest/gtest.h>

#include <limits>

namespace emberline {
namespace {

TEST(Readable, Counts) {
  EXPECT_EQ(readable_count(0), "0");
  EXPECT_EQ(readable_count(999), "999");
  EXPECT_EQ(readable_count(1000), "1,000");
  EXPECT_EQ(readable_count(14745600), "14,745,600");
  EXPECT_EQ(readable_count(std::numeric_limits<uint64_t>::max()), "18,446,744,073,709,551,615");
}

TEST(Readable, SeparatorsStandBetweenThousands) {
  EXPECT_EQ(with_separators("-123"), "-123");
  EXPECT_EQ(with_separators("-1234.5678"), "-1,234.5678");
  EXPECT_EQ(with_separators("0.00012"), "0.00012");
}

TEST(Readable, Numbers) {
  EXPECT_EQ(readable_number(0.03123), "0.0312");
  EXPECT_EQ(readable_number(2.0), "2");
  EXPECT_EQ(readable_number(-1234567.0), "-1,234,567");
  EXPECT_EQ(readable_number(1234.5, 5), "1,234.5");
  EXPECT_EQ(readable_number(999.6), "1,000");
  EXPECT_EQ(readable_number(1.5e-7), "1.5e-07");
  EXPECT_EQ(readable_number(std::numeric_limits<double>::quiet_NaN()), "none");
  EXPECT_EQ(readable_number(-std::numeric_limits<double>::infinity()), "-infinite");
}

TEST(Readable, Bytes) {
  EXPECT_EQ(readable_bytes(640), "640 B");
  EXPECT_EQ(readable_bytes(1023), "1023 B");
  EXPECT_EQ(readable_bytes(1536), "1.5 KiB");
  EXPECT_EQ(readable_bytes(uint64_t(162) << 20), "162 MiB");
  EXPECT_EQ(readable_bytes(uint64_t(1000) << 20), "0.977 GiB");
}

TEST(Readable, Seconds) {
  EXPECT_EQ(readable_seconds(0), "0 s");
  EXPECT_EQ(readable_seconds(0.00082), "820 us");
  EXPECT_EQ(readable_seconds(0.0593), "59.3 ms");
  EXPECT_EQ(readable_seconds(0.99999), "1 s");
  EXPECT_EQ(readable_seconds(12.345), "12.3 s");
  EXPECT_EQ(readable_seconds(59.99), "1 min 0 s");
  EXPECT_EQ(readable_seconds(200), "3 min 20 s");
  EXPECT_EQ(readable_seconds(3599.7), "1 h 00 min");
  EXPECT_EQ(readable_seconds(7505), "2 h 05 min");
}

TEST(Readable, Percent) {
  EXPECT_EQ(readable_percent(0.2534), "25.3 %");
  EXPECT_EQ(readable_percent(0), "0 %");
  EXPECT_EQ(readable_percent(3e-6), "below 0.01 %");
}

}  // namespace
}  // namespace emberline
