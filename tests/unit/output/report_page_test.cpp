// Tests the page of a made-up report, whose contents a small render rarely has.
#include "renderer/output/report_page.h"
#include "renderer/core/setting_names.h"

#include <gtest/gtest.h>

#include "renderer/engine/render_plan.h"
#include "renderer/film/film.h"
#include "support/markup.h"

namespace emberline::test {
namespace {

constexpr Rect kWindow = {10, 20, 50, 44};

RenderOptions options() {
  RenderOptions o;
  o.scene = "shots/a.glb";
  o.command_line = "emberline render shots/a.glb -o out.exr --seed 3";
  o.seed = 3;
  return o;
}

RenderReport report() {
  RenderReport r;
  r.crop = kWindow;
  r.threads = 2;
  r.counters.samples = 4 * uint64_t(kWindow.area());
  r.counters.min_samples = r.counters.max_samples = 4;
  r.times.wall_s = r.times.render_s = 1;
  r.passes.push_back({1, r.counters.samples, std::nullopt});
  return r;
}

SampleValue grey(float value) {
  SampleValue sample;
  sample.radiance = Rgb(value);
  sample.alpha = 1;
  return sample;
}

// A film of the whole crop in which pixel (x, y) has 1 + x % 3 samples.
FilmTile film() {
  FilmTile tile{AovSet()};
  tile.reset(kWindow);
  for (int y = kWindow.y0; y < kWindow.y1; ++y) {
    for (int x = kWindow.x0; x < kWindow.x1; ++x) {
      for (int s = 0; s <= x % 3; ++s) tile.add(x, y, {grey(0.5f), 1, 0});
    }
  }
  return tile;
}

ParsedMarkup page(const RenderOptions& o, const RenderReport& r, const ReportPictures& pictures) {
  ParsedMarkup read = read_markup(report_page(o, r, pictures));
  EXPECT_EQ(read.fault, "");
  return read;
}

void expect_text(const ParsedMarkup& read, const std::string& text) {
  EXPECT_NE(read.text.find(text), std::string::npos) << "not on the page: " << text;
}

TEST(ReportPageSuffix, DecidesTheFormat) {
  for (const char* path : {"a.html", "a.HTM", "b/c.html"}) EXPECT_TRUE(is_page(path)) << path;
  for (const char* path : {"a.json", "html", "a.html.json", "/dev/stdout", "a.html/b"}) {
    EXPECT_FALSE(is_page(path)) << path;
  }
}

TEST(ReportPageContent, NonFiniteSamplesWithTheirReplays) {
  spell_settings([](std::string_view name) { return "--" + std::string(name); });
  RenderReport r = report();
  r.counters.non_finite_samples = 12345;
  r.counters.located = {{11, 22, 3, 3}, {12, 22, 1, 99}};
  const ParsedMarkup read = page(options(), r, ReportPictures({}, kWindow, {}));
  expect_text(read, "12,345");
  expect_text(read, options().command_line + " --replay 11,22,3\n");
  // The sample belongs to a round with its own seed.
  expect_text(read, options().command_line + " --replay 12,22,1 --seed 99");
  // That seed already depends on the frame.
  RenderOptions moving = options();
  moving.frame = 7;
  r.counters.located = {{11, 22, 3, sampling_seed(moving)}, {12, 22, 1, 99}};
  const ParsedMarkup frame = page(moving, r, ReportPictures({}, kWindow, {}));
  expect_text(frame, " --replay 11,22,3\n");
  expect_text(frame, " --replay 12,22,1 --seed 99 --static-noise");
  spell_settings([](std::string_view name) { return std::string(name); });
}

TEST(ReportPageContent, WarningsRepairsAndCoverage) {
  RenderReport r = report();
  r.warnings = {"a <b>warning</b> & more"};
  r.repairs.degenerate_triangles = 7777;
  r.coverage.ignored = {"EXT_made_up: \"no\" <effect>"};
  const ParsedMarkup read = page(options(), r, ReportPictures({}, kWindow, {}));
  expect_text(read, r.warnings[0]);
  expect_text(read, "7,777");
  expect_text(read, r.coverage.ignored[0]);
}

TEST(ReportPageContent, NoSamplesAtAll) {
  RenderReport r = report();
  r.counters = {};
  r.counters.stopped = true;
  r.times = {};
  r.stop_cause = PixelStop::kUser;
  const ParsedMarkup read = page(options(), r, ReportPictures({}, kWindow, {}));
  expect_text(read, "No pixel has samples.");
  expect_text(read, "The user stopped the render");
}

TEST(ReportPageContent, ManyPassesAreThinnedAndTheLastIsKept) {
  RenderReport r = report();
  r.passes.clear();
  for (int i = 1; i <= 1000; ++i) {
    r.passes.push_back({double(i), uint64_t(i) * uint64_t(kWindow.area()), 1.0 / i});
  }
  r.error_estimate = 0.001;
  const ParsedMarkup read = page(options(), r, ReportPictures({}, kWindow, {}));
  expect_text(read, "24 of 1000 passes");
  expect_text(read, "16 min 40 s");  // the last pass
  EXPECT_LT(read.count("tr"), 120u);
}

TEST(ReportPictures, CountEveryPixelAndGradeAsPngDoes) {
  ReportPictures pictures({}, kWindow, {});
  const FilmTile whole = film();
  // The tiles do not divide the crop evenly.
  for (const Rect& rect : {Rect{10, 20, 31, 44}, Rect{31, 20, 50, 44}}) {
    FilmTile tile{AovSet()};
    tile.reset(rect);
    for (int y = rect.y0; y < rect.y1; ++y) {
      for (int x = rect.x0; x < rect.x1; ++x) tile.copy_pixel(whole, x, y);
    }
    pictures.add(tile);
  }
  const std::map<uint32_t, uint64_t> counts = pictures.pixels_by_samples();
  // In 24 rows x runs from 10 to 49, so x % 3 is 1 in 14 columns, and 2 and 0 in 13 columns each.
  EXPECT_EQ(counts, (std::map<uint32_t, uint64_t>{{1, 13 * 24}, {2, 14 * 24}, {3, 13 * 24}}));
  const ByteImage picture = pictures.picture();
  EXPECT_EQ(picture.width, 40);
  EXPECT_EQ(picture.height, 24);
  // The sRGB value of 0.5 is 1.055 0.5^(1/2.4) - 0.055 = 0.7354, or 187.5 of 255.
  for (const uint8_t value : picture.values) EXPECT_NEAR(value, 187.5, 1.0);
  const auto maps = pictures.maps();
  ASSERT_EQ(maps.size(), 1u);
  EXPECT_EQ(maps[0].quantity->name, "samples");
  EXPECT_EQ(maps[0].plane.at(0, 0), 2);  // x = 10
  EXPECT_EQ(maps[0].plane.at(1, 5), 3);
}

TEST(ReportPictures, PixelsThatNeverCameAreCountedAsWithoutSamples) {
  const ReportPictures pictures({}, kWindow, {});
  EXPECT_EQ(pictures.pixels_by_samples(),
            (std::map<uint32_t, uint64_t>{{0, uint64_t(kWindow.area())}}));
  for (const uint8_t value : pictures.picture().values) EXPECT_EQ(value, 0);
  const auto maps = pictures.maps();
  for (const float value : maps[0].plane.values) EXPECT_EQ(value, 0.0f);
}

// A frame that is too large for a page is averaged over squares. The counts stay exact.
TEST(ReportPictures, LargeFramesAreAveraged) {
  const Rect crop{0, 0, 2 * ReportPictures::kMaxPixels, 3};
  ReportPictures pictures({}, crop, {});
  EXPECT_EQ(pictures.factor(), 2);
  FilmTile tile{AovSet()};
  tile.reset(crop);
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < crop.x1; ++x) {
      for (int s = 0; s <= x % 2; ++s) tile.add(x, y, {grey(x % 2 ? 1.0f : 0.0f), 1, 0});
    }
  }
  pictures.add(tile);
  const ByteImage picture = pictures.picture();
  EXPECT_EQ(picture.width, ReportPictures::kMaxPixels);
  EXPECT_EQ(picture.height, 2);
  for (const uint8_t value : picture.values) EXPECT_NEAR(value, 187.5, 1.0);  // the mean of 0 and 1
  const auto maps = pictures.maps();
  for (const float value : maps[0].plane.values) EXPECT_EQ(value, 1.5f);
  EXPECT_EQ(pictures.pixels_by_samples(),
            (std::map<uint32_t, uint64_t>{{1, 3 * ReportPictures::kMaxPixels},
                                          {2, 3 * ReportPictures::kMaxPixels}}));
}

}  // namespace
}  // namespace emberline::test
