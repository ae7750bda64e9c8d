#include "renderer/window/input/edit_latency.h"

#include <gtest/gtest.h>

#include <cmath>

namespace emberline {
namespace {

SessionPicture picture_of(uint64_t edit, bool filled, bool complete) {
  SessionPicture picture;
  picture.edit = edit;
  picture.filled = filled;
  picture.complete = complete;
  return picture;
}

TEST(EditLatency, CountsToTheFirstPictureThatIsFilled) {
  EditLatency latency;
  latency.add_edit(5, "orbit", 10.0);
  latency.displayed(picture_of(5, false, false), 10.01);
  EXPECT_FALSE(latency.newest_s());
  latency.displayed(picture_of(5, true, false), 10.02);
  latency.displayed(picture_of(5, true, true), 10.5);
  latency.displayed(picture_of(5, true, true), 11.0);
  ASSERT_EQ(latency.edits().size(), 1u);
  EXPECT_DOUBLE_EQ(*latency.edits()[0].filled_s, 10.02);
  EXPECT_DOUBLE_EQ(*latency.edits()[0].complete_s, 10.5);
  EXPECT_NEAR(*latency.newest_s(), 0.02, 1e-12);
}

TEST(EditLatency, PicturesOfEarlierEditsDoNotCount) {
  EditLatency latency;
  latency.add_edit(5, "orbit", 10.0);
  latency.displayed(picture_of(4, true, true), 10.01);
  EXPECT_FALSE(latency.edits()[0].filled_s);
}

TEST(EditLatency, APictureOfALaterEditShowsTheEarlierOnes) {
  EditLatency latency;
  latency.add_edit(5, "orbit", 10.0);
  latency.add_edit(6, "orbit", 10.1);
  latency.add_edit(7, "orbit", 10.2);
  latency.displayed(picture_of(6, true, false), 10.3);
  EXPECT_DOUBLE_EQ(*latency.edits()[0].filled_s, 10.3);
  EXPECT_DOUBLE_EQ(*latency.edits()[1].filled_s, 10.3);
  EXPECT_FALSE(latency.edits()[2].filled_s);
  latency.displayed(picture_of(7, true, true), 10.4);
  EXPECT_DOUBLE_EQ(*latency.edits()[0].complete_s, 10.4);
  EXPECT_DOUBLE_EQ(*latency.edits()[2].filled_s, 10.4);
}

TEST(Quantile, AgainstValuesOfTheDefinition) {
  EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
  EXPECT_EQ(quantile({3.0}, 0.95), 3.0);
  EXPECT_EQ(quantile({4.0, 1.0, 2.0, 3.0}, 0.5), 2.5);
  EXPECT_EQ(quantile({4.0, 1.0, 2.0, 3.0}, 0.0), 1.0);
  EXPECT_EQ(quantile({4.0, 1.0, 2.0, 3.0}, 1.0), 4.0);
  EXPECT_DOUBLE_EQ(quantile({0.0, 10.0, 20.0}, 0.95), 19.0);
}

}  // namespace
}  // namespace emberline
