// Compares the picture's place in the window with the definition of its coordinates.
#include "renderer/window/picture/placement.h"

#include <gtest/gtest.h>

namespace emberline {
namespace {

PicturePlacement placed(const Rect& area, int width, int height) {
  PicturePlacement placement;
  placement.place(area, width, height);
  return placement;
}

TEST(PicturePlacement, FitsTheWholePictureInTheMiddle) {
  const PicturePlacement p = placed({0, 20, 1000, 820}, 500, 200);
  EXPECT_DOUBLE_EQ(p.zoom(), 2.0);
  EXPECT_EQ(p.to_screen(Vec2f(0, 0)), Vec2f(0, 220));
  EXPECT_EQ(p.to_screen(Vec2f(500, 200)), Vec2f(1000, 620));
}

TEST(PicturePlacement, FollowsTheWindowWhileItIsFitted) {
  PicturePlacement p = placed({0, 0, 1000, 1000}, 500, 500);
  p.place({0, 0, 250, 400}, 500, 500);
  EXPECT_TRUE(p.fitted());
  EXPECT_DOUBLE_EQ(p.zoom(), 0.5);
}

TEST(PicturePlacement, ThePixelUnderThePointIsTheOneThatCoversIt) {
  const PicturePlacement p = placed({10, 30, 110, 80}, 10, 5);
  ASSERT_DOUBLE_EQ(p.zoom(), 10.0);
  EXPECT_EQ(p.pixel_at(Vec2f(10, 30)), Vec2i(0, 0));
  EXPECT_EQ(p.pixel_at(Vec2f(19.9f, 39.9f)), Vec2i(0, 0));
  EXPECT_EQ(p.pixel_at(Vec2f(20, 40)), Vec2i(1, 1));
  EXPECT_EQ(p.pixel_at(Vec2f(109, 79)), Vec2i(9, 4));
  EXPECT_FALSE(p.pixel_at(Vec2f(9, 30)));
  EXPECT_FALSE(p.pixel_at(Vec2f(110, 30)));
  EXPECT_FALSE(p.pixel_at(Vec2f(50, 80)));
}

TEST(PicturePlacement, ZoomingWithoutACursorKeepsTheMiddleOfTheArea) {
  PicturePlacement p = placed({100, 0, 900, 600}, 1280, 720);
  const Vec2f middle(500, 300);
  const Vec2f before = p.to_picture(middle);
  p.zoom_to(4.0);
  EXPECT_DOUBLE_EQ(p.zoom(), 4.0);
  EXPECT_LE((p.to_screen(before) - middle).length(), 1.0f);
}

TEST(PicturePlacement, NoPixelOutsideASmallPicture) {
  PicturePlacement p = placed({0, 0, 100, 100}, 100, 50);
  EXPECT_FALSE(p.pixel_at(Vec2f(50, 10)));
  EXPECT_TRUE(p.pixel_at(Vec2f(50, 30)));
  EXPECT_FALSE(p.pixel_at(Vec2f(50, 90)));
}

// The picture starts at a whole screen pixel, which limits the precision.
TEST(PicturePlacement, ZoomingKeepsThePointUnderTheCursor) {
  PicturePlacement p = placed({0, 0, 800, 600}, 1280, 720);
  const Vec2f cursor(300, 200);
  const Vec2f before = p.to_picture(cursor);
  for (const double zoom : {1.0, 3.0, 20.0, 32.0, 0.5}) {
    p.zoom_to(zoom, cursor);
    EXPECT_DOUBLE_EQ(p.zoom(), zoom);
    EXPECT_LE((p.to_screen(before) - cursor).length(), 5.0f) << zoom;
  }
  EXPECT_FALSE(p.fitted());
}

TEST(PicturePlacement, ZoomStaysInItsRange) {
  PicturePlacement p = placed({0, 0, 800, 600}, 100, 100);
  p.zoom_to(1e6, Vec2f(400, 300));
  EXPECT_DOUBLE_EQ(p.zoom(), PicturePlacement::kMaxZoom);
  p.zoom_to(1e-6, Vec2f(400, 300));
  EXPECT_DOUBLE_EQ(p.zoom(), PicturePlacement::kMinZoom);
}

TEST(PicturePlacement, SomeOfThePictureStaysInSight) {
  PicturePlacement p = placed({0, 0, 800, 600}, 400, 300);
  for (const Vec2f& way : {Vec2f(1e5f, 0), Vec2f(-2e5f, 0), Vec2f(0, 1e5f), Vec2f(0, -2e5f)}) {
    p.drag(way);
    const Vec2f a = p.to_screen(Vec2f(0, 0)), b = p.to_screen(Vec2f(400, 300));
    EXPECT_LE(a.x, 800 - 16);
    EXPECT_GE(b.x, 16);
    EXPECT_LE(a.y, 600 - 16);
    EXPECT_GE(b.y, 16);
  }
}

TEST(PicturePlacement, ResizingKeepsTheMiddleOfAZoomedPicture) {
  PicturePlacement p = placed({0, 0, 800, 600}, 1280, 720);
  p.zoom_to(4.0, Vec2f(400, 300));
  const Vec2f middle = p.to_picture(Vec2f(400, 300));
  p.place({0, 0, 500, 900}, 1280, 720);
  EXPECT_DOUBLE_EQ(p.zoom(), 4.0);
  EXPECT_LE((p.to_picture(Vec2f(250, 450)) - middle).length(), 1e-3f);
}

}  // namespace
}  // namespace emberline
