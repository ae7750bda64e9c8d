#include "renderer/output/finished_frame.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>

#include "io/files/input_file.h"
#include "io/image/file_completeness.h"
#include "io/json/input.h"
#include "renderer/core/errors.h"
#include "renderer/core/file_suffix.h"
#include "renderer/output/recorded_settings.h"
#include "renderer/output/report_page.h"
#include "renderer/output/snapshots.h"

namespace emberline {
namespace {

bool has_content(const std::string& path) {
  std::error_code error;
  return std::filesystem::is_regular_file(path, error) &&
         std::filesystem::file_size(path, error) > 0 && !error;
}

bool is_complete(const std::string& path) {
  return has_content(path) && is_complete_file(path) && !is_unfinished_image(path);
}

bool ends_with(const std::string& path, std::string_view text) {
  const InputFile file(path);
  std::string end(text.size(), '\0');
  return file.size() >= end.size() &&
         file.try_read(file.size() - end.size(), end.size(), end.data()) > 0 && end == text;
}

bool is_complete_report(const std::string& path) {
  if (!has_content(path)) return false;
  if (is_page(path)) return ends_with(path, "</html>\n");
  if (!ends_with(path, "}\n")) return false;
  const nlohmann::json json = read_json(path);
  return json.is_object() && json.value("complete", nlohmann::json()) == true;
}

bool is_complete_tree(const std::string& path) {
  if (!is_json(path)) return is_complete(path);
  return has_content(path) && read_json(path).is_object();
}

// Checks only the snapshots that exist, because it is unknown how many the frame should have.
bool are_complete_snapshots(const std::string& folder) {
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string path = entry->path().string();
    if (!is_snapshot_name(entry->path().filename().string()) || is_json(path)) continue;
    if (!has_content(path) || !is_complete_file(path)) return false;
  }
  return true;
}

}  // namespace

bool is_finished(const RenderOptions& options) {
  const std::string checkpoint = checkpoint_path(options);
  if (!checkpoint.empty() && !retains_checkpoint(options) && has_content(checkpoint)) return false;
  try {
    return std::ranges::all_of(options.outputs, is_complete) &&
           std::ranges::all_of(options.heatmaps, is_complete) &&
           std::ranges::all_of(options.trees, is_complete_tree) &&
           std::ranges::all_of(options.reports, is_complete_report) &&
           (options.snapshots.empty() || are_complete_snapshots(options.snapshots));
  } catch (const InputError&) {
    return false;  // unreadable
  }
}

std::string skip_reason(const RenderOptions& options) {
  constexpr size_t kMaxListed = 3;
  constexpr std::string_view kReason = "all its outputs exist";
  for (const std::string& path : options.outputs) {
    if (!is_exr(path)) continue;
    const RecordedSettings recorded(exr_texts(path, "emberline:"));
    if (!recorded.is_ours()) continue;
    const std::vector<std::string> list = recorded.changes(options);
    if (list.empty()) continue;
    const std::span shown(list.data(), std::min(list.size(), kMaxListed));
    return fmt::format("{}, but {} has other settings: {}{}", kReason, path, fmt::join(shown, ", "),
                       list.size() > kMaxListed ? " and more" : "");
  }
  return std::string(kReason);
}

}  // namespace emberline
