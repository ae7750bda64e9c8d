// A dialog for choosing a file to open or to write, because the window library has none.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace emberline {

class FileDialog {
 public:
  enum class Purpose : uint8_t {
    kRead,
    kWrite,  // asks before it replaces an existing file
  };

  // The dialog lists files with these lower-case `suffixes`.
  FileDialog(const char* title, const char* verb, Purpose purpose,
             std::vector<std::string> suffixes);

  // `path` is the initial file or folder.
  void open(const std::string& path);
  // Closes the dialog the next time it is drawn.
  void cancel() { cancelled_ = true; }
  const char* title() const { return title_; }
  // Returns whether the name field had keyboard focus when it was last drawn.
  bool has_keyboard() const { return has_keyboard_; }
  // Call each frame. Draws the dialog while it is open, and calls `chosen` with the path that the
  // user chooses.
  void draw(const std::function<void(const std::string&)>& chosen);

 private:
  struct Entry {
    std::string name;
    bool folder = false;
  };
  void enter(const std::string& folder);
  // Returns whether `path` may be chosen now. Before an existing file is replaced, the user must
  // confirm.
  bool is_confirmed(const std::string& path);
  // Draws the folder's contents. Returns whether the user chose a file. If the user chose a folder,
  // sets `next` to that folder.
  bool draw_files(std::string* next);

  const char* title_;
  const char* verb_;
  Purpose purpose_;
  std::vector<std::string> suffixes_;
  std::string folder_, name_;
  std::string unconfirmed_;  // full path of an existing file that needs confirmation
  std::vector<Entry> entries_;
  int open_count_ = 0;
  bool is_opening_ = false, cancelled_ = false, focus_requested_ = false, has_keyboard_ = false;
};

}  // namespace emberline
