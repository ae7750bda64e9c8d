// Tests labels of command-line values, and the style of labels and tooltips.
#include "renderer/window/panels/label.h"

#include <gtest/gtest.h>

#include <cctype>

#include "renderer/window/panels/material_rows.h"

namespace emberline {
namespace {

TEST(Label, ValuesBecomeTitles) {
  EXPECT_EQ(title_case(""), "");
  EXPECT_EQ(title_case("path"), "Path");
  EXPECT_EQ(title_case("blue_noise"), "Blue Noise");
  EXPECT_EQ(title_case("two-stream"), "Two-Stream");
  EXPECT_EQ(title_case("not finite"), "Not Finite");
  EXPECT_EQ(title_case("material_id"), "Material ID");
  EXPECT_EQ(title_case("uv"), "UV");
}

TEST(Label, SummariesBecomeSentences) {
  EXPECT_EQ(sentence_case(""), "");
  EXPECT_EQ(sentence_case("from the middle outwards"), "From the middle outwards");
}

TEST(Label, MaterialRowsHaveTitlesAndSentences) {
  const auto begins_with_capital = [](std::string_view text) {
    return !text.empty() && std::isupper(static_cast<unsigned char>(text[0]));
  };
  for (const MaterialGroup& group : material_groups()) {
    EXPECT_EQ(title_case(group.name), group.name);
    EXPECT_TRUE(begins_with_capital(group.help.text())) << group.name;
    for (const MaterialRow& row : group.rows) {
      EXPECT_EQ(title_case(row.label), row.label);
      const std::string_view help = row.help.text();
      EXPECT_TRUE(begins_with_capital(help) || std::isdigit(static_cast<unsigned char>(help[0])))
          << row.label << ": " << help;
    }
  }
}

}  // namespace
}  // namespace emberline
