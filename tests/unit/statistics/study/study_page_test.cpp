// Tests the study's page for made-up results: its required contents, and its robustness against
// missing seeds, runs, pictures or a missing baseline.
#include "renderer/statistics/study/page.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "io/image/output.h"
#include "support/markup.h"
#include "support/temp_folder.h"

namespace emberline::test {
namespace {

StudyError error_of(double mse) {
  StudyError error;
  error.mse = error.rel_mse = error.rel_mse_trimmed = error.display_mse = mse;
  error.flip = error.p95_absolute = error.p95_display = std::sqrt(mse);
  error.signed_bias = 0.01;
  return error;
}

// "fast" has a quarter of the error of "slow" in the same time. Both errors vary by a few per cent
// between seeds.
StudyResults study(uint32_t seeds) {
  StudyResults r;
  r.settings.scene = "scenes/made up.glb";
  r.settings.command_line = "emberline study 'scenes/made up.glb' -o out";
  r.settings.width = 48;
  r.settings.height = 32;
  r.settings.budgets = {1, 2, 4, 8};
  r.settings.seeds = seeds;
  r.settings.threads = 2;
  r.settings.baseline = "slow";
  r.methods.resize(2);
  r.methods[0].name = "slow";
  r.methods[1].name = "fast";
  for (uint32_t seed = 0; seed < seeds; ++seed) {
    for (size_t m = 0; m < 2; ++m) {
      StudyRun& run = r.runs.emplace_back();
      run.method = m;
      run.seed = seed;
      for (const double b : r.settings.budgets) {
        StudyCheckpoint& c = run.checkpoints.emplace_back();
        c.budget = c.mean_samples = b;
        c.wall_s = 0.1 * b;
        c.cpu_s = 0.2 * b;
        c.error = error_of((m == 0 ? 4.0 : 1.0) / b * (1 + 0.01 * seed));
      }
      if (m == 1) run.calibration = {{4, 0.11, 0.1}, {8, 0.08, 0.08}};
    }
  }
  return r;
}

class StudyPage : public ::testing::Test {
 protected:
  ParsedMarkup page(const StudyResults& results) const {
    const std::string html = study_page(results, folder_.path());
    ParsedMarkup read = read_markup(html);
    EXPECT_EQ(read.fault, "");
    for (const Element& element : read.elements) {
      for (const auto& [name, value] : element.attributes) {
        if (name == "points" || name == "d") {
          EXPECT_EQ(value.find("nan"), std::string::npos);
          EXPECT_EQ(value.find("inf"), std::string::npos);
        }
      }
    }
    return read;
  }
  static void expect_text(const ParsedMarkup& read, const std::string& text) {
    EXPECT_NE(read.text.find(text), std::string::npos) << "not on the page: " << text;
  }
  void write_picture(const std::string& name, uint8_t value) const {
    std::filesystem::create_directories(std::filesystem::path(folder_ / name).parent_path());
    write_image(folder_ / name,
                {.width = 48, .height = 32, .values = std::vector<uint8_t>(48 * 32 * 3, value)});
  }

