// A dialog that asks for a file: to open one that is there, or to name one to write. The window
// library has none.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace emberline {

class FileDialog {
 public:
  // `suffixes`: of the files that are listed, lower case. `path`: where to begin, a file or folder.
  FileDialog(const char* title, const char* verb, std::vector<std::string> suffixes);

  void open(const std::string& path);
  // Closes it, if it is open, when it is drawn next.
  void cancel() { cancelled_ = true; }
  // Draws it while it is open; calls `chosen` with the path. Each frame.
  void draw(const std::function<void(const std::string&)>& chosen);

 private:
  struct Entry {
    std::string name;
    bool folder = false;
  };
  void enter(const std::string& folder);

  const char* title_;
  const char* verb_;
  std::vector<std::string> suffixes_;
  std::string folder_, name_;
  std::vector<Entry> entries_;
  bool opening_ = false, cancelled_ = false;
};

}  // namespace emberline
