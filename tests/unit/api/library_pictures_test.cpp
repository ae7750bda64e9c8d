#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "renderer/api/emberline.h"

namespace emberline::api {
namespace {

namespace fs = std::filesystem;

class LibraryPictures : public ::testing::Test {
 protected:
  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override { fs::remove_all(folder_); }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }

  static Picture small() {
    Picture picture;
    picture.width = 3;
    picture.height = 2;
    picture.x = 5;
    picture.y = 1;
    picture.frame_width = 9;
    picture.frame_height = 7;
    picture.channels = {"R", "G", "B", "samples"};
    for (int i = 0; i < 24; ++i) picture.values.push_back(float(i) / 8);
    picture.complete = true;
    return picture;
  }

 private:
  const fs::path folder_ =
      fs::temp_directory_path() / ("emberline_pictures_" + std::to_string(::getpid()));
};

TEST_F(LibraryPictures, AnExrHoldsEveryChannel) {
  Picture picture = small();
  write_picture(file("a.exr"), picture);
  const Picture read = read_picture(file("a.exr"));
  EXPECT_EQ(read.channels, picture.channels);
  EXPECT_EQ(read.x, 5);
  EXPECT_EQ(read.y, 1);
  EXPECT_EQ(read.frame_width, 9);
  EXPECT_EQ(read.frame_height, 7);
  EXPECT_TRUE(read.complete);
  EXPECT_EQ(read.values, picture.values);
  picture.complete = false;
  picture.samples = 77;
  write_picture(file("a.exr"), picture);
  EXPECT_FALSE(read_picture(file("a.exr")).complete);
  EXPECT_EQ(read_picture(file("a.exr")).samples, 77u);
}

TEST_F(LibraryPictures, PngShowsDisplayedValues) {
  Picture picture = small();
  for (float& value : picture.values) value = 0.25f;
  write_picture(file("a.png"), picture, 1.0);
  EXPECT_NEAR(read_picture(file("a.png")).pixel(1, 1)[1], 0.5f, 0.005f);
  const std::vector<uint8_t> bytes = {0, 128, 255, 255, 128, 0};
  write_picture(file("b.png"), bytes.data(), 2, 1, 3);
  const Picture read = read_picture(file("b.png"));
  EXPECT_EQ(read.pixel(0, 0)[0], 0.0f);
  EXPECT_EQ(read.pixel(0, 0)[2], 1.0f);
  EXPECT_EQ(read.pixel(0, 0)[1], read.pixel(1, 0)[1]);
}

TEST_F(LibraryPictures, RejectsUnwritablePictures) {
  const auto refused = [&](const Picture& picture, const std::string& name) {
    EXPECT_THROW(write_picture(file(name), picture), UsageError);
    EXPECT_FALSE(fs::exists(file(name)));
  };
  refused(Picture(), "a.exr");
  refused(small(), "a.gif");
  Picture picture = small();
  picture.values.pop_back();
  refused(picture, "a.exr");
  picture = small();
  picture.channels[3] = "R";
  refused(picture, "a.exr");
  picture.channels[3] = std::string(256, 'x');
  refused(picture, "a.exr");
  picture.channels = {"R", "G", "b", "A"};
  refused(picture, "a.png");
  EXPECT_THROW(write_picture(file("a.png"), small(), NAN), UsageError);
  EXPECT_THROW(write_picture(file("no/a.exr"), small()), RenderError);
  const uint8_t byte = 0;
  EXPECT_THROW(write_picture(file("a.png"), &byte, 1, 1, 2), UsageError);
  EXPECT_THROW(write_picture(file("a.png"), &byte, 0, 1, 1), UsageError);
  EXPECT_THROW(read_picture(file("none.exr")), InputError);
}

// All pixels differ by the same amount, so each metric has a closed form.
TEST_F(LibraryPictures, Compares) {
  std::vector<float> reference(3 * 8 * 8, 0.5f), image(reference.size(), 0.75f);
  const Comparison errors = compare(image.data(), reference.data(), 8, 8);
  EXPECT_DOUBLE_EQ(errors.mse, 0.0625);
  EXPECT_DOUBLE_EQ(errors.rmse, 0.25);
  EXPECT_DOUBLE_EQ(errors.signed_bias, 0.5);
  EXPECT_DOUBLE_EQ(errors.max_abs, 0.25);
  EXPECT_NEAR(errors.relmse, 0.0625 / (0.25 * 1.01), 1e-12);
  EXPECT_EQ(errors.different_pixels, 64u);
  EXPECT_GT(errors.flip, 0.0);
  EXPECT_EQ(flip(image.data(), reference.data(), 8, 8).size(), 64u);
  image[0] = std::numeric_limits<float>::infinity();
  EXPECT_EQ(compare(image.data(), reference.data(), 8, 8).non_finite, 1u);
  EXPECT_EQ(flip(image.data(), reference.data(), 8, 8)[0], 0.0f);
  EXPECT_THROW(compare(image.data(), reference.data(), 0, 8), UsageError);
  EXPECT_THROW(compare(image.data(), reference.data(), 8, 8, INFINITY), UsageError);
}

}  // namespace
}  // namespace emberline::api
