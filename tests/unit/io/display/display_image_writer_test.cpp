// Tests the PNG and JPEG files of DisplayImageWriter and write_image by reading them back.
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <stdexcept>

#include "io/display/display.h"
#include "io/image/output.h"
#include "renderer/core/errors.h"
#include "support/srgb.h"
#include "unit/output_folder.h"

namespace emberline {
namespace {

// Uses the built-in config, whatever the environment is.
class PictureTest : public OutputFolder {
 protected:
  void SetUp() override {
    unsetenv("OCIO");
    OutputFolder::SetUp();
  }
};

struct ReadBack {
  OIIO::ImageSpec spec;
  std::vector<uint8_t> values;
};

ReadBack read_back(const std::string& path) {
  OIIO::ImageSpec as_stored;
  as_stored.attribute("oiio:UnassociatedAlpha", 1);
  const auto input = OIIO::ImageInput::open(path, &as_stored);
  if (!input) throw std::runtime_error("cannot read " + path + ": " + OIIO::geterror());
  ReadBack result{input->spec(), {}};
  result.values.resize(size_t(result.spec.image_pixels()) * size_t(result.spec.nchannels));
  input->read_image(0, 0, 0, -1, OIIO::TypeDesc::UINT8, result.values.data());
  return result;
}

// The premultiplied radiance of pixel (x, y) of the test pictures.
std::array<float, 4> test_pixel(int x, int y) {
  const float alpha = float(y % 5) / 4.0f;
  return {float(x % 11) / 10.0f * alpha, 0.18f * alpha, float(y % 3) / 2.0f * alpha, alpha};
}

void write_picture(const std::string& path, const Rect& crop, bool alpha) {
  DisplayImageWriter writer(path, crop, std::make_shared<DisplayTransform>(DisplaySettings{}),
                            alpha);
  for (int y = crop.y0; y < crop.y1; y += 16) {
    for (int x = crop.x0; x < crop.x1; x += 16) {
      const Rect tile = Rect{x, y, x + 16, y + 16}.intersect(crop);
      std::vector<float> rgba;
      for (int py = tile.y0; py < tile.y1; ++py) {
        for (int px = tile.x0; px < tile.x1; ++px) {
          for (const float value : test_pixel(px, py)) rgba.push_back(value);
        }
      }
      writer.write_tile(tile, rgba);
    }
  }
  writer.finish();
}

TEST_F(PictureTest, PngWithAlphaIsUnassociated) {
  const Rect crop = {5, 9, 47, 38};
  write_picture(path("a.png"), crop, true);
  const ReadBack picture = read_back(path("a.png"));
  ASSERT_EQ(picture.spec.width, crop.width());
  ASSERT_EQ(picture.spec.height, crop.height());
  ASSERT_EQ(picture.spec.nchannels, 4);
  size_t i = 0;
  for (int y = crop.y0; y < crop.y1; ++y) {
    for (int x = crop.x0; x < crop.x1; ++x, ++i) {
      const auto pixel = test_pixel(x, y);
      const double alpha = double(pixel[3]);
      ASSERT_EQ(picture.values[4 * i + 3], std::lround(alpha * 255));
      for (size_t c = 0; c < 3; ++c) {
        const double colour = alpha > 0 ? double(pixel[c]) / alpha : 0.0;
        ASSERT_NEAR(picture.values[4 * i + c], test::srgb(colour) * 255, 0.51) << x << "," << y;
      }
    }
  }
  EXPECT_EQ(contents().size(), 1u);
}

TEST_F(PictureTest, PngWithoutAlphaIsOverBlack) {
  const Rect crop = {0, 0, 33, 20};
  write_picture(path("a.PNG"), crop, false);
  const ReadBack picture = read_back(path("a.PNG"));
  ASSERT_EQ(picture.spec.nchannels, 3);
  size_t i = 0;
  for (int y = crop.y0; y < crop.y1; ++y) {
    for (int x = crop.x0; x < crop.x1; ++x, ++i) {
      for (size_t c = 0; c < 3; ++c) {
        ASSERT_NEAR(picture.values[3 * i + c], test::srgb(double(test_pixel(x, y)[c])) * 255, 0.51);
      }
    }
  }
}

TEST_F(PictureTest, JpegIsCloseAndHasNoAlpha) {
  const Rect crop = {0, 0, 64, 48};
  {
    DisplayImageWriter writer(path("a.jpg"), crop,
                              std::make_shared<DisplayTransform>(DisplaySettings{}), true);
    std::vector<float> rgba;
    for (int i = 0; i < 64 * 48; ++i) rgba.insert(rgba.end(), {0.5f, 0.2f, 0.1f, 0.5f});
    writer.write_tile(crop, rgba);
    writer.finish();
  }
  const ReadBack picture = read_back(path("a.jpg"));
  ASSERT_EQ(picture.spec.nchannels, 3);
  EXPECT_EQ(std::string(picture.spec.get_string_attribute("jpeg:subsampling", "4:4:4")), "4:4:4");
  for (size_t i = 0; i < 64 * 48; ++i) {
    ASSERT_NEAR(picture.values[3 * i + 0], test::srgb(0.5) * 255, 3.0);
    ASSERT_NEAR(picture.values[3 * i + 1], test::srgb(0.2) * 255, 3.0);
    ASSERT_NEAR(picture.values[3 * i + 2], test::srgb(0.1) * 255, 3.0);
  }
}

TEST_F(PictureTest, PicturesAreDeterministicAndUnwrittenPixelsBlack) {
  for (const std::string& suffix : {std::string(".png"), std::string(".jpg")}) {
    write_picture(path("a" + suffix), {0, 0, 40, 40}, true);
    write_picture(path("b" + suffix), {0, 0, 40, 40}, true);
    EXPECT_EQ(read_text(path("a" + suffix)), read_text(path("b" + suffix)));
  }
  DisplayImageWriter writer(path("c.png"), {0, 0, 8, 8},
                            std::make_shared<DisplayTransform>(DisplaySettings{}), true);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  writer.write_tile({0, 0, 1, 1}, {nan, 1.0f, 0.5f, nan});
  writer.finish();
  const ReadBack picture = read_back(path("c.png"));
  EXPECT_EQ(picture.values[0], 0);
  EXPECT_EQ(picture.values[1], 255);
  EXPECT_EQ(picture.values[2], 188);
  EXPECT_EQ(picture.values[3], 0);
  EXPECT_TRUE(std::all_of(picture.values.begin() + 4, picture.values.end(),
                          [](uint8_t value) { return value == 0; }));
}

TEST_F(PictureTest, PictureFilesAppearWholeOrNotAtAll) {
  const auto transform = std::make_shared<DisplayTransform>(DisplaySettings{});
  const Rect crop = {0, 0, 8, 8};
  { DisplayImageWriter writer(path("a.png"), crop, transform, false); }
  EXPECT_TRUE(contents().empty());
  expect_error<UsageError>([&] { DisplayImageWriter(path("a.gif"), crop, transform, false); },
                           ".png, .jpg, .jpeg");
  expect_error<RenderError>([&] { DisplayImageWriter(path("no/a.png"), crop, transform, false); },
                            "does not exist");
  EXPECT_TRUE(contents().empty());
}

TEST_F(PictureTest, GreyPictures) {
  ByteImage image;
  image.width = 4;
  image.height = 1;
  image.channels = 1;
  image.values = {0, 100, 200, 255};
  write_image(path("g.png"), image);
  const ReadBack picture = read_back(path("g.png"));
  EXPECT_EQ(picture.spec.nchannels, 1);
  EXPECT_EQ(picture.values, image.values);
}

}  // namespace
}  // namespace emberline
