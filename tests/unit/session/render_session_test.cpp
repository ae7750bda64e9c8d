// Tests the pictures of a session: the right samples of the newest edit, and their metadata.
#include "renderer/session/render_session.h"
#include "integrators/integrator.h"
#include "samplers/sampler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "renderer/drivers/driver_table.h"
#include "renderer/session/grading.h"
#include "unit/session_fixture.h"

namespace emberline {
namespace {

using test::SessionOwner;

class RenderSessionTest : public SessionFixture {};

TEST_F(RenderSessionTest, HasNothingBeforeAScene) {
  SessionOwner owner(settings("live"));
  RenderSession& session = owner.session;
  EXPECT_EQ(session.scene(), nullptr);
  EXPECT_EQ(session.picture(), nullptr);
  EXPECT_EQ(session.load_status().state, LoadStatus::State::kNone);
  EXPECT_FALSE(session.inspect(1, 1).has_value());
  session.set_edits(some_edits());
  EXPECT_EQ(session.edits(), SceneEdits{});
}

TEST_F(RenderSessionTest, LoadsAndRendersToTheEnd) {
  SessionOwner owner(settings("bisection", 8));
  owner.open(scene("cornell_box"));
  ASSERT_NE(owner.session.scene(), nullptr);
  EXPECT_FALSE(owner.session.scene()->outline.materials.empty());
  EXPECT_GT(owner.session.scene()->radius, 0.0);
  EXPECT_EQ(owner.session.load_status().fraction, 1.0);
  ASSERT_TRUE(finishes(owner));
  const auto picture = owner.session.picture();
  EXPECT_TRUE(picture->filled && picture->complete);
  EXPECT_EQ(picture->samples, 8u * 48 * 32);
  EXPECT_GT(picture->rays, picture->samples);
  EXPECT_EQ(picture->rgba.size(), 4u * 48 * 32);
  EXPECT_EQ(picture->rgba8.size(), 4u * 48 * 32);
  EXPECT_EQ(picture->driver, "bisection");
  EXPECT_EQ(owner.session.problem(), "");
}

// The samples equal those of the command, for every driver.
TEST_F(RenderSessionTest, ShowsTheBitsOfTheCommand) {
  for (const char* driver : {"bisection", "bucket", "adaptive"}) {
    const ViewSettings view = settings(driver, 8);
    SessionOwner owner(view);
    owner.open(scene("cornell_box"));
    ASSERT_TRUE(finishes(owner)) << driver;
    RenderOptions options = view.render;
    options.scene = scene("cornell_box");
    expect_same_bits(owner.session.picture()->rgba, rendered(options), driver);
    if (options.driver == "bisection") {
      options.driver = "bucket";
      expect_same_bits(owner.session.picture()->rgba, rendered(options), "against buckets");
    }
  }
}

TEST_F(RenderSessionTest, LiveShowsBisectionAndThenAdaptive) {
  SessionOwner owner(settings("live", 16));
  RenderSession& session = owner.session;
  session.open(scene("cornell_box"));
  std::vector<std::string> drivers;
  bool complete = false;
  uint64_t serial = 0;
  ASSERT_TRUE(owner.wait(120, [&] {
    session.load_status();
    const auto picture = session.picture();
    if (!picture || picture->serial == serial) return false;
    EXPECT_GT(picture->serial, serial);
    serial = picture->serial;
    EXPECT_TRUE(picture->filled);
    EXPECT_TRUE(picture->complete || !complete) << "a pixel lost its sample";
    complete = picture->complete;
    if (drivers.empty() || drivers.back() != picture->driver) drivers.push_back(picture->driver);
    return picture->finished;
  }));
  EXPECT_EQ(drivers.back(), "adaptive");
  EXPECT_LE(drivers.size(), 2u);
  if (drivers.size() == 2) {
    EXPECT_EQ(drivers.front(), "bisection");
  }
  RenderOptions options = settings("adaptive", 16).render;
  options.scene = scene("cornell_box");
  expect_same_bits(session.picture()->rgba, rendered(options), "live");
}

TEST_F(RenderSessionTest, RendersEveryDriverIntegratorAndSampler) {
  SessionOwner owner(settings("live"));
  owner.open(scene("cornell_box"));
  RenderSession& session = owner.session;
  std::vector<std::string> drivers = {"live"};
  for (const DriverEntry& entry : driver_table()) drivers.emplace_back(entry.name);
  for (const std::string& driver : drivers) {
    for (const IntegratorEntry& integrator : integrator_table()) {
      ViewSettings view = settings(driver, 2);
      view.render.integrator = integrator.name;
      session.set_settings(view);
      ASSERT_TRUE(owner.wait(60, [&] { return owner.shows(session.edit()); }))
          << driver << " " << integrator.name << ": " << session.problem();
    }
    for (const SamplerEntry& sampler : sampler_table()) {
      ViewSettings view = settings(driver, 4);
      view.render.sampler = sampler.name;
      session.set_settings(view);
      ASSERT_TRUE(
          owner.wait(60, [&] { return owner.shows(session.edit()) || !session.problem().empty(); }))
          << driver << " " << sampler.name;
      const bool adaptive = driver == "live" || driver == "adaptive";
      const bool fixed = sampler.counts != SampleCounts::kAny;
      EXPECT_EQ(!session.problem().empty(), adaptive && fixed) << session.problem();
    }
  }
}

TEST_F(RenderSessionTest, ReportsErrorsAndContinuesWhenTheyAreFixed) {
  SessionOwner owner(settings("bisection", 4));
  owner.open(scene("cornell_box"));
  ASSERT_TRUE(finishes(owner));
  const auto before = owner.session.picture();
  ViewSettings view = settings("bisection", 4);
  view.render.noise_threshold = 0.01f;
  owner.session.set_settings(view);
  ASSERT_TRUE(owner.wait(30, [&] { return !owner.session.problem().empty(); }));
  EXPECT_NE(owner.session.problem().find("noise-threshold"), std::string::npos);
  EXPECT_EQ(owner.session.picture(), before);
  view.render.driver = "adaptive";
  owner.session.set_settings(view);
  ASSERT_TRUE(owner.wait(30, [&] { return owner.shows(owner.session.edit()); }));
  EXPECT_EQ(owner.session.problem(), "");
}

// A window's films, pictures and environments count towards the memory limit of its scene.
TEST_F(RenderSessionTest, KeepsToTheMemoryLimitWithFramesAndEnvironments) {
  ViewSettings small = settings("bucket", 1);
  small.render.limits.memory_bytes = 8 << 20;
  ViewSettings large = small;
  large.render.width = 1600;
  large.render.height = 1000;
  RenderOptions sky = large.render;
  sky.limits = {};
  sky.max_depth = 1;
  sky.scene = scene("cornell_box");
  sky.spp = 1;

  SessionOwner owner(small);
  owner.open(scene("cornell_box"));
  const auto problem_with = [&](const std::string& text) {
    return owner.wait(30, [&] {
      const std::string problem = owner.session.problem();
      return problem.find(text) != std::string::npos &&
             problem.find("of the limit of 8 MiB is left") != std::string::npos;
    });
  };
  for (const char* driver : {"bucket", "bisection", "adaptive", "live"}) {
    large.render.driver = driver;
    owner.session.set_settings(large);
    EXPECT_TRUE(problem_with("a frame of 1600x1000 pixels")) << owner.session.problem();
    owner.session.set_settings(small);
    EXPECT_TRUE(finishes(owner));
    EXPECT_EQ(owner.session.problem(), "");
  }
  // The first map is too large. The second map fits, but its sampling table does not.
  for (const auto& [width, height] : {std::pair(1600, 1000), std::pair(1000, 500)}) {
    sky.width = width;
    sky.height = height;
    const std::string name = "sky" + std::to_string(width) + ".exr";
    sky.outputs = {path(name)};
    ASSERT_EQ(run_render(sky), 0);
    SceneEdits edits;
    edits.environment.file = path(name);
    owner.session.set_edits(edits);
    EXPECT_TRUE(problem_with(name)) << owner.session.problem();
    owner.session.set_edits({});
    EXPECT_TRUE(finishes(owner));
  }
}

// The Cornell box has only one lamp, so doubling the lamp doubles the picture without a new sample.
TEST_F(RenderSessionTest, LightGroupsFollowALightWithoutASample) {
  ViewSettings view = settings("live", 16);
  view.light_groups = true;
  SessionOwner owner(view);
  owner.open(scene("cornell_box"));
  ASSERT_TRUE(finishes(owner));
  RenderSession& session = owner.session;
  const auto before = session.picture();
  RenderOptions options = settings("adaptive", 16).render;
  options.scene = scene("cornell_box");
  expect_same_bits(before->rgba, rendered(options), "before any edit");
  const auto& materials = session.scene()->outline.materials;
  const auto lamp = std::ranges::find_if(
      materials, [](const MaterialDescription& m) { return !is_black(m.emission); });
  ASSERT_NE(lamp, materials.end());
  SceneEdits edits;
  LightEdit& light = test::light(edits, EditedLight::kMaterial, int(lamp - materials.begin()));
  for (const float intensity : {2.0f, 0.0f, 0.5f}) {
    light.intensity = intensity;
    session.set_edits(edits);
    ASSERT_TRUE(owner.wait(30, [&] { return session.picture()->edit == session.edit(); }));
    const auto picture = session.picture();
    EXPECT_TRUE(picture->finished) << "it was rendered anew";
    EXPECT_EQ(picture->samples, before->samples);
    for (size_t i = 0; i < picture->rgba.size(); ++i) {
      const float expected = before->rgba[i] * (i % 4 < 3 ? intensity : 1.0f);
      ASSERT_NEAR(picture->rgba[i], expected, 1e-4f * expected + 1e-6f) << i;
    }
    session.save(path("relit.exr")).get();
    expect_same_bits(rgba_of(path("relit.exr")), picture->rgba, "saved");
  }
  // A light that is off when a frame starts can be turned on without a new sample.
  light.on = false;
  edits.camera = some_edits().camera;
  session.set_edits(edits);
  ASSERT_TRUE(finishes(owner));
  light.on = true;
  light.intensity = 1.0f;
  session.set_edits(edits);
  ASSERT_TRUE(owner.wait(30, [&] { return session.picture()->edit == session.edit(); }));
  EXPECT_TRUE(session.picture()->finished);
  EXPECT_GT(*std::ranges::max_element(session.picture()->rgba), 0.5f);
}

TEST_F(RenderSessionTest, AnotherExposureNeedsNoSample) {
  SessionOwner owner(settings("bisection", 4));
  owner.open(scene("cornell_box"));
  ASSERT_TRUE(finishes(owner));
  const auto before = owner.session.picture();
  ViewSettings view = owner.session.settings();
  view.display.exposure = 2.0f;
  owner.session.set_settings(view);
  ASSERT_TRUE(owner.wait(30, [&] { return owner.session.picture()->serial > before->serial; }));
  const auto after = owner.session.picture();
  expect_same_bits(after->rgba, before->rgba, "linear picture");
  EXPECT_EQ(after->edit, before->edit);
  EXPECT_EQ(after->edit, owner.session.edit());
  EXPECT_TRUE(after->finished);
  std::vector<uint8_t> expected(after->rgba.size());
  Grading(view.display).grade(after->rgba, after->width, expected);
  EXPECT_EQ(after->rgba8, expected);
  EXPECT_NE(after->rgba8, before->rgba8);
}

TEST_F(RenderSessionTest, AnUnknownViewIsAProblemAndTheOneBeforeStays) {
  ViewSettings view = settings("bisection", 4);
  view.display.view = "Film noir";
  SessionOwner owner(view);
  owner.open(scene("cornell_box"));
  ASSERT_TRUE(finishes(owner));
  EXPECT_NE(owner.session.problem().find("Film noir"), std::string::npos);
  view.display.view = "ACES";
  const uint64_t serial = owner.session.picture()->serial;
  owner.session.set_settings(view);
  ASSERT_TRUE(owner.wait(30, [&] { return owner.session.picture()->serial > serial; }));
  EXPECT_EQ(owner.session.problem(), "");
}

TEST_F(RenderSessionTest, OverlaysReplaceThePicture) {
  SessionOwner owner(settings("adaptive", 16));
  owner.open(scene("cornell_box"));
  ASSERT_TRUE(finishes(owner));
  const std::vector<float> rgba = owner.session.picture()->rgba;
  std::vector<std::vector<uint8_t>> seen = {owner.session.picture()->rgba8};
  for (const ViewOverlay overlay :
       {ViewOverlay::kSamples, ViewOverlay::kError, ViewOverlay::kStop, ViewOverlay::kTime,
        ViewOverlay::kNonFinite, ViewOverlay::kTree}) {
    ViewSettings view = owner.session.settings();
    view.overlay = overlay;
    const uint64_t serial = owner.session.picture()->serial;
    owner.session.set_settings(view);
    ASSERT_TRUE(owner.wait(60, [&] {
      return owner.session.picture()->serial > serial && owner.finished() &&
             !owner.session.picture()->overlay_legend.empty();
    })) << int(overlay);
    const auto picture = owner.session.picture();
    expect_same_bits(picture->rgba, rgba, "the picture below");
    EXPECT_EQ(std::ranges::count(seen, picture->rgba8), 0) << "as one before: " << int(overlay);
    seen.push_back(picture->rgba8);
  }
}

TEST_F(RenderSessionTest, AnOverlayWhoseChannelIsThereNeedsNoSample) {
  SessionOwner owner(settings("bisection", 4));
  owner.open(scene("cornell_box"));
  ASSERT_TRUE(finishes(owner));
  const uint64_t edit = owner.session.edit();
  ViewSettings view = owner.session.settings();
  view.overlay = ViewOverlay::kSamples;
  owner.session.set_settings(view);
  EXPECT_EQ(owner.session.edit(), edit);
  ASSERT_TRUE(owner.wait(
      30, [&] { return owner.session.picture()->overlay_legend.ends_with("samples per pixel"); }));
  view.overlay = ViewOverlay::kError;
  owner.session.set_settings(view);
  EXPECT_EQ(owner.session.edit(), edit + 1);
}

TEST_F(RenderSessionTest, InspectsTheFilm) {
  SessionOwner owner(settings("adaptive", 16));
  owner.open(scene("spheres"));
  ASSERT_TRUE(finishes(owner));
  RenderSession& session = owner.session;
  const auto picture = session.picture();
  bool hit = false;
  for (int y = 1; y < 32; y += 6) {
    for (int x = 1; x < 48; x += 6) {
      ASSERT_TRUE(session.inspect(x, y).has_value());
      std::optional<PixelInspection> pixel;
      ASSERT_TRUE(owner.wait(30, [&] {
        pixel = session.inspect(x, y);
        return pixel->known;
      }));
      const float* rgba = &picture->rgba[4 * size_t(y * 48 + x)];
      EXPECT_EQ(pixel->radiance, Rgb(rgba[0], rgba[1], rgba[2]));
      EXPECT_EQ(pixel->alpha, rgba[3]);
      EXPECT_GE(pixel->samples, 1u);
      EXPECT_TRUE(pixel->variance.has_value());
      hit = hit || pixel->id > 0;
      EXPECT_EQ(pixel->id > 0, pixel->material >= 0);
      EXPECT_EQ(pixel->id > 0, !pixel->object.empty());
      if (pixel->id > 0) {
        EXPECT_LT(size_t(pixel->material), session.scene()->outline.materials.size());
        EXPECT_LE((pixel->position - session.scene()->center).length(),
                  1.001 * session.scene()->radius);
      }
    }
  }
  EXPECT_TRUE(hit);
  EXPECT_FALSE(session.inspect(48, 0).has_value());
  EXPECT_FALSE(session.inspect(0, -1).has_value());
  session.end_inspection();
}

// The explanation is for the picked pixel, whichever pixel is inspected.
TEST_F(RenderSessionTest, ExplainsThePickedPixel) {
  SessionOwner owner(settings("adaptive", 64));
  RenderSession& session = owner.session;
  EXPECT_FALSE(session.picked().has_value());
  session.pick(Vec2i(20, 10));
  owner.open(scene("spheres"));
  ASSERT_TRUE(finishes(owner));
  const auto says = [&](const char* begin, const char* words) {
    return owner.wait(30, [&] {
      session.inspect(7, 9);
      const auto pixel = session.picked();
      return pixel && pixel->known && pixel->explanation.starts_with(begin) &&
             pixel->explanation.find(words) != std::string::npos;
    });
  };
  ASSERT_TRUE(says("pixel 20,10: ", "ended by spp")) << session.picked()->explanation;
  std::string text = session.picked()->explanation;
  EXPECT_NE(text.find("refinement tree"), std::string::npos) << text;
  EXPECT_NE(text.find("rounds\n"), std::string::npos) << text;
  EXPECT_EQ(session.inspect(7, 9)->explanation, "");
  // Another pixel has no recorded rounds, and does not get those of the first pixel.
  session.pick(Vec2i(30, 10));
  ASSERT_TRUE(says("pixel 30,10: ", "ended by spp")) << session.picked()->explanation;
  text = session.picked()->explanation;
  EXPECT_EQ(text.find("rounds"), std::string::npos) << text;
  // The next frame records all of its rounds.
  SceneEdits edits;
  edits.camera.fov_y_degrees = 30.0;
  session.set_edits(edits);
  ASSERT_TRUE(finishes(owner));
  ASSERT_TRUE(says("pixel 30,10: ", "rounds\n")) << session.picked()->explanation;
  session.pick(std::nullopt);
  EXPECT_FALSE(session.picked().has_value());
}

// A pixel that is picked during a frame is explained during this frame.
TEST_F(RenderSessionTest, ExplainsAnUnfinishedPixel) {
  ViewSettings slow = settings("adaptive");
  slow.render.width = 120;
  slow.render.height = 80;
  SessionOwner owner(slow);
  RenderSession& session = owner.session;
  owner.open(scene("spheres"));
  const auto says = [&](const char* words) {
    return owner.wait(60, [&] {
      const auto pixel = session.picked();
      return pixel && pixel->known && pixel->explanation.find(words) != std::string::npos;
    });
  };
  session.pick(Vec2i(60, 40));
  ASSERT_TRUE(says("unfinished: ")) << session.picked()->explanation;
  ASSERT_TRUE(says("at the end of round ")) << session.picked()->explanation;
  EXPECT_EQ(session.picked()->explanation.find("ended by"), std::string::npos);
  session.pick(Vec2i(10, 70));
  ASSERT_TRUE(says("rounds (recorded from round ")) << session.picked()->explanation;
  EXPECT_TRUE(session.picked()->explanation.starts_with("pixel 10,70: "));
}

TEST_F(RenderSessionTest, PausedFrameWaitsAndContinues) {
  ViewSettings view = settings("bisection", 64);
  view.paused = true;
  SessionOwner owner(view);
  owner.open(scene("cornell_box"));
  RenderSession& session = owner.session;
  // Before the frame continues, a pixel can be inspected and an edit is shown.
  ASSERT_TRUE(owner.wait(30, [&] {
    const auto pixel = session.inspect(20, 20);
    return pixel && pixel->known;
  }));
  session.set_edits(some_edits());
  ASSERT_TRUE(owner.wait(30, [&] { return owner.shows(session.edit()); }));
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  const auto picture = session.picture();
  EXPECT_FALSE(picture->finished);
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  EXPECT_EQ(session.picture(), picture);
  session.save(path("paused.exr")).get();
  expect_same_bits(rgba_of(path("paused.exr")), picture->rgba, "what stands still");
  view.paused = false;
  session.set_settings(view);
  EXPECT_EQ(session.edit(), picture->edit);
  ASSERT_TRUE(finishes(owner));
  view.render.driver = "bucket";
  SessionOwner other(view);
  other.open(scene("cornell_box"));
  other.session.set_edits(some_edits());
  ASSERT_TRUE(finishes(other));
  expect_same_bits(session.picture()->rgba, other.session.picture()->rgba, "after the pause");
}

TEST_F(RenderSessionTest, TheRegionComesFirstWithTheSameSamples) {
  SessionOwner owner(settings("bisection", 32));
  owner.open(scene("cornell_box"));
  ASSERT_TRUE(finishes(owner));
  const std::vector<float> whole = owner.session.picture()->rgba;
  ViewSettings view = owner.session.settings();
  view.region = Rect{10, 5, 30, 40};  // beyond the frame's lower edge
  owner.session.set_settings(view);
  bool region_alone = false;
  uint64_t serial = 0;
  ASSERT_TRUE(owner.wait(60, [&] {
    const auto picture = owner.session.picture();
    if (picture->serial == serial || picture->edit < owner.session.edit()) return false;
    serial = picture->serial;
    if (!picture->filled) {
      region_alone = true;
      for (int x = 0; x < 10; ++x) {  // unchanged outside the region
        EXPECT_EQ(std::memcmp(&picture->rgba[4 * size_t(x)], &whole[4 * size_t(x)], 16), 0);
      }
    }
    return picture->finished;
  }));
  EXPECT_TRUE(region_alone);
  expect_same_bits(owner.session.picture()->rgba, whole, "with a region");
}

TEST_F(RenderSessionTest, EndsAtTheTimeLimit) {
  ViewSettings view = settings("live");
  view.render.time_limit_s = 0.3;
  SessionOwner owner(view);
  owner.open(scene("cornell_box"));
  ASSERT_TRUE(finishes(owner));
  EXPECT_LT(owner.session.picture()->rendering_s, 5.0);
}

}  // namespace
}  // namespace emberline
