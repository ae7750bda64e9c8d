#include "io/image/file_completeness.h"

#include <gtest/gtest.h>

#include <fstream>

#include "io/display/display.h"
#include "io/files/input_file.h"
#include "renderer/core/errors.h"
#include "support/temp_folder.h"

namespace emberline {
namespace {

class PictureMark : public ::testing::Test {
 protected:
  std::string picture(const std::string& name, bool complete) const {
    DisplayImageWriter writer(folder_ / name, Rect{0, 0, 9, 7},
                              std::make_shared<DisplayTransform>(DisplaySettings()), false);
    writer.finish(complete);
    return folder_ / name;
  }
  void write(const std::string& name, std::string_view bytes) const {
    std::ofstream(folder_ / name, std::ios::binary).write(bytes.data(), std::ssize(bytes));
  }
  test::TempFolder folder_;
};

TEST_F(PictureMark, ReadsTheWrittenMark) {
  for (const char* name : {"a.png", "a.jpg"}) {
    EXPECT_FALSE(is_unfinished_image(picture(name, true))) << name;
    EXPECT_TRUE(is_unfinished_image(picture(name, false))) << name;
  }
}

TEST_F(PictureMark, AnyFileIsReadOrRefused) {
  EXPECT_THROW(is_unfinished_image(folder_ / "none.png"), InputError);
  write("text.png", "no picture");
  EXPECT_THROW(is_unfinished_image(folder_ / "text.png"), InputError);
  write("empty.png", "");
  EXPECT_THROW(is_unfinished_image(folder_ / "empty.png"), InputError);
  const std::string_view begins[] = {"\x76\x2f\x31\x01", "\x89PNG\r\n\x1a\n", "\xff\xd8"};
  for (const std::string_view begin : begins) {
    for (const std::string_view rest : {"", "\xff\xff\xff\xff\xff\xff\xff\xff", "\x7f\xff"}) {
      write("odd.png", std::string(begin) + std::string(rest));
      EXPECT_FALSE(is_unfinished_image(folder_ / "odd.png"));
    }
  }
  // Wherever the file is truncated, the function does not throw.
  const std::vector<uint8_t> whole = InputFile(picture("a.png", false)).read_all();
  for (size_t size = 8; size < whole.size(); ++size) {
    write("cut.png", {reinterpret_cast<const char*>(whole.data()), size});
    EXPECT_NO_THROW(is_unfinished_image(folder_ / "cut.png")) << size;
  }
}

}  // namespace
}  // namespace emberline
