// Tests hints that tell the user what to change. Hints are only messages. They do not affect
// pictures or exit codes.
#include "cli/command_test.h"

namespace emberline::test {
namespace {

class Hints : public CommandTest {
 protected:
  // Renders and returns the messages.
  std::string messages(const Words& more) { return render(render_words(more)).err; }
};

TEST_F(Hints, APictureThatIsMostlyWhiteSuggestsAnExposure) {
  const Words bright = {"-o", path("out.png"), "--sun", "60,0", "--env-strength", "100000"};
  const std::string text = messages(bright);
  const std::string hint = "most of the picture is brighter than white; try --exposure ";
  const size_t at = text.find(hint);
  ASSERT_NE(at, std::string::npos) << text;
  // With the proposed exposure, the picture must not be white any more.
  const std::string stops = text.substr(at + hint.size(), text.find('\n', at) - at - hint.size());
  EXPECT_LT(std::stoi(stops), -8) << text;
  EXPECT_GT(std::stoi(stops), -24) << text;
  EXPECT_EQ(messages(bright + Words{"--exposure", stops}).find(hint), std::string::npos);
  // With half of the light, the picture is still too bright. The proposal must be the same, because
  // it takes the given exposure into account.
  EXPECT_NE(messages(bright + Words{"--exposure", "-1"}).find(hint + stops), std::string::npos);
}

TEST_F(Hints, AWhiteBackgroundIsNotTooBright) {
  unlit_scene().write_glb(path("plain.glb"));
  // The camera looks upwards and sees only the plain white environment.
  const std::string text =
      render({"render", path("plain.glb"), "-o", path("out.png"), "--size", "16x16", "--spp", "1",
              "--look-from", "0,1,0", "--look-at", "0,9,0.1"})
          .err;
  EXPECT_NE(text.find("no light"), std::string::npos) << text;
  EXPECT_EQ(text.find("--exposure"), std::string::npos) << text;
}

TEST_F(Hints, AShutterWithoutAnimationSaysWhatToAdd) {
  EXPECT_NE(
      messages({"--shutter", "0,0.5"}).find("--shutter has no effect: the file has no animation"),
      std::string::npos);
  EXPECT_EQ(messages({"--shutter", "0,0"}).find("has no effect"), std::string::npos);
}

}  // namespace
}  // namespace emberline::test
