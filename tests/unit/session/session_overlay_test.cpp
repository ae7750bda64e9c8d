// Tests a session's per-pixel overlays, and the inspection of pixels during a frame.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "renderer/statistics/heatmap_quantity.h"
#include "unit/session_fixture.h"

namespace emberline {
namespace {

using test::SessionOwner;

class SessionOverlayTest : public SessionFixture {
 protected:
  // Counts the pixels of a stop overlay by stop reason.
  static std::array<size_t, 7> reasons_of(const SessionPicture& picture) {
    std::array<size_t, 7> counts = {};
    for (size_t i = 0; i < picture.rgba8.size(); i += 4) {
      const auto found = std::ranges::find_if(stop_categories(), [&](const Category& category) {
        return std::equal(category.colour.begin(), category.colour.end(), &picture.rgba8[i]);
      });
      if (found == stop_categories().end()) {
        ADD_FAILURE() << "pixel " << i / 4 << " has no reason's colour";
        return counts;
      }
      ++counts[size_t(found->value)];
    }
    return counts;
  }
  static size_t count(const std::array<size_t, 7>& reasons, PixelStop stop) {
    return reasons[size_t(stop)];
  }
  static std::optional<PixelInspection> look(SessionOwner& owner, int x, int y) {
    std::optional<PixelInspection> pixel;
    EXPECT_TRUE(owner.wait(30, [&] {
      pixel = owner.session.inspect(x, y);
      return pixel && pixel->known;
    }));
    return pixel;
  }
};

constexpr size_t kPixels = 48 * 32;

TEST_F(SessionOverlayTest, ShowsFinishedPixelsWhileOthersContinue) {
  ViewSettings view = settings("live");
  view.render.noise_threshold = 0.003f;
  view.render.max_spp = 512;
  view.overlay = ViewOverlay::kStop;
  SessionOwner owner(view);
  owner.session.open(scene("spheres"));
  size_t mixed = 0, none_yet = 0;
  uint64_t serial = 0;
  ASSERT_TRUE(owner.wait(120, [&] {
    owner.session.load_status();
    const auto picture = owner.session.picture();
    if (!picture || picture->serial == serial) return false;
    serial = picture->serial;
    const auto reasons = reasons_of(*picture);
    const size_t going_on = count(reasons, PixelStop::kUnfinished);
    EXPECT_EQ(
        going_on + count(reasons, PixelStop::kThreshold) + count(reasons, PixelStop::kMaximum),
        kPixels);
    EXPECT_EQ(picture->overlay_legend.find("unfinished") != std::string::npos, going_on > 0)
        << picture->overlay_legend;
    if (!picture->complete) {
      EXPECT_EQ(going_on, kPixels) << "bisection ends no pixel of `live`";
    }
    none_yet += going_on == kPixels;
    mixed += going_on > 0 && going_on < kPixels;
    if (picture->finished) {
      EXPECT_EQ(going_on, 0u);
      EXPECT_GT(count(reasons, PixelStop::kThreshold), 0u);
      EXPECT_GT(count(reasons, PixelStop::kMaximum), 0u);
    }
    return picture->finished;
  }));
  EXPECT_GT(none_yet, 0u);
  EXPECT_GT(mixed, 0u);
  RenderOptions options = view.render;
  options.driver = "adaptive";
  options.scene = scene("spheres");
  expect_same_bits(owner.session.picture()->rgba, rendered(options), "with the overlay");
}

TEST_F(SessionOverlayTest, StopReasonsNeedNoNewFrame) {
  SessionOwner owner(settings("adaptive", 16));
  owner.open(scene("cornell_box"));
  ASSERT_TRUE(finishes(owner));
  const uint64_t edit = owner.session.edit();
  ViewSettings view = owner.session.settings();
  view.overlay = ViewOverlay::kStop;
  owner.session.set_settings(view);
  EXPECT_EQ(owner.session.edit(), edit);
  ASSERT_TRUE(owner.wait(30, [&] { return !owner.session.picture()->overlay_legend.empty(); }));
  EXPECT_EQ(count(reasons_of(*owner.session.picture()), PixelStop::kBudget), kPixels);
  EXPECT_EQ(look(owner, 7, 9)->stop, PixelStop::kBudget);
}

TEST_F(SessionOverlayTest, PausedFrameShowsItsCurrentState) {
  ViewSettings view = settings("bisection", 64);
  view.paused = true;
  view.overlay = ViewOverlay::kStop;
  SessionOwner owner(view);
  owner.open(scene("cornell_box"));
  EXPECT_EQ(count(reasons_of(*owner.session.picture()), PixelStop::kUnfinished), kPixels);
  const std::optional<PixelInspection> pixel = look(owner, 7, 9);
  EXPECT_EQ(pixel->stop, PixelStop::kUnfinished);
  owner.session.save_heatmap(path("stop.exr"), ViewOverlay::kStop).get();
  for (const float stop : read_float_image(path("stop.exr")).values) {
    ASSERT_EQ(stop, float(PixelStop::kUnfinished));
  }
  view.paused = false;
  owner.session.set_settings(view);
  ASSERT_TRUE(finishes(owner));
  EXPECT_EQ(count(reasons_of(*owner.session.picture()), PixelStop::kBudget), kPixels);
}

// Bisection shows a finished pixel as finished although the pass continues. With one thread and
// this many samples, the last pass of the frame has two slices.
TEST_F(SessionOverlayTest, BisectionAndBucketsShowFinishedPixels) {
  for (const char* driver : {"bisection", "bucket"}) {
    ViewSettings view = settings(driver, 1024);
    view.render.threads = 1;
    view.render.max_depth = 1;
    view.overlay = ViewOverlay::kStop;
    SessionOwner owner(view);
    owner.session.open(scene("cornell_box"));
    size_t mixed = 0;
    ASSERT_TRUE(owner.wait(120, [&] {
      owner.session.load_status();
      const auto picture = owner.session.picture();
      if (!picture) return false;
      const auto reasons = reasons_of(*picture);
      const size_t going_on = count(reasons, PixelStop::kUnfinished);
      EXPECT_EQ(going_on + count(reasons, PixelStop::kBudget), kPixels);
      mixed += going_on > 0 && going_on < kPixels;
      return picture->finished;
    })) << driver;
    EXPECT_GT(mixed, 0u) << driver;
    EXPECT_EQ(count(reasons_of(*owner.session.picture()), PixelStop::kUnfinished), 0u) << driver;
  }
}

TEST_F(SessionOverlayTest, TimeLimitIsTheReasonForStoppedPixels) {
  for (const char* driver : {"live", "bisection"}) {
    ViewSettings view = settings(driver);
    view.render.time_limit_s = 0.3;
    view.overlay = ViewOverlay::kStop;
    SessionOwner owner(view);
    owner.open(scene("cornell_box"));
    ASSERT_TRUE(finishes(owner));
    const auto reasons = reasons_of(*owner.session.picture());
    EXPECT_GT(count(reasons, PixelStop::kTimeLimit), 0u) << driver;
    EXPECT_EQ(count(reasons, PixelStop::kUnfinished), 0u) << driver;
  }
}

}  // namespace
}  // namespace emberline