  TempFolder folder_;
};

// Returns the number of elements with this class.
size_t of_class(const ParsedMarkup& read, const std::string& word) {
  return size_t(std::ranges::count_if(read.elements, [&](const Element& element) {
    const auto found = element.attributes.find("class");
    return found != element.attributes.end() &&
           (" " + found->second + " ").find(" " + word + " ") != std::string::npos;
  }));
}

TEST_F(StudyPage, CurvesSpeedupsCalibrationAndSettings) {
  const ParsedMarkup read = page(study(4));
  // There are charts of five metrics, against time and against samples, and one of the calibration.
  EXPECT_EQ(read.count("svg"), 11u);
  // Each chart has one line per method. The calibration has the method's line and the exact line.
  EXPECT_EQ(read.count("polyline"), 22u);
  EXPECT_EQ(read.count("polygon"), 20u);  // bands over the seeds
  // "slow" needs four times as long for the error that "fast" has at 8, equally for every seed.
  expect_text(read, "4 [4,\u00a04]");
  EXPECT_GT(of_class(read, "good"), 0u);
  expect_text(read, study(4).settings.command_line);
  expect_text(read, "made up.glb");
  EXPECT_EQ(of_class(read, "warning"), 0u);
}

TEST_F(StudyPage, OneSeedHasNoIntervals) {
  const ParsedMarkup read = page(study(1));
  EXPECT_EQ(read.count("polygon"), 0u);
  EXPECT_EQ(read.count("polyline"), 22u);
  EXPECT_EQ(of_class(read, "good") + of_class(read, "bad"), 0u);
  expect_text(read, "a single seed, without confidence intervals");
}

TEST_F(StudyPage, EmptyAndWithoutABaseline) {
  EXPECT_EQ(page({}).count("svg"), 0u);
  StudyResults r = study(2);
  r.settings.baseline = "none such";
  const ParsedMarkup read = page(r);
  expect_text(read, "nothing to compare with");
  EXPECT_EQ(read.count("svg"), 11u);
  r.settings.budgets.clear();
  page(r);
}

TEST_F(StudyPage, AllFailed) {
  StudyResults r = study(3);
  for (StudyRun& run : r.runs) {
    run = {run.method, run.seed, StudyRunStatus::kFailed, "no memory for <this>", {}, {}};
  }
  const ParsedMarkup read = page(r);
  EXPECT_EQ(read.count("svg"), 0u);
  expect_text(read, "6 of 6 runs failed");
  expect_text(read, "No run has finished");
  size_t reasons = 0;
  for (size_t at = read.text.find("no memory for <this>"); at != std::string::npos;
       at = read.text.find("no memory for <this>", at + 1)) {
    ++reasons;
  }
  EXPECT_EQ(reasons, 6u);
}

TEST_F(StudyPage, SomeFailedAndSomeNotMade) {
  StudyResults r = study(3);
  r.runs.back() = {1, 2, StudyRunStatus::kFailed, "killed", {}, {}};
  r.runs.erase(r.runs.begin() + 2);  // the second seed of "slow"
  r.complete = false;
  const ParsedMarkup read = page(r);
  EXPECT_EQ(of_class(read, "warning"), 2u);
  expect_text(read, "(2 of 3 runs)");
  expect_text(read, "killed");
  EXPECT_EQ(read.count("svg"), 11u);
}

TEST_F(StudyPage, NonPositiveErrorsAreNotDrawn) {
  StudyResults r = study(2);
  for (StudyRun& run : r.runs) {
    run.checkpoints[1].error = error_of(0);
    run.checkpoints[2].error.mse = -1e-9;
    run.checkpoints[3].error.rel_mse = std::nan("");
    run.calibration.push_back({16, 0.1, std::nan("")});
  }
  page(r);
}

TEST_F(StudyPage, ShowsExistingPicturesOnly) {
  StudyResults r = study(2);
  r.reference.png = "pictures/reference.png";
  r.methods[0].pictures = {"pictures/slow.exr", "pictures/slow.png", "pictures/slow_flip.png"};
  r.methods[1].pictures = {"pictures/fast.exr", "pictures/fast.png", ""};
  EXPECT_EQ(page(r).count("img"), 0u);
  write_picture(r.reference.png, 100);
  write_picture(r.methods[0].pictures.png, 120);
  write_picture(r.methods[0].pictures.flip_png, 7);
  write_text(folder_ / "pictures/fast.png", "no picture");
  // These are the reference, "slow", three crops of each, and one FLIP map.
  EXPECT_EQ(page(r).count("img"), 9u);
  write_picture(r.methods[1].pictures.png, 110);
  EXPECT_EQ(page(r).count("img"), 13u);
}

TEST_F(StudyPage, NamesAreText) {
  StudyResults r = study(2);
  const std::string odd = "<b>&\"'";
  r.settings.scene = r.settings.command_line = r.methods[0].name = r.settings.baseline = odd;
  r.settings.frame = {{odd, odd}};
  const ParsedMarkup read = page(r);
  EXPECT_EQ(read.count("b"), 0u);
  expect_text(read, odd);
}

// Searches exhaustively: every position on the grid, with the sum over the pixels of the square.
TEST(MostDifferentSquares, AreTheWorstAndDoNotOverlap) {
  ByteImage a{.width = 40, .height = 24, .values = std::vector<uint8_t>(40 * 24 * 3, 50)};
  ByteImage b = a;
  const auto disturb = [&](int x0, int y0, uint8_t by) {
    for (int y = y0; y < y0 + 4; ++y) {
      for (int x = x0; x < x0 + 4; ++x) b.values[3 * size_t(y * 40 + x) + 1] += by;
    }
  };
  disturb(2, 2, 30);
  disturb(30, 16, 60);
  disturb(18, 10, 10);
  const std::vector<Rect> squares = most_different_squares(a, b, 8, 3);
  ASSERT_EQ(squares.size(), 3u);
  const auto holds = [](const Rect& square, int x0, int y0) {
    return square.intersect({x0, y0, x0 + 4, y0 + 4}).area() == 16;
  };
  EXPECT_TRUE(holds(squares[0], 30, 16));
  EXPECT_TRUE(holds(squares[1], 2, 2));
  EXPECT_TRUE(holds(squares[2], 18, 10));
  for (const Rect& square : squares) EXPECT_EQ(square.area(), 64);
  EXPECT_TRUE(squares[0].intersect(squares[1]).empty());
  EXPECT_TRUE(most_different_squares(a, b, 48, 3).empty());  // larger than the picture
}

}  // namespace
}  // namespace emberline::test
