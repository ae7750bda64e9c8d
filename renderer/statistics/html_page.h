// Self-contained HTML pages: one file with everything in it, nothing fetched, no scripts. Reads in
// light and dark (the reader's own setting), on a phone, and on paper.
//
// Whatever a function takes as a string is text and is escaped; what is already markup has the type
// Markup and comes from the functions below or svg_chart.h. So a file called "<b>&.glb" shows as it
// is named. No state is shared: separate pages may be built on separate threads.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace emberline {

struct Markup {
  std::string html;
};

// Safe between tags and in double-quoted attributes. What is not valid UTF-8 becomes U+FFFD, and
// so do the control characters that HTML forbids.
std::string escape_html(std::string_view text);

// RFC 4648, section 4, with padding.
std::string base64(std::span<const unsigned char> bytes);

// An encoded picture ("image/png") of so many pixels inside the page. `text` stands for it where it
// cannot be seen. `magnified`: shown with hard pixels, as wide as there is room.
Markup picture_markup(std::span<const unsigned char> encoded, std::string_view media_type,
                      int width, int height, std::string_view text, bool magnified = false);

struct PageCell {
  enum class Tone : uint8_t { kPlain, kGood, kBad };
  PageCell(std::string words = {}, Tone said = Tone::kPlain) : text(std::move(words)), tone(said) {}
  PageCell(const char* words) : text(words) {}
  std::string text;
  Tone tone = Tone::kPlain;
};

struct PageTable {
  struct Column {
    std::string name;
    bool number = false;  // set flush right
  };
  std::string caption;                      // empty: none
  std::vector<Column> columns;              // without a name in any, the table has no head
  std::vector<std::vector<PageCell>> rows;  // shorter rows are filled up with empty cells
};

struct PageFigure {
  Markup content;
  std::string caption;
};

class HtmlPage {
 public:
  // `summary` stands under the title.
  explicit HtmlPage(std::string_view title, std::string_view summary = "");

  void section(std::string_view title) { add("<h2>{}</h2>\n", title); }
  void heading(std::string_view title) { add("<h3>{}</h3>\n", title); }  // within a section
  void paragraph(std::string_view text) { add("<p>{}</p>\n", text); }
  void warning(std::string_view text) { add("<p class=\"warning\">{}</p>\n", text); }  // stands out
  // Wrapped, to be copied.
  void code(std::string_view text) { add("<pre><code>{}</code></pre>\n", text); }
  void list(std::span<const std::string> items);
  void table(const PageTable& table);  // wider than the page: scrolls by itself
  void figures(std::span<const PageFigure> figures, int most_in_a_row = 2);

  std::string finish() const;  // the file

 private:
  // `markup` with the text, escaped, for its "{}".
  void add(const char* markup, std::string_view text);

  std::string title_;
  std::string body_;
};

}  // namespace emberline
