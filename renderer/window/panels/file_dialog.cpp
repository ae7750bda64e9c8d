#include "renderer/window/panels/file_dialog.h"

#include <imgui.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "renderer/core/file_suffix.h"
#include "renderer/window/panels/theme.h"
#include "renderer/window/panels/widgets.h"

namespace emberline {
namespace {

namespace fs = std::filesystem;

// Opens the dialog in the centre of the window.
bool begin_popup(const char* title) {
  const float em = ImGui::GetFontSize();
  const ImVec2 screen = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.5f * screen.x, 0.5f * screen.y}, ImGuiCond_Appearing, {0.5f, 0.5f});
  ImGui::SetNextWindowSize(
      {std::min(38.0f * em, 0.9f * screen.x), std::min(28.0f * em, 0.9f * screen.y)},
      ImGuiCond_Appearing);
  return ImGui::BeginPopupModal(title, nullptr, ImGuiWindowFlags_NoSavedSettings);
}

}  // namespace

FileDialog::FileDialog(const char* title, const char* verb, Purpose purpose,
                       std::vector<std::string> suffixes)
    : title_(title), verb_(verb), purpose_(purpose), suffixes_(std::move(suffixes)) {}

void FileDialog::open(const std::string& path) {
  std::error_code failed;
  fs::path full_path = fs::absolute(path.empty() ? "." : path, failed).lexically_normal();
  name_.clear();
  unconfirmed_.clear();
  if (!fs::is_directory(full_path, failed)) {
    name_ = full_path.filename().string();
    full_path = full_path.parent_path();
  }
  enter(full_path.string());
  is_opening_ = true;
  ++open_count_;
}

void FileDialog::enter(const std::string& folder) {
  folder_ = folder;
  entries_.clear();
  std::error_code failed;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, failed)) {
    std::error_code unknown;
    const std::string name = entry.path().filename().string();
    if (name.starts_with('.')) continue;
    if (entry.is_directory(unknown)) {
      entries_.push_back({name, true});
    } else if (std::ranges::find(suffixes_, lower_suffix(name)) != suffixes_.end()) {
      entries_.push_back({name, false});
    }
  }
  std::ranges::sort(entries_, [](const Entry& a, const Entry& b) {
    return a.folder != b.folder ? a.folder : lower_case(a.name) < lower_case(b.name);
  });
}

bool FileDialog::is_confirmed(const std::string& path) {
  std::error_code unknown;
  if (purpose_ == Purpose::kRead || path == unconfirmed_ || !fs::exists(path, unknown)) return true;
  unconfirmed_ = path;
  focus_requested_ = true;
  return false;
}

bool FileDialog::draw_files(std::string* next) {
  bool done = false;
  if (widgets::button("Up", "Go to the parent folder"))
    *next = fs::path(folder_).parent_path().string();
  ImGui::SameLine();
  ImGui::AlignTextToFramePadding();
  ImGui::TextColored(muted_colour(), "%s", folder_.c_str());
  if (!ImGui::BeginListBox("##files", {-FLT_MIN, -2.6f * ImGui::GetFrameHeight()})) return false;
  for (const Entry& entry : entries_) {
    const std::string label = entry.folder ? entry.name + "/" : entry.name;
    if (ImGui::Selectable(
            label.c_str(), entry.name == name_,
            ImGuiSelectableFlags_AllowDoubleClick | ImGuiSelectableFlags_DontClosePopups)) {
      if (entry.folder) {
        *next = (fs::path(folder_) / entry.name).string();
      } else {
        name_ = entry.name;
        done = ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left);
      }
    }
  }
  ImGui::EndListBox();
  return done;
}

void FileDialog::draw(const std::function<void(const std::string&)>& chosen) {
  const bool is_new = std::exchange(is_opening_, false);
  const bool cancelled = std::exchange(cancelled_, false);
  has_keyboard_ = false;
  if (is_new) ImGui::OpenPopup(title_);
  if (!begin_popup(title_)) return;

  std::string next;
  bool done = draw_files(&next);
  const float em = ImGui::GetFontSize();
  std::error_code failed;
  fs::path full_path = fs::path(folder_) / name_;  // equals `name_` if that is absolute
  const bool is_confirming = !unconfirmed_.empty() && full_path == unconfirmed_;
  const float buttons = 13.0f * em;
  ImGui::SetNextItemWidth(-buttons);
  if (is_new || std::exchange(focus_requested_, false)) ImGui::SetKeyboardFocusHere();
  ImGui::PushID(open_count_);  // a new id makes ImGui select the field's text
  done |= widgets::input_line("##name", "File name or path", name_);
  has_keyboard_ = ImGui::IsItemActive();
  ImGui::PopID();
  ImGui::SameLine();
  done |= is_confirming ? widgets::button("Replace", "Replace the existing file", 6.0f * em)
                        : widgets::button(verb_, "Use this file, or go to this folder", 6.0f * em);
  ImGui::SameLine();
  if (widgets::button("Cancel", "Close without choosing a file (Esc)", 6.0f * em) || cancelled) {
    ImGui::CloseCurrentPopup();
  }
  if (is_confirming) ImGui::TextColored(warning_colour(), "This file already exists.");
  full_path = fs::path(folder_) / name_;
  if (done && !name_.empty() && fs::is_directory(full_path, failed)) {
    next = full_path.string();
    done = false;
  }
  if (done && !name_.empty() && is_confirmed(full_path.string())) {
    chosen(full_path.string());
    ImGui::CloseCurrentPopup();
  }
  if (!next.empty()) {
    enter(next);
    name_.clear();
  }
  ImGui::EndPopup();
}

}  // namespace emberline
