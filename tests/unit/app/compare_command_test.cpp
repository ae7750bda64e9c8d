// Runs emberline compare on files and checks its output, the files that it writes, and its errors.
#include "renderer/app/commands.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "io/exr/writer.h"
#include "io/image/input.h"
#include "io/image/output.h"
#include "renderer/core/errors.h"
#include "unit/output_folder.h"

namespace emberline {
namespace {

class CompareTest : public OutputFolder {
 protected:
  // Writes a picture of width x height pixels as one tile, with a float for each of the `channels`.
  std::string write_exr(const std::string& name, int width, int height,
                        const std::vector<std::string>& channels,
                        const std::vector<float>& pixels) {
    ExrHeader header;
    header.width = width;
    header.height = height;
    header.data_window = {0, 0, width, height};
    for (const std::string& channel : channels) header.channels.push_back({channel});
    ExrWriter writer(path(name), header);
    writer.write_tile(header.data_window, pixels);
    writer.finish();
    return path(name);
  }
};

std::string stdout_of(const CompareOptions& options) {
  ::testing::internal::CaptureStdout();
  try {
    EXPECT_EQ(run_compare(options), kExitDone);
  } catch (...) {
    ::testing::internal::GetCapturedStdout();
    throw;
  }
  return ::testing::internal::GetCapturedStdout();
}

template <typename E>
std::string error_of(const CompareOptions& options) {
  try {
    stdout_of(options);
  } catch (const E& error) {
    return error.what();
  }
  ADD_FAILURE() << "no error";
  return "";
}

TEST_F(CompareTest, JsonHasEveryMetric) {
  CompareOptions options;
  options.image = write_exr("a.exr", 2, 1, {"B", "G", "R", "Z"}, {2, 1, 0, 9, 2, 1, 0.5f, 9});
  options.reference = write_exr("b.exr", 2, 1, {"R", "G", "B"}, {0, 1, 1, 0, 1, 2});
  options.json = true;
  const auto json = nlohmann::json::parse(stdout_of(options));
  EXPECT_EQ(json.size(), 14u);
  EXPECT_EQ(json["width"], 2);
  EXPECT_EQ(json["height"], 1);
  // The pictures differ by 1 in the blue of the first pixel and by 0.5 in the red of the second.
  EXPECT_DOUBLE_EQ(json["mse"], 1.25 / 6);
  EXPECT_DOUBLE_EQ(json["rmse"], std::sqrt(1.25 / 6));
  EXPECT_DOUBLE_EQ(json["signed_bias"], 1.5 / 5);
  EXPECT_DOUBLE_EQ(json["relmse_epsilon"], 0.01 * 25.0 / 36.0);
  EXPECT_EQ(json["max_abs"], 1);
  EXPECT_EQ(json["different_pixels"], 2);
  EXPECT_EQ(json["non_finite"], 0);
  for (const char* key : {"relmse", "relmse_trimmed", "psnr", "ssim", "flip"}) {
    EXPECT_TRUE(json[key].is_number()) << key;
  }
}

TEST_F(CompareTest, EqualPicturesHaveNullPsnr) {
  CompareOptions options;
  options.image = options.reference = write_exr("a.exr", 1, 1, {"R", "G", "B"}, {0.5f, 1, 2});
  options.json = true;
  const auto json = nlohmann::json::parse(stdout_of(options));
  EXPECT_TRUE(json["psnr"].is_null());
  EXPECT_EQ(json["mse"], 0);
  EXPECT_EQ(json["flip"], 0);
  EXPECT_EQ(json["ssim"], 1);
}

// Pixels are matched by their position in the frame, even if a file holds only part of the frame.
TEST_F(CompareTest, CropsAreComparedWhereTheyLie) {
  const auto write_part = [&](const std::string& name, const Rect& crop, int width, int height) {
    ExrHeader header;
    header.width = width;
    header.height = height;
    header.data_window = crop;
    header.channels = {{"R"}, {"G"}, {"B"}};
    std::vector<float> pixels;
    for (int y = crop.y0; y < crop.y1; ++y) {
      for (int x = crop.x0; x < crop.x1; ++x) {
        pixels.insert(pixels.end(), {float(x), float(y), float(x * y)});
      }
    }
    ExrWriter writer(path(name), header);
    writer.write_tile(crop, pixels);
    writer.finish();
    return path(name);
  };
  const std::string whole = write_part("whole.exr", {0, 0, 9, 7}, 9, 7);
  const std::string crop = write_part("crop.exr", {2, 3, 5, 6}, 9, 7);
  const std::string elsewhere = write_part("elsewhere.exr", {3, 3, 6, 6}, 9, 7);
  const std::string other_frame = write_part("other.exr", {2, 3, 5, 6}, 10, 7);
  CompareOptions options;
  options.json = true;
  options.image = crop;
  options.reference = whole;
  const auto json = nlohmann::json::parse(stdout_of(options));
  EXPECT_EQ(json["width"], 3);
  EXPECT_EQ(json["different_pixels"], 0);
  for (const std::string& reference : {elsewhere, other_frame}) {
    options.reference = reference;
    EXPECT_THROW(run_compare(options), InputError) << reference;
  }
  options.image = whole;
  options.reference = crop;
  EXPECT_THROW(run_compare(options), InputError);
}

TEST_F(CompareTest, TableNamesFilesAndMetrics) {
  CompareOptions options;
  options.image = write_exr("a.exr", 2, 1, {"R", "G", "B"},
                            {1, 1, 1, std::numeric_limits<float>::quiet_NaN(), 0, 0});
  options.reference = write_exr("b.exr", 2, 1, {"R", "G", "B"}, {1, 1, 1, 0, 0, 0});
  const std::string text = stdout_of(options);
  for (const std::string& part : {options.image, options.reference, std::string("2 x 1 pixels"),
                                  std::string("relmse_trimmed"), std::string("excluded")}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << " in\n" << text;
  }
}

TEST_F(CompareTest, DifferencePictures) {
  const int size = 70;  // more than one tile
  std::vector<float> image, reference;
  for (int i = 0; i < size * size; ++i) {
    const bool left = i % size < size / 2;
    image.insert(image.end(), {left ? 0.5f : 1.0f, 0.5f, left ? 0.5f : 0.0f});
    reference.insert(reference.end(), {0.5f, 0.5f, 0.5f});
  }
  image[0] = std::numeric_limits<float>::infinity();
  CompareOptions options;
  const auto write_tiled = [&](const std::string& name, const std::vector<float>& pixels) {
    ExrHeader header;
    header.width = header.height = size;
    header.data_window = {0, 0, size, size};
    header.tile_size = 128;
    header.channels = {{"R"}, {"G"}, {"B"}};
    ExrWriter writer(path(name), header);
    writer.write_tile(header.data_window, pixels);
    writer.finish();
    return path(name);
  };
  options.image = write_tiled("a.exr", image);
  options.reference = write_tiled("b.exr", reference);

  options.difference = path("d.exr");
  stdout_of(options);
  const FloatImage difference = read_float_image(path("d.exr"));
  ASSERT_EQ(difference.width, size);
  ASSERT_EQ(difference.channels(), 4);
  const auto value = [&](int x, int y, const std::string& channel) {
    return difference.values[size_t(y * size + x) * 4 + size_t(difference.find_channel(channel))];
  };
  EXPECT_EQ(value(5, 5, "R"), 0.0f);
  EXPECT_EQ(value(5, 5, "flip"), 0.0f);
  EXPECT_EQ(value(66, 68, "R"), 0.5f);
  EXPECT_EQ(value(66, 68, "B"), -0.5f);
  EXPECT_GT(value(66, 68, "flip"), 0.3f);

  options.difference = path("d.png");
  stdout_of(options);
  const FloatImage picture = read_float_image(path("d.png"));
  ASSERT_EQ(picture.width, size);
  ASSERT_EQ(picture.channels(), 3);
  // The non-finite pixel is pure green. An equal pixel has the map's black, and a different pixel
  // is brighter.
  EXPECT_EQ(picture.values[0], 0.0f);
  EXPECT_EQ(picture.values[1], 1.0f);
  EXPECT_LT(picture.values[3 * (5 * 70 + 5)], 0.01f);
  EXPECT_GT(picture.values[3 * (68 * 70 + 66)], 0.1f);
}

TEST_F(CompareTest, Errors) {
  CompareOptions options;
  options.image = write_exr("a.exr", 2, 1, {"R", "G", "B"}, {1, 1, 1, 0, 0, 0});
  options.reference = write_exr("b.exr", 1, 3, {"R", "G", "B"}, std::vector<float>(9, 1.0f));
  const std::string sizes = error_of<InputError>(options);
  EXPECT_NE(sizes.find("2 x 1"), std::string::npos) << sizes;
  EXPECT_NE(sizes.find("1 x 3"), std::string::npos) << sizes;

  options.reference = write_exr("c.exr", 2, 1, {"R", "Z"}, {1, 1, 1, 0});
  const std::string channels = error_of<InputError>(options);
  EXPECT_NE(channels.find("R, Z"), std::string::npos) << channels;

  options.reference = path("missing.exr");
  EXPECT_NE(error_of<InputError>(options).find("missing.exr"), std::string::npos);

  options.reference = options.image;
  options.difference = path("d.tiff");
  EXPECT_NE(error_of<UsageError>(options).find(".exr, .png"), std::string::npos);
  options.difference = options.image;
  EXPECT_NE(error_of<UsageError>(options).find("one of the pictures compared"), std::string::npos);
  options.difference = path("no/d.png");
  EXPECT_NE(error_of<RenderError>(options).find("does not exist"), std::string::npos);
}

}  // namespace
}  // namespace emberline
