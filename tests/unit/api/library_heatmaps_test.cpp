#include <gtest/gtest.h>

#include <algorithm>

#include "renderer/api/emberline.h"

namespace emberline::api {
namespace {

class LibraryHeatmaps : public ::testing::Test {
 protected:
  Picture frame() {
    Settings settings;
    settings.set("size", "16x16").set("max-depth", "3").set("driver", "adaptive");
    settings.set("noise-threshold", "0.05").set("max-spp", "64");
    const Scene scene(EMBERLINE_SCENES "/cornell_box.glb", settings);
    return render(scene, settings);
  }
};

TEST_F(LibraryHeatmaps, ShowTheChannelsOfThePicture) {
  const Picture picture = frame();
  const std::vector<float> values = heatmap_values(picture);
  ASSERT_EQ(values.size(), 16u * 16);
  EXPECT_EQ(values[5], picture.pixel(5, 0)[4]);
  HeatmapLook look;
  look.plain = true;
  const DisplayedPicture plain = heatmap(picture, "samples", look);
  EXPECT_EQ(plain.width, 16);
  EXPECT_EQ(plain.height, 16);
  ASSERT_EQ(plain.values.size(), 3u * 16 * 16);
  const auto most = size_t(std::ranges::max_element(values) - values.begin());
  const auto least = size_t(std::ranges::min_element(values) - values.begin());
  EXPECT_GT(plain.values[3 * most], plain.values[3 * least]) << "brighter is more";
  EXPECT_EQ(plain.values[3 * most], plain.values[3 * most + 1]) << "grey";
  EXPECT_GT(heatmap(picture).height, 16) << "with its legend";
  look.range = std::pair(0.0, 1e6);
  const DisplayedPicture narrow = heatmap(picture, "samples", look);
  EXPECT_LT(narrow.values[3 * most], 4);
}

TEST_F(LibraryHeatmaps, ErrorsNameTheMissingChannel) {
  const Picture picture = frame();
  EXPECT_THROW(heatmap(picture, "heat"), UsageError);
  HeatmapLook look;
  look.colors = "red";
  EXPECT_THROW(heatmap(picture, "samples", look), UsageError);
  look = {};
  look.range = std::pair(2.0, 1.0);
  EXPECT_THROW(heatmap(picture, "samples", look), UsageError);
  EXPECT_THROW(heatmap(Picture()), UsageError);
  try {
    heatmap_values(picture, "error");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("render it with aov variance"), std::string::npos)
        << error.what();
  }
  const std::vector<HeatmapKind> kinds = heatmap_kinds();
  EXPECT_EQ(kinds.front().name, "samples");
  EXPECT_EQ(kinds.front().channels, std::vector<std::string>{"samples"});
}

}  // namespace
}  // namespace emberline::api
