// Compares a stored picture with the newest picture.
#include <gtest/gtest.h>

#include "renderer/session/grading.h"
#include "unit/session_fixture.h"

namespace emberline {
namespace {

using test::SessionOwner;

class SessionComparisonTest : public SessionFixture {
 protected:
  static std::vector<uint8_t> graded(const SessionPicture& picture,
                                     const DisplaySettings& display) {
    std::vector<uint8_t> expected(picture.rgba.size());
    Grading(display).grade(picture.rgba, picture.width, expected);
    return expected;
  }
};

TEST_F(SessionComparisonTest, FollowsTheDisplayWithTheLightItWasKeptWith) {
  SessionOwner owner(settings("bisection", 4));
  RenderSession& session = owner.session;
  owner.open(scene("cornell_box"));
  ASSERT_TRUE(finishes(owner));
  EXPECT_EQ(session.graded_comparison(), nullptr);
  const auto kept = session.picture();
  const std::vector<uint8_t> as_kept = kept->rgba8;
  session.compare_with(kept);
  ASSERT_TRUE(owner.wait(30, [&] { return session.graded_comparison() != nullptr; }));
  EXPECT_EQ(session.graded_comparison()->rgba8, as_kept);
  // Changes the scene and the display.
  session.set_edits(some_edits());
  ASSERT_TRUE(finishes(owner));
  ViewSettings view = session.settings();
  view.display.exposure = 1.5f;
  view.display.view = "ACES";
  const auto before = session.graded_comparison();
  session.set_settings(view);
  ASSERT_TRUE(owner.wait(30, [&] { return session.graded_comparison() != before; }));
  expect_same_bits(session.graded_comparison()->rgba, kept->rgba, "its light");
  EXPECT_NE(session.graded_comparison()->rgba8, as_kept);
  EXPECT_EQ(session.graded_comparison()->rgba8, graded(*kept, view.display));
  EXPECT_EQ(session.graded_comparison()->edit, kept->edit);
  EXPECT_NE(session.picture()->rgba, kept->rgba);
  EXPECT_EQ(kept->rgba8, as_kept) << "a picture that is handed on does not change";
  session.compare_with(nullptr);
  EXPECT_EQ(session.graded_comparison(), nullptr);
}

TEST_F(SessionComparisonTest, NewerComparisonReplacesTheOlder) {
  SessionOwner owner(settings("bisection", 4));
  RenderSession& session = owner.session;
  owner.open(scene("cornell_box"));
  ASSERT_TRUE(finishes(owner));
  const auto first = session.picture();
  session.set_edits(some_edits());
  ASSERT_TRUE(finishes(owner));
  const auto second = session.picture();
  for (int i = 0; i < 20; ++i) {  // changes faster than the grader
    session.compare_with(first);
    session.compare_with(second);
  }
  ASSERT_TRUE(owner.wait(30, [&] { return session.graded_comparison() != nullptr; }));
  expect_same_bits(session.graded_comparison()->rgba, second->rgba, "the newest");
}

// The colours of a heatmap are not graded.
TEST_F(SessionComparisonTest, OverlayIsNotGraded) {
  ViewSettings view = settings("bisection", 4);
  view.overlay = ViewOverlay::kSamples;
  SessionOwner owner(view);
  RenderSession& session = owner.session;
  owner.open(scene("cornell_box"));
  ASSERT_TRUE(finishes(owner));
  const auto kept = session.picture();
  session.compare_with(kept);
  view.display.exposure = 3.0f;
  session.set_settings(view);
  ASSERT_TRUE(owner.wait(30, [&] { return session.graded_comparison() != nullptr; }));
  EXPECT_EQ(session.graded_comparison()->rgba8, kept->rgba8);
}

}  // namespace
}  // namespace emberline
