#include <gtest/gtest.h>

#include "renderer/session/grading.h"
#include "unit/session_fixture.h"

namespace emberline {
namespace {

using test::SessionOwner;

class SessionBucketTest : public SessionFixture {
 protected:
  static bool same_pixels(const SessionPicture& a, const SessionPicture& b, const Rect& rect) {
    for (int y = rect.y0; y < rect.y1; ++y) {
      const size_t first = 4 * size_t(y * a.width + rect.x0);
      const size_t count = 4 * size_t(rect.width());
      if (std::memcmp(&a.rgba[first], &b.rgba[first], count * sizeof(float)) != 0) return false;
    }
    return true;
  }
};

TEST_F(SessionBucketTest, BucketsReplaceAFirstPictureOneByOne) {
  SessionOwner owner(settings("bisection", 1));
  owner.open(scene("cornell_box"));
  ASSERT_TRUE(finishes(owner));
  ViewSettings view = settings("bucket", 256);
  view.region = Rect{20, 10, 40, 30};
  owner.session.set_settings(view);
  std::vector<std::string> drivers;
  std::shared_ptr<const SessionPicture> first;
  size_t outlined = 0, partial = 0;
  uint64_t serial = 0;
  ASSERT_TRUE(owner.wait(120, [&] {
    const auto picture = owner.session.picture();
    if (picture->serial == serial || picture->edit < owner.session.edit()) return false;
    serial = picture->serial;
    if (!picture->filled) return false;  // only the region is filled
    if (drivers.empty() || drivers.back() != picture->driver) drivers.push_back(picture->driver);
    if (picture->driver == "bisection") {
      EXPECT_FALSE(picture->complete);
      EXPECT_TRUE(picture->in_progress.empty());
      return false;
    }
    if (!first) first = picture;
    outlined += !picture->in_progress.empty();
    partial += !picture->complete;
    for (const Rect& rect : picture->in_progress) {
      EXPECT_EQ(rect, rect.intersect({0, 0, 48, 32}));
      EXPECT_TRUE(same_pixels(*picture, *first, rect)) << "a bucket under way shows what was there";
    }
    EXPECT_EQ(picture->complete, picture->progress.completion >= 1.0);
    return picture->finished;
  }));
  EXPECT_EQ(drivers.back(), "bucket");
  EXPECT_LE(drivers.size(), 2u);
  EXPECT_GT(outlined, 0u);
  EXPECT_GT(partial, 0u);
  const auto picture = owner.session.picture();
  EXPECT_TRUE(picture->in_progress.empty());
  EXPECT_EQ(picture->samples, 256u * 48 * 32) << "the first picture's are not among them";
  std::vector<uint8_t> expected(picture->rgba.size());
  Grading({}).grade(picture->rgba, 48, expected);
  EXPECT_EQ(picture->rgba8, expected) << "outlines never in the pixels";
  RenderOptions options = view.render;
  options.scene = scene("cornell_box");
  expect_same_bits(picture->rgba, rendered(options), "after a first picture");
}

// As in a mouse drag, edits follow each other quickly. Each edit gets a picture before the next
// edit.
TEST_F(SessionBucketTest, ADragShowsPictures) {
  ViewSettings view = settings("bucket", 65536);
  view.render.bucket_size = 48;  // one bucket: none is finished during the drag
  SessionOwner owner(view);
  owner.open(scene("cornell_box"));
  RenderSession& session = owner.session;
  for (int i = 1; i <= 10; ++i) {
    session.set_edits(some_edits(0.1f * float(i)));
    ASSERT_TRUE(owner.wait(10, [&] { return owner.shows(session.edit()); })) << i;
    const auto picture = session.picture();
    EXPECT_LT(picture->elapsed_s, 2.0) << i << ": it waited for a bucket";
    EXPECT_FALSE(picture->complete);
  }
  // The picture is shown when the bucket begins, not when it ends.
  ASSERT_TRUE(owner.wait(10, [&] { return !session.picture()->in_progress.empty(); }));
  EXPECT_EQ(session.picture()->driver, "bucket");
}

}  // namespace
}  // namespace emberline
