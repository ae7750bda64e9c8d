#include "renderer/statistics/html_page.h"

#include <fmt/format.h>

#include <algorithm>

#include "renderer/core/utf8.h"

namespace emberline {
namespace {

constexpr std::string_view kReplacement = "\xef\xbf\xbd";  // U+FFFD

constexpr std::pair<char, std::string_view> kEntities[] = {
    {'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}, {'\'', "&#39;"}};

bool is_forbidden_control(std::string_view sequence) {
  return is_control(sequence) && sequence != "\t" && sequence != "\n";
}

// The style supports light and dark mode, screens of any width, and print.
constexpr std::string_view kStyle = R"(:root { color-scheme: light dark;
  --page: #fff; --text: #1c1e21; --faint: #5c6370; --line: #d5d9df; --block: #f3f5f7;
  --bad: #a8321e; --good: #0a6b4b; }
@media (prefers-color-scheme: dark) { :root {
  --page: #16181c; --text: #e4e6ea; --faint: #a0a7b4; --line: #383d46; --block: #20242a;
  --bad: #ff9b85; --good: #6fd3ae; } }
* { box-sizing: border-box; }
html { background: var(--page); -webkit-text-size-adjust: 100%; }
body { margin: 0 auto; padding: 1.5rem clamp(0.9rem, 3vw, 2.5rem) 4rem; max-width: 78rem;
  background: var(--page); color: var(--text); font: 16px/1.5 system-ui, sans-serif;
  overflow-wrap: break-word; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0 0 0.3rem; overflow-wrap: anywhere; }
h2 { font-size: 1.25rem; margin: 2.4rem 0 0.7rem; padding-top: 0.7rem; border-top: 1px solid var(--line); }
h3 { font-size: 1.03rem; margin: 1.5rem 0 0.5rem; }
p { margin: 0.5rem 0; max-width: 48rem; }
.summary { color: var(--faint); margin-bottom: 1.2rem; overflow-wrap: anywhere; }
.warning { border-left: 4px solid var(--bad); background: var(--block); padding: 0.5rem 0.8rem; }
ul { margin: 0.5rem 0; padding-left: 1.2rem; }
pre { background: var(--block); border: 1px solid var(--line); border-radius: 6px;
  padding: 0.7rem 0.9rem; margin: 0.5rem 0; white-space: pre-wrap; overflow-wrap: anywhere;
  font: 0.85rem/1.5 ui-monospace, monospace; }
.wide { overflow-x: auto; margin: 0.7rem 0; }
table { border-collapse: collapse; font-size: 0.92rem; font-variant-numeric: tabular-nums; }
caption { text-align: left; color: var(--faint); padding-bottom: 0.3rem; }
th, td { text-align: left; vertical-align: top; padding: 0.25rem 1.1rem 0.25rem 0;
  border-bottom: 1px solid var(--line); }
th { font-weight: 600; }
tbody th { font-weight: 400; color: var(--faint); }
td { overflow-wrap: anywhere; min-width: 3.5rem; }
.n { text-align: right; overflow-wrap: normal; }
.k { white-space: nowrap; }
.bad { color: var(--bad); font-weight: 600; }
.good { color: var(--good); font-weight: 600; }
.figures { display: grid; gap: 1.2rem; margin: 0.9rem 0; align-items: start;
  grid-template-columns: repeat(var(--columns), minmax(0, 1fr)); }
figure { margin: 0; min-width: 0; break-inside: avoid; }
figure img { display: block; max-width: 100%; height: auto; border-radius: 3px; }
figure img.pixels { width: 100%; image-rendering: pixelated; }
figure svg { display: block; width: 100%; height: auto; max-width: 46rem; }
figcaption { color: var(--faint); font-size: 0.86rem; margin-top: 0.35rem; }
@media (max-width: 46rem) { .figures { grid-template-columns: minmax(0, 1fr); }
  .figures.small { grid-template-columns: repeat(2, minmax(0, 1fr)); gap: 0.7rem; }
  table { font-size: 0.84rem; } th, td { padding-right: 0.7rem; } }
@media print { :root { --page: #fff; --text: #000; --faint: #444; --line: #bbb; --block: #fff;
    --bad: #8a1f0e; --good: #064f37; color-scheme: light; }
  @page { margin: 14mm; }
  body { padding: 0; max-width: none; font-size: 10pt; }
  table { font-size: 8.5pt; } th, td { padding-right: 0.7rem; min-width: 0; }
  h2, h3 { break-after: avoid; } tr { break-inside: avoid; } .wide { overflow: visible; }
  thead { display: table-header-group; } }
)";

// Keeps a word with a hyphen on one line, because browsers may break a line after any hyphen, even
// in "2.37e-06".
std::string number_markup(std::string_view text) {
  std::string html;
  while (true) {
    const size_t end = text.find(' ');
    const std::string_view word = text.substr(0, end);
    const bool hyphened = word.find('-') != std::string_view::npos;
    html += hyphened ? fmt::format(R"(<span class="k">{}</span>)", escape_html(word))
                     : escape_html(word);
    if (end == std::string_view::npos) return html;
    html += ' ';
    text.remove_prefix(end + 1);
  }
}

std::string cell_markup(const PageCell& cell, bool head, bool number) {
  constexpr const char* kTones[] = {"", "good", "bad"};
  const std::string tone = kTones[size_t(cell.tone)];
  std::string classes = number ? "n" : "";
  if (!tone.empty()) classes += (number ? " " : "") + tone;
  const std::string attribute = classes.empty() ? "" : fmt::format(R"( class="{}")", classes);
  return head ? fmt::format(R"(<th scope="row"{}>{}</th>)", attribute, escape_html(cell.text))
              : fmt::format("<td{}>{}</td>", attribute,
                            number ? number_markup(cell.text) : escape_html(cell.text));
}

}  // namespace

std::string escape_html(std::string_view text) {
  std::string html;
  html.reserve(text.size());
  while (!text.empty()) {
    const size_t length = utf8_length(text);
    const std::string_view sequence = text.substr(0, std::max<size_t>(length, 1));
    const auto entity =
        std::ranges::find(kEntities, sequence[0], &std::pair<char, std::string_view>::first);
    html += length == 0 || is_forbidden_control(sequence) ? kReplacement
            : entity == std::end(kEntities)               ? sequence
                                                          : entity->second;
    text.remove_prefix(sequence.size());
  }
  return html;
}

std::string base64(std::span<const unsigned char> bytes) {
  constexpr std::string_view kAlphabet =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    // Three bytes become four letters, each of which stands for six bits: "Man" = 4d 61 6e = 010011
    // 010110 000101 101110.
    const size_t byte_count = std::min<size_t>(3, bytes.size() - i);
    uint32_t bits = 0;
    for (size_t k = 0; k < 3; ++k) bits = bits << 8 | (k < byte_count ? bytes[i + k] : 0u);
    for (size_t k = 0; k < 4; ++k) {
      text += k <= byte_count ? kAlphabet[bits >> (18 - 6 * k) & 63u] : '=';
    }
  }
  return text;
}

Markup picture_markup(std::span<const unsigned char> encoded, std::string_view media_type,
                      int width, int height, std::string_view text, bool magnified) {
  return {fmt::format(R"(<img src="data:{};base64,{}" width="{}" height="{}" alt="{}"{}>)",
                      escape_html(media_type), base64(encoded), width, height, escape_html(text),
                      magnified ? R"( class="pixels")" : "")};
}

HtmlPage::HtmlPage(std::string_view title, std::string_view summary) : title_(escape_html(title)) {
  add("<h1>{}</h1>\n", title);
  if (!summary.empty()) add("<p class=\"summary\">{}</p>\n", summary);
}

void HtmlPage::add(const char* markup, std::string_view text) {
  body_ += fmt::format(fmt::runtime(markup), escape_html(text));
}

void HtmlPage::list(std::span<const std::string> items) {
  if (items.empty()) return;
  body_ += "<ul>\n";
  for (const std::string& item : items) add("<li>{}</li>\n", item);
  body_ += "</ul>\n";
}

void HtmlPage::table(const PageTable& table) {
  const auto is_number = [&](size_t c) {
    return c < table.columns.size() && table.columns[c].number;
  };
  body_ += "<div class=\"wide\"><table>\n";
  if (!table.caption.empty()) add("<caption>{}</caption>\n", table.caption);
  if (std::ranges::any_of(table.columns, [](const auto& column) { return !column.name.empty(); })) {
    body_ += "<thead><tr>";
    for (size_t c = 0; c < table.columns.size(); ++c) {
      body_ += fmt::format(R"(<th scope="col"{}>{}</th>)", is_number(c) ? R"( class="n")" : "",
                           escape_html(table.columns[c].name));
    }
    body_ += "</tr></thead>\n";
  }
  body_ += "<tbody>\n";
  for (const std::vector<PageCell>& row : table.rows) {
    body_ += "<tr>";
    for (size_t c = 0; c < std::max(row.size(), table.columns.size()); ++c) {
      body_ += cell_markup(c < row.size() ? row[c] : PageCell(), c == 0, is_number(c));
    }
    body_ += "</tr>\n";
  }
  body_ += "</tbody></table></div>\n";
}

void HtmlPage::figures(std::span<const PageFigure> figures, int max_columns) {
  if (figures.empty()) return;
  const int columns = std::clamp(int(figures.size()), 1, std::max(1, max_columns));
  body_ += fmt::format("<div class=\"figures{}\" style=\"--columns:{}\">\n",
                       columns > 2 ? " small" : "", columns);
  for (const PageFigure& figure : figures) {
    body_ += "<figure>" + figure.content.html;
    if (!figure.caption.empty()) add("<figcaption>{}</figcaption>", figure.caption);
    body_ += "</figure>\n";
  }
  body_ += "</div>\n";
}

std::string HtmlPage::finish() const {
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
         title_ + "</title>\n<style>\n" + std::string(kStyle) + "</style>\n</head>\n<body>\n" +
         body_ + "</body>\n</html>\n";
}

}  // namespace emberline
