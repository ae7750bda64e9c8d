// Tests explanations of single pixels, after a render and from its EXR.

#include <algorithm>

#include "cli/command_test.h"

namespace emberline::test {
namespace {

class Explain : public CommandTest {
 protected:
  Words frame(const Words& more = {}) {
    return render_words(Words{"--driver", "adaptive", "--noise-threshold", "0.02", "--spp",
                              "100000", "--size", "40x24"} +
                        more);
  }
  // Returns what `emberline explain` prints about a pixel of out.exr.
  std::string explanation(const std::string& pixel) {
    const RunResult result = run({"explain", path("out.exr"), pixel});
    EXPECT_EQ(result.exit_code, 0) << result.describe();
    return result.out;
  }
  static void expect_all(const std::string& text, const Words& parts) {
    for (const std::string& part : parts) EXPECT_NE(text.find(part), std::string::npos) << text;
  }
};

TEST_F(Explain, ARenderTellsTheHistoryInASentenceAndExplainsItsColumns) {
  const RunResult result = run(frame({"--explain", "20,12"}));
  ASSERT_EQ(result.exit_code, 0) << result.describe();
  expect_all(result.out,
             {"samples its error was ", "(threshold 0.02)", ", so the pixel was finished.\n",
              "refinement tree", "  v_int  ", "rounds\n", "  deviation  "});
  // The explanation from the file repeats the sentence of --explain, but only for that pixel.
  const size_t begin = result.out.find("At ");
  const std::string sentence = result.out.substr(begin, result.out.find('\n', begin) - begin);
  expect_all(explanation("20,12"), {sentence + "\n"});
  EXPECT_EQ(explanation("21,12").find("At "), std::string::npos);
}

TEST_F(Explain, AFinishedFrameTellsWhatItsChannelsHave) {
  render(frame({"--aov", "stop,variance,time,rays"}));
  const ExrPicture picture = read_exr(path("out.exr"));
  const auto samples = size_t(picture.at("samples", 7, 5));
  expect_all(explanation("7,5"),
             {"pixel 7,5: " + std::to_string(samples) + " samples; the frame has ",
              "It stopped because its error met --noise-threshold 0.02.\n",
              "Its error, estimated from its own samples alone, is ",
              "The driver compares --noise-threshold 0.02 with a different error: ",
              "of 960 pixels are above the threshold", "It took ", " rays.\n",
              "render it with --explain 7,5"});
}

TEST_F(Explain, TheWorstPixelHasTheMaximumOfTheErrorHeatmap) {
  render(frame({"--aov", "variance"}));
  render({"heatmap", path("out.exr"), "--of", "error", "-o", path("error.exr")});
  const ExrPicture errors = read_exr(path("error.exr"));
  const std::vector<float>& values = errors.channels.at("error");
  const auto worst = size_t(std::ranges::max_element(values) - values.begin());
  const std::string place = std::to_string(worst % 40) + "," + std::to_string(worst / 40);
  EXPECT_EQ(explanation("worst"), explanation(place));
  expect_all(explanation("worst"), {"pixel " + place + ": "});
}

TEST_F(Explain, NamesTheOptionsForWhatTheFileLacks) {
  render(frame());
  expect_all(explanation("7,5"),
             {"Why it stopped is not in the file; render it with --aov stop.\n",
              "Its error is not in the file; render it with --aov variance.\n",
              "The history of its error is not in the file; render it with --explain 7,5.\n"});
  expect_failure({"explain", path("out.exr"), "worst"}, 3, {"out.exr", "--aov variance"});
  expect_failure({"explain", path("out.exr")}, 3, {"out.exr", "--aov variance"});
}

// In a frame without an adaptive driver or a threshold, the explanation must not mention them.
TEST_F(Explain, AUniformFrameHasNoHistory) {
  render(render_words({"--aov", "stop,variance", "--spp", "4"}));
  const std::string text = explanation("3,4");
  expect_all(text, {"pixel 3,4: 4 samples; the frame has 4 to 4, 4 on average\n",
                    "It stopped at the number of samples that every pixel gets (--spp).\n",
                    "upper estimate"});
  EXPECT_EQ(text.find("--noise-threshold"), std::string::npos) << text;
  EXPECT_EQ(text.find("--explain"), std::string::npos) << text;
}

TEST_F(Explain, PixelsOfACropAreThoseOfTheFrame) {
  render(render_words({"--crop", "4,5,12,9"}));
  expect_all(explanation("4,8"), {"pixel 4,8: "});
  for (const char* pixel : {"3,5", "4,9", "12,5"}) {
    expect_failure({"explain", path("out.exr"), pixel}, 2,
                   {"outside the rendered pixels; valid is 4 to 11 and 5 to 8"});
  }
}

TEST_F(Explain, WrongInputIsOneLine) {
  render(render_words({"-o", path("out.png"), "--aov", "variance"}));
  for (const char* pixel : {"1", "1,2,3", "1.5,2", "best"}) {
    expect_failure({"explain", path("out.exr"), pixel}, 2, {pixel, "X,Y", "worst"});
  }
  expect_failure({"explain", path("out.exr"), "worst"}, 3, {"no pixel has two samples"});
  expect_failure({"explain", path("out.png"), "1,2"}, 3, {"out.png"});
  expect_failure({"explain", path("none.exr"), "1,2"}, 3, {"none.exr"});
  expect_failure({"explain", scene(), "1,2"}, 3, {"scene.glb"});
  expect_failure({"explain"}, 2, {"image"});
}

}  // namespace
}  // namespace emberline::test
