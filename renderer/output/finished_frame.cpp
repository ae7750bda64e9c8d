#include "renderer/output/finished_frame.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "io/json_input.h"
#include "io/picture_mark.h"
#include "renderer/core/errors.h"
#include "renderer/output/report_page.h"

namespace emberline {
namespace {

bool is_there(const std::string& path) {
  std::error_code error;
  return std::filesystem::is_regular_file(path, error) &&
         std::filesystem::file_size(path, error) > 0 && !error;
}

bool is_whole_picture(const std::string& path) {
  try {
    return is_there(path) && !is_marked_incomplete(path);
  } catch (const InputError&) {
    return false;
  }
}

bool is_whole_report(const std::string& path) {
  if (!is_there(path) || is_page(path)) return is_there(path);
  try {
    const nlohmann::json json = read_json(path);
    return json.is_object() && json.value("complete", nlohmann::json()) == true;
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace

bool is_finished(const RenderOptions& options) {
  const std::string checkpoint = checkpoint_path(options);
  if (!checkpoint.empty() && !keeps_checkpoint(options) && is_there(checkpoint)) return false;
  return std::ranges::all_of(options.outputs, is_whole_picture) &&
         std::ranges::all_of(options.heatmaps, is_there) &&
         std::ranges::all_of(options.trees, is_there) &&
         std::ranges::all_of(options.reports, is_whole_report);
}

}  // namespace emberline
