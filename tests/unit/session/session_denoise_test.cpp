// Tests the denoised pictures of a session, and the raw data.
#include <gtest/gtest.h>

#include <algorithm>

#include "renderer/session/grading.h"
#include "unit/session_fixture.h"

namespace emberline {
namespace {

using test::SessionOwner;

class SessionDenoiseTest : public SessionFixture {
 protected:
  static ViewSettings denoised(const std::string& driver, std::optional<uint32_t> spp = {}) {
    ViewSettings result = settings(driver, spp);
    result.denoise = true;
    return result;
  }
  static std::vector<uint8_t> graded(const std::vector<float>& rgba) {
    std::vector<uint8_t> expected(rgba.size());
    Grading(DisplaySettings{}).grade(rgba, 48, expected);
    return expected;
  }
  // The difference is approximately as displayed: the lamp is clipped to white.
  static double difference(const std::vector<float>& a, const std::vector<float>& b) {
    double sum = 0.0;
    for (size_t i = 0; i < a.size(); ++i) {
      const double d = double(std::min(a[i], 1.0f)) - double(std::min(b[i], 1.0f));
      sum += d * d;
    }
    return sum;
  }
};

TEST_F(SessionDenoiseTest, ShowsLessNoiseAndKeepsTheFilm) {
  RenderOptions options = settings("bisection", 512).render;
  options.scene = scene("cornell_box");
  const std::vector<float> truth = rendered(options);
  for (const char* driver : {"bisection", "adaptive", "bucket", "live"}) {
    SessionOwner owner(denoised(driver, 4)), raw(settings(driver, 4));
    owner.open(scene("cornell_box"));
    raw.open(scene("cornell_box"));
    ASSERT_TRUE(finishes(owner) && finishes(raw)) << driver;
    const auto picture = owner.session.picture();
    expect_same_bits(picture->rgba, raw.session.picture()->rgba, driver);
    EXPECT_TRUE(raw.session.picture()->denoised.empty());
    ASSERT_EQ(picture->denoised.size(), picture->rgba.size()) << driver;
    EXPECT_EQ(picture->rgba8, graded(picture->denoised));
    // This is the limit for such a small picture. tests/bench/results has larger pictures.
    EXPECT_LT(difference(picture->denoised, truth), 0.75 * difference(picture->rgba, truth))
        << driver;
  }
}

TEST_F(SessionDenoiseTest, FromTheFirstPictureOn) {
  ViewSettings view = denoised("live");
  view.render.width = 640;
  view.render.height = 480;
  SessionOwner owner(view);
  owner.session.open(scene("cornell_box"));
  std::shared_ptr<const SessionPicture> first;
  ASSERT_TRUE(owner.wait(120, [&] {
    owner.session.load_status();
    first = owner.session.picture();
    return first != nullptr;
  }));
  EXPECT_FALSE(first->complete);
  ASSERT_EQ(first->denoised.size(), first->rgba.size());
  EXPECT_NE(first->denoised, first->rgba);
}

TEST_F(SessionDenoiseTest, SwitchingRendersNothingAgain) {
  SessionOwner owner(denoised("bisection", 4));
  RenderSession& session = owner.session;
  owner.open(scene("cornell_box"));
  ASSERT_TRUE(finishes(owner));
  const uint64_t edit = session.edit();
  const auto before = session.picture();
  EXPECT_TRUE(before->raw8.empty());
  ViewSettings view = session.settings();
  view.denoise = false;
  session.set_settings(view);
  ASSERT_TRUE(owner.wait(30, [&] { return session.picture()->denoised.empty(); }));
  EXPECT_EQ(session.picture()->rgba8, graded(before->rgba));
  view.denoise = view.include_raw = true;
  session.set_settings(view);
  ASSERT_TRUE(owner.wait(30, [&] { return !session.picture()->raw8.empty(); }));
  EXPECT_EQ(session.picture()->raw8, graded(before->rgba));
  EXPECT_EQ(session.picture()->rgba8, before->rgba8);
  EXPECT_EQ(session.edit(), edit);
  // Another exposure grades both pictures.
  const auto beside = session.picture();
  view.display.exposure = 1.0f;
  session.set_settings(view);
  ASSERT_TRUE(owner.wait(30, [&] { return session.picture()->rgba8 != beside->rgba8; }));
  EXPECT_NE(session.picture()->raw8, beside->raw8);
}

// The session starts a new frame, because only a new frame has the missing channels.
TEST_F(SessionDenoiseTest, SwitchingOnLaterRendersWithFeatures) {
  SessionOwner owner(settings("bisection", 4));
  RenderSession& session = owner.session;
  owner.open(scene("cornell_box"));
  ASSERT_TRUE(finishes(owner));
  const auto before = session.picture();
  ViewSettings view = session.settings();
  view.denoise = true;
  session.set_settings(view);
  ASSERT_TRUE(finishes(owner));
  EXPECT_GT(session.picture()->edit, before->edit);
  EXPECT_FALSE(session.picture()->denoised.empty());
  expect_same_bits(session.picture()->rgba, before->rgba, "the film");
}

TEST_F(SessionDenoiseTest, FilesAndOverlaysAndPixelValuesStayRaw) {
  SessionOwner owner(denoised("bisection", 4));
  RenderSession& session = owner.session;
  owner.open(scene("cornell_box"));
  ASSERT_TRUE(finishes(owner));
  session.save(path("saved.exr")).get();
  RenderOptions options = settings("bisection", 4).render;
  options.scene = scene("cornell_box");
  const std::vector<float> raw = rendered(options);
  expect_same_bits(rgba_of(path("saved.exr")), raw, "saved");
  const auto pixel = session.inspect(20, 10);
  ASSERT_TRUE(pixel && pixel->denoised);
  EXPECT_EQ(pixel->radiance.x, raw[4 * (10 * 48 + 20)]);
  EXPECT_EQ(pixel->denoised->x, session.picture()->denoised[4 * (10 * 48 + 20)]);
  // With denoising, every driver reports the error of the pixel.
  std::optional<PixelInspection> known;
  ASSERT_TRUE(owner.wait(30, [&] {
    known = session.inspect(20, 10);
    return known && known->known;
  }));
  EXPECT_TRUE(known->variance.has_value());
  ViewSettings view = session.settings();
  view.overlay = ViewOverlay::kSamples;
  session.set_settings(view);
  ASSERT_TRUE(owner.wait(30, [&] { return !session.picture()->overlay_legend.empty(); }));
  EXPECT_TRUE(session.picture()->denoised.empty());
}

// When the lights are mixed anew, the mixture is denoised with the same weights.
TEST_F(SessionDenoiseTest, WithLightGroupsAndARegion) {
  ViewSettings view = denoised("live", 8);
  view.light_groups = true;
  view.region = Rect{8, 8, 24, 24};
  SessionOwner owner(view);
  owner.open(scene("cornell_box"));
  ASSERT_TRUE(finishes(owner));
  EXPECT_FALSE(owner.session.picture()->denoised.empty());
  SceneEdits edits;
  const auto& materials = owner.session.scene()->outline.materials;
  const auto lamp = std::ranges::find_if(
      materials, [](const MaterialDescription& m) { return m.emission != Rgb(0.0f); });
  ASSERT_NE(lamp, materials.end());
  test::light(edits, EditedLight::kMaterial, int(lamp - materials.begin())).intensity = 0.25f;
  owner.session.set_edits(edits);
  ASSERT_TRUE(finishes(owner));
  const auto picture = owner.session.picture();
  EXPECT_FALSE(picture->denoised.empty());
  EXPECT_NE(picture->denoised, picture->rgba);
}

}  // namespace
}  // namespace emberline
