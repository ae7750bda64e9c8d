#include "renderer/app/study_page.h"

#include <fmt/format.h>

#include <filesystem>

#include "io/atomic_file.h"
#include "renderer/app/study_files.h"

namespace emberline {
namespace {

std::string escaped(std::string_view text) {
  std::string html;
  for (const char c : text) {
    html += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
  }
  return html;
}

}  // namespace

void write_study_page(const StudyResults& results, const std::string& folder) {
  const std::string page = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}</title></head>\n"
      "<body><h1>Speed against error: {0}</h1>\n<pre>{1}</pre>\n<p><code>{2}</code></p>\n"
      "</body></html>\n",
      escaped(results.settings.scene), escaped(study_table(results)),
      escaped(results.settings.command_line));
  write_file_atomically((std::filesystem::path(folder) / "study.html").string(), page);
}

}  // namespace emberline
