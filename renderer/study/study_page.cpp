#include "renderer/study/study_page.h"

#include <fmt/format.h>

#include <filesystem>

#include "io/atomic_file.h"
#include "renderer/charts/html_page.h"
#include "renderer/study/study_page_pictures.h"
#include "renderer/study/study_page_sections.h"

namespace emberline {
namespace {

std::string summary(const StudySettings& s) {
  std::string budgets = "no budget";
  if (!s.budgets.empty()) {
    budgets = fmt::format("{} to {} {}", study_budget_text(s, s.budgets.front()),
                          study_budget_text(s, s.budgets.back()),
                          s.by_time ? "of rendering" : "(samples per pixel)");
  }
  return fmt::format("{} x {} pixels, {}, {} {}, {} {}", s.width, s.height, budgets, s.seeds,
                     s.seeds == 1 ? "seed" : "seeds", s.threads,
                     s.threads == 1 ? "thread" : "threads");
}

}  // namespace

std::string study_page(const StudyResults& results, const std::string& folder) {
  const std::string scene = std::filesystem::path(results.settings.scene).filename().string();
  HtmlPage page("Speed against error: " + scene, summary(results.settings));
  add_study_warnings(page, results);
  add_study_speedups(page, results);
  add_study_curves(page, results);
  add_study_errors(page, results);
  add_study_pictures(page, results, folder);
  add_study_calibration(page, results);
  add_study_limits(page, results);
  add_study_runs(page, results);
  add_study_settings(page, results);
  return page.finish();
}

void write_study_page(const StudyResults& results, const std::string& folder) {
  write_file_atomically((std::filesystem::path(folder) / "study.html").string(),
                        study_page(results, folder));
}

}  // namespace emberline
