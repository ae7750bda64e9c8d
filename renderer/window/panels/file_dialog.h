// A dialog that asks for a file: to open one that is there, or to name one to write. The window
// library has none.
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
    kWrite,  // a file that is there is chosen only once the dialog has asked
  };

  // `suffixes`: of the files that are listed, lower case.
  FileDialog(const char* title, const char* verb, Purpose purpose,
             std::vector<std::string> suffixes);

  // `path`: where to begin, a file or folder.
  void open(const std::string& path);
  // Closes it, if it is open, when it is drawn next.
  void cancel() { cancelled_ = true; }
  const char* title() const { return title_; }
  // Whether keys go to the name, when it was drawn last.
  bool has_keyboard() const { return has_keyboard_; }
  // Draws it while it is open; calls `chosen` with the path. Each frame.
  void draw(const std::function<void(const std::string&)>& chosen);

 private:
  struct Entry {
    std::string name;
    bool folder = false;
  };
  void enter(const std::string& folder);
  // Whether `path` can be chosen: not before it was asked for twice where it would be replaced.
  bool agreed(const std::string& path);
  // The list of the folder's files. True if one was chosen; `next` is the folder to go to, if any.
  bool draw_files(std::string* next);

  const char* title_;
  const char* verb_;
  Purpose purpose_;
  std::vector<std::string> suffixes_;
  std::string folder_, name_;
  std::string replaced_;  // is there, as the dialog says; whole path
  std::vector<Entry> entries_;
  int openings_ = 0;
  bool opening_ = false, cancelled_ = false, asked_ = false, has_keyboard_ = false;
};

}  // namespace emberline
