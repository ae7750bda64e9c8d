// Tests pages: text is escaped correctly, and the file is self-contained.
#include "renderer/statistics/html_page.h"

#include <gtest/gtest.h>

#include "support/markup.h"

namespace emberline::test {
namespace {

std::span<const unsigned char> bytes_of(std::string_view text) {
  return {reinterpret_cast<const unsigned char*>(text.data()), text.size()};
}

// RFC 4648, section 10, has these vectors.
TEST(Base64, StandardTestVectors) {
  EXPECT_EQ(base64(bytes_of("")), "");
  EXPECT_EQ(base64(bytes_of("f")), "Zg==");
  EXPECT_EQ(base64(bytes_of("fo")), "Zm8=");
  EXPECT_EQ(base64(bytes_of("foo")), "Zm9v");
  EXPECT_EQ(base64(bytes_of("foob")), "Zm9vYg==");
  EXPECT_EQ(base64(bytes_of("fooba")), "Zm9vYmE=");
  EXPECT_EQ(base64(bytes_of("foobar")), "Zm9vYmFy");
}

// The 64 groups of six bits in these 48 bytes count up, which gives every letter of the alphabet in
// order.
TEST(Base64, EveryLetter) {
  std::string bytes;
  for (unsigned i = 0; i < 64; i += 4) {
    const unsigned bits = i << 18 | (i + 1) << 12 | (i + 2) << 6 | (i + 3);
    for (const unsigned shift : {16u, 8u, 0u}) bytes += char(bits >> shift & 0xff);
  }
  EXPECT_EQ(base64(bytes_of(bytes)),
            "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/");
}

TEST(EscapeHtml, EscapesMarkup) {
  EXPECT_EQ(escape_html("a<b>&\"c'.glb"), "a&lt;b&gt;&amp;&quot;c&#39;.glb");
  EXPECT_EQ(escape_html("&amp;"), "&amp;amp;");
  EXPECT_EQ(escape_html("two\nlines\tand a tab"), "two\nlines\tand a tab");
}

TEST(EscapeHtml, KeepsUtf8AndReplacesInvalidBytes) {
  for (const std::string_view kept :
       {"Küche", "場面.glb", "🔥", "\xc2\xa0", "\xed\x9f\xbf", "\xee\x80\x80", "\xf4\x8f\xbf\xbf"}) {
    EXPECT_EQ(escape_html(kept), kept);
  }
  const std::string r = "\xef\xbf\xbd";
  EXPECT_EQ(escape_html("a\xff"
                        "b"),
            "a" + r + "b");                                   // invalid byte
  EXPECT_EQ(escape_html("\x80"), r);                          // stray continuation byte
  EXPECT_EQ(escape_html("\xe2\x82"), r + r);                  // truncated
  EXPECT_EQ(escape_html("\xc0\xaf"), r + r);                  // overlong "/"
  EXPECT_EQ(escape_html("\xe0\x80\xbc"), r + r + r);          // overlong "<"
  EXPECT_EQ(escape_html("\xed\xa0\x80"), r + r + r);          // a surrogate
  EXPECT_EQ(escape_html("\xf4\x90\x80\x80"), r + r + r + r);  // beyond U+10FFFF
  EXPECT_EQ(escape_html("\xf0\x8f\xbf\xbf"), r + r + r + r);  // overlong
  EXPECT_EQ(escape_html(std::string_view("\0\x1b\x7f", 3)), r + r + r);
  EXPECT_EQ(escape_html("\xc2\x85"), r);        // a C1 control
  EXPECT_EQ(escape_html("\xc3<"), r + "&lt;");  // does not consume the next character
}

constexpr std::string_view kOdd = "<script>alert('\"&amp;')</script> Küche 場面";

// Passes text that would be harmful as markup to every function that takes text.
TEST(HtmlPage, TextStaysTextEverywhere) {
  const std::string odd(kOdd);
  HtmlPage page(odd, odd);
  page.section(odd);
  page.heading(odd);
  page.paragraph(odd);
  page.warning(odd);
  page.list(std::vector<std::string>{odd});
  page.code(odd);
  page.table({odd, {{odd}, {odd, true}}, {{PageCell(odd), PageCell(odd, PageCell::Tone::kBad)}}});
  page.figures(
      std::vector<PageFigure>{{picture_markup(bytes_of("x"), "image/png", 1, 1, odd), odd}});
  const ParsedMarkup read = read_markup(page.finish());
  ASSERT_EQ(read.fault, "");
  EXPECT_EQ(read.count("script"), 0u);
  size_t found = 0;
  for (size_t at = read.text.find(odd); at != std::string::npos; at = read.text.find(odd, at + 1)) {
    ++found;
  }
  // The text is in the title twice, and in the summary, six functions, a caption, two heads, two
  // cells and the figure's caption.
  EXPECT_EQ(found, 15u);
  const auto image = std::ranges::find(read.elements, "img", &Element::name);
  ASSERT_NE(image, read.elements.end());
  EXPECT_EQ(image->attributes.at("alt"), odd);
  EXPECT_EQ(image->attributes.at("src"), "data:image/png;base64,eA==");
}

// A page fetches nothing: it has only data URIs, no scripts and no external style sheets.
TEST(HtmlPage, NeedsNoOtherFiles) {
  HtmlPage page("t");
  page.figures(
      std::vector<PageFigure>{{picture_markup(bytes_of("x"), "image/png", 7, 5, "", true), ""}});
  const std::string html = page.finish();
  const ParsedMarkup read = read_markup(html);
  EXPECT_EQ(read.fault, "");
  for (const Element& element : read.elements) {
    EXPECT_TRUE(element.name != "script" && element.name != "link") << element.name;
    if (element.attributes.contains("src")) {
      EXPECT_TRUE(element.attributes.at("src").starts_with("data:"));
    }
  }
  for (const std::string_view word : {"url(", "@import", "http:", "https:"}) {
    EXPECT_EQ(html.find(word), std::string::npos) << word;
  }
  for (const std::string_view word :
       {"prefers-color-scheme: dark", "@media print", "width=device-width", "charset=\"utf-8\""}) {
    EXPECT_NE(html.find(word), std::string::npos) << word;
  }
}

TEST(HtmlPage, TablesFillShortRowsAndLeaveOutAnEmptyHead) {
  HtmlPage page("t");
  page.table({"", {{""}, {"", true}, {""}}, {{"a"}, {"b", "1", "2"}}});
  const ParsedMarkup read = read_markup(page.finish());
  EXPECT_EQ(read.fault, "");
  EXPECT_EQ(read.count("thead"), 0u);
  EXPECT_EQ(read.count("td"), 4u);
  EXPECT_EQ(read.count("th"), 2u);  // row headers
  EXPECT_NE(page.finish().find("<th scope=\"row\">b</th><td class=\"n\">1</td><td>2</td>"),
            std::string::npos);
}

TEST(HtmlPage, NumbersAreNotBrokenAtTheirHyphens) {
  HtmlPage page("t");
  page.table({"", {{""}, {"", true}, {""}}, {{"a-b", "2e-06 [1e-06, <3] -", "c-d e"}}});
  const std::string html = page.finish();
  EXPECT_EQ(read_markup(html).fault, "");
  EXPECT_NE(html.find("<span class=\"k\">2e-06</span> <span class=\"k\">[1e-06,</span> &lt;3] "
                      "<span class=\"k\">-</span></td><td>c-d e</td>"),
            std::string::npos);
}

TEST(HtmlPage, NothingForEmptyListsAndFigures) {
  HtmlPage page("t");
  const std::string before = page.finish();
  page.list({});
  page.figures({});
  EXPECT_EQ(page.finish(), before);
}

}  // namespace
}  // namespace emberline::test
