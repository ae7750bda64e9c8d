// Compares the borders and the JSON of a refinement tree with their definitions.
#include "renderer/output/refinement_output.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "unit/refinement_pictures.h"

namespace emberline {
namespace {

// Only the left column and the top row of a leaf change, and only if it has at least two pixels.
// This includes the left and top border of the frame.
TEST(RefinementOutput, BordersAreTheLeaves) {
  const Rect crop = {4, 2, 65, 50};
  constexpr int kStride = 70;  // the picture is wider than the crop
  RefinementTree tree(crop, {.seed = 8});
  std::vector<float> untouched(4 * kStride * 48, 0.25f);
  std::vector<float> picture = untouched;
  draw_leaf_borders(tree, picture, kStride);
  EXPECT_EQ(picture, untouched) << "no leaf yet";
  refine(tree, test_picture, 600);
  draw_leaf_borders(tree, picture, kStride);
  const std::vector<Rect> rects = leaf_rects(tree);
  int drawn = 0;
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < kStride; ++x) {
      const float* const pixel = &picture[size_t(4 * (y * kStride + x))];
      bool expected = false;
      if (x < crop.width()) {
        const Rect& r = rects[tree.leaf_at(x + 4, y + 2)];
        expected = r.area() > 1 && (r.x0 == x + 4 || r.y0 == y + 2);
      }
      ASSERT_EQ(pixel[0] != 0.25f, expected) << x << "," << y;
      ASSERT_EQ(pixel[3], 0.25f) << "alpha";
      if (expected) {
        ASSERT_FLOAT_EQ(pixel[0], 0.5f * (0.25f + 1.0f));
      }
      drawn += expected;
    }
  }
  EXPECT_GT(drawn, 500);
}

TEST(RefinementOutput, JsonDescribesTheTree) {
  RefinementTree tree({4, 2, 65, 50}, {.seed = 9, .exposure = 2});
  refine(tree, test_picture, 300);
  const auto json = nlohmann::json::parse(refinement_json(tree, 10));
  EXPECT_EQ(json["window"], (nlohmann::json{4, 2, 65, 50}));
  EXPECT_EQ(json["phase"], "features");
  EXPECT_EQ(json["rounds"], tree.rounds());
  EXPECT_EQ(json["samples"], 300);
  EXPECT_EQ(json["pixels"], 61 * 48);
  EXPECT_EQ(json["settings"]["seed"], 9);
  EXPECT_EQ(json["settings"]["exposure"], 2);
  EXPECT_EQ(json["settings"]["coverage_area"], 256);
  size_t leaves = 0;
  for (const auto& count : json["leaves_by_area"]) leaves += count.get<size_t>();
  EXPECT_EQ(leaves, 300u);
  EXPECT_EQ(json["open"], tree.open_count());
  ASSERT_EQ(json["next"].size(), 10u);
  const std::vector<RefinementNode> urgent = tree.most_urgent(300);
  for (size_t i = 0; i < 10; ++i) {
    const auto& leaf = json["next"][i];
    const Rect& r = urgent[i].rect;
    EXPECT_EQ(leaf["rect"], (nlohmann::json{r.x0, r.y0, r.x1, r.y1}));
    EXPECT_EQ(leaf["priority"].get<float>(), urgent[i].priority);
    EXPECT_EQ(leaf["v_int"].get<float>(), urgent[i].v_int);
    EXPECT_EQ(leaf["v_ext"].get<float>(), urgent[i].v_ext);
    EXPECT_EQ(leaf["value"][1].get<float>(), urgent[i].mean.y);
    if (i > 0) {
      EXPECT_LE(urgent[i].priority, urgent[i - 1].priority);
    }
  }
}

}  // namespace
}  // namespace emberline
