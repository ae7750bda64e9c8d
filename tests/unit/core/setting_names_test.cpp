#include "renderer/core/setting_names.h"

#include <gtest/gtest.h>

#include "renderer/core/errors.h"
#include "renderer/core/log.h"

namespace emberline {
namespace {

class SettingNames : public testing::Test {
 protected:
  ~SettingNames() override {
    spell_settings([](std::string_view name) { return std::string(name); });
    set_log_sink({});
  }
};

std::string as_option(std::string_view name) {
  return name == "shadow" ? "" : "--" + std::string(name);
}

TEST_F(SettingNames, AreBareByDefault) {
  EXPECT_EQ(spell_setting_names("`spp`: 3 is no power of two, as `filter-radius` needs"),
            "spp: 3 is no power of two, as filter-radius needs");
}

TEST_F(SettingNames, AreSpelledByTheClient) {
  spell_settings(as_option);
  EXPECT_EQ(spell_setting_names("`spp`"), "--spp");
  EXPECT_EQ(spell_setting_names("a `spp` b `max-spp`"), "a --spp b --max-spp");
}

TEST_F(SettingNames, AllElseBetweenBackticksStays) {
  spell_settings(as_option);
  for (const char* text : {"", "`", "``", "no name", "`emberline merge`", "the layer `shadow`",
                           "`A`", "an open `spp", "`two\nlines`"}) {
    EXPECT_EQ(spell_setting_names(text), text);
  }
  EXPECT_EQ(spell_setting_names("`not one` `spp`"), "`not one` --spp");
  EXPECT_EQ(spell_setting_names("it`s `spp`"), "it`s --spp");
}

TEST_F(SettingNames, ErrorsAndMessagesAreSpelled) {
  spell_settings(as_option);
  EXPECT_STREQ(UsageError("`spp`: {}", 3).what(), "--spp: 3");
  EXPECT_STREQ(InputError("file", "`spp`").what(), "file: --spp");
  std::string message;
  set_log_sink([&](LogKind, std::string_view text) { message = text; });
  log_warning("give `spp`");
  EXPECT_EQ(message, "give --spp");
  log_error("`spp`");
  EXPECT_EQ(message, "--spp");
}

}  // namespace
}  // namespace emberline
