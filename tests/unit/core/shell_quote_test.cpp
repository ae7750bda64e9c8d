// When the system's shell parses a quoted word, it must get the original word back.
#include "renderer/core/shell_quote.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <random>

#include "renderer/core/utf8.h"

namespace emberline {
namespace {

std::string read_with_shell(const std::string& word) {
  FILE* shell = popen(("printf '%s' " + word).c_str(), "r");
  std::string text;
  for (int c = fgetc(shell); c != EOF; c = fgetc(shell)) text += char(c);
  pclose(shell);
  return text;
}

void expect_round_trip(const std::string& word) {
  const std::string quoted = shell_quoted(word);
  EXPECT_EQ(read_with_shell(quoted), word) << quoted;
  // The quoted word is printable: it is one line of UTF-8.
  for (std::string_view rest = quoted; !rest.empty();) {
    const size_t length = utf8_length(rest);
    ASSERT_GT(length, 0u) << quoted;
    ASSERT_FALSE(is_control(rest.substr(0, length))) << quoted;
    rest.remove_prefix(length);
  }
}

TEST(ShellQuote, OddWordsComeBack) {
  for (const std::string word : {"", "plain.glb", "two words", "it's", "'", "\"$HOME\" `x` \\ $(y)",
                                 "a;b&c|d>e<f*?[g]{h}~#!", "Küche 場面", "new\nline", "s.glb\n",
                                 "\n", "two\n\n\n", "-\xff\n", "tab\tand\x1b[31m", "no \xff utf-8",
                                 "100%\n%s", "\xc2\x85", "-", "back\\slash\n\\101"}) {
    expect_round_trip(word);
  }
}

TEST(ShellQuote, RandomBytesComeBack) {
  std::mt19937 random(11);
  for (int i = 0; i < 200; ++i) {
    std::string word;
    for (int k = int(random() % 12); k >= 0; --k) word += char(1 + random() % 255);
    word += 'e';  // since the shell cuts off a trailing newline
    expect_round_trip(word);
  }
}

TEST(ShellQuote, PlainWordsAreNotQuoted) {
  EXPECT_EQ(shell_quoted("--look-from=1,2,-3"), "--look-from=1,2,-3");
  EXPECT_EQ(shell_quoted("it's a report.json"), "'it'\\''s a report.json'");
  const char* const words[] = {"/bin/emberline", "render", "a b.glb"};
  EXPECT_EQ(shell_command(3, words), "emberline render 'a b.glb'");
}

}  // namespace
}  // namespace emberline
