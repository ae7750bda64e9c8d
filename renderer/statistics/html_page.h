// Makes self-contained HTML pages: each is one file without external resources or scripts. Pages
// follow the reader's setting of light or dark mode, and are suitable for phones and for print.
//
// All strings are treated as text and escaped, so that a file called "<b>&.glb" is shown correctly.
// Only values of the type Markup are not escaped; the functions below and those of svg_chart.h
// return such values. Pages share no state, so separate pages may be built on separate threads.
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

// Escapes text for use between tags and in double-quoted attributes. Invalid UTF-8 and control
// characters that HTML forbids become U+FFFD.
std::string escape_html(std::string_view text);

// Encodes bytes in base64 (RFC 4648, section 4), with padding.
std::string base64(std::span<const unsigned char> bytes);

// Embeds an encoded picture of width x height pixels. `media_type` is a type such as "image/png",
// and `text` is the alternative text. If `magnified`, the picture is shown as wide as possible,
// without smoothing.
Markup picture_markup(std::span<const unsigned char> encoded, std::string_view media_type,
                      int width, int height, std::string_view text, bool magnified = false);

struct PageCell {
  enum class Tone : uint8_t { kPlain, kGood, kBad };
  PageCell(std::string cell_text = {}, Tone cell_tone = Tone::kPlain)
      : text(std::move(cell_text)), tone(cell_tone) {}
  PageCell(const char* cell_text) : text(cell_text) {}
  std::string text;
  Tone tone = Tone::kPlain;
};

struct PageTable {
  struct Column {
    std::string name;
    bool number = false;  // right-aligned
  };
  std::string caption;                      // empty: no caption
  std::vector<Column> columns;              // if no column has a name, the table has no head
  std::vector<std::vector<PageCell>> rows;  // if a row has too few cells, the others are empty
};

struct PageFigure {
  Markup content;
  std::string caption;
};

class HtmlPage {
 public:
  // `summary` appears below the title.
  explicit HtmlPage(std::string_view title, std::string_view summary = "");

  void section(std::string_view title) { add("<h2>{}</h2>\n", title); }
  void heading(std::string_view title) { add("<h3>{}</h3>\n", title); }  // within a section
  void paragraph(std::string_view text) { add("<p>{}</p>\n", text); }
  void warning(std::string_view text) {
    add("<p class=\"warning\">{}</p>\n", text);
  }  // highlighted
  // Adds text that the reader may copy, in a fixed-width font; long lines wrap.
  void code(std::string_view text) { add("<pre><code>{}</code></pre>\n", text); }
  void list(std::span<const std::string> items);
  void table(const PageTable& table);  // scrolls if wider than the page
  void figures(std::span<const PageFigure> figures, int max_columns = 2);

  std::string finish() const;  // returns the contents of the file

 private:
  // Adds `markup`, with "{}" replaced by the escaped text.
  void add(const char* markup, std::string_view text);

  std::string title_;
  std::string body_;
};

}  // namespace emberline
