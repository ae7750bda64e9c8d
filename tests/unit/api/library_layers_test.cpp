// Tests light groups, mattes, working spaces and denoising in the library.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "renderer/api/emberline.h"

namespace emberline::api {
namespace {

class LibraryLayers : public ::testing::Test {
 protected:
  void SetUp() override {
    set_log([](Message, std::string_view) {});
  }
  void TearDown() override { set_log({}); }

  static std::string scene_file(const std::string& name) {
    return std::string(EMBERLINE_SCENES "/") + name;
  }
  static Settings small() {
    return Settings().set("size", "24x16").set("spp", "8").set("max-depth", "4");
  }
  static size_t place(const Picture& picture, const std::string& channel) {
    const auto found = std::ranges::find(picture.channels, channel);
    EXPECT_NE(found, picture.channels.end()) << channel;
    return size_t(found - picture.channels.begin());
  }
  static double mean(const Picture& picture, const std::string& channel) {
    const size_t c = place(picture, channel);
    double sum = 0;
    for (size_t i = c; i < picture.values.size(); i += picture.channels.size()) {
      sum += double(picture.values[i]);
    }
    return sum / (picture.width * picture.height);
  }
};

TEST_F(LibraryLayers, LightGroupsAddUpAndFollowEdits) {
  const Settings settings = small().set("light-groups", "yes");
  Scene scene(scene_file("teapot.glb"), small());
  const Picture all = render(scene, settings);
  double sum = 0;
  int groups = 0;
  for (const std::string& channel : all.channels) {
    if (!channel.starts_with("light.") || !channel.ends_with(".G")) continue;
    sum += mean(all, channel);
    ++groups;
  }
  EXPECT_EQ(groups, 3);
  EXPECT_NEAR(sum, mean(all, "G"), 1e-5);
  EXPECT_GT(mean(all, "light.window.G"), 0);
  scene.edit(
      R"({"emberline_edits": 1, "lights": [{"kind": "material", "name": "window", "on": false}]})");
  const Picture dark = render(scene, settings);
  EXPECT_EQ(std::ranges::count(dark.channels, "light.window.G"), 0);
  EXPECT_GT(mean(dark, "light.rim.G"), 0);
  EXPECT_THROW(render(scene, Settings(settings).set("integrator", "normal")), UsageError);
}

TEST_F(LibraryLayers, MattesMatchTheNames) {
  const Settings settings = small().set("cryptomatte", "object,material");
  const Scene scene(scene_file("cornell_box.glb"), settings);
  const std::vector<MatteNames> names = matte_names(scene, settings);
  ASSERT_EQ(names.size(), 2u);
  EXPECT_EQ(names[0].layer, "CryptoObject");
  EXPECT_EQ(names[1].layer, "CryptoMaterial");
  EXPECT_EQ(names[0].ids.size(), 9u) << "eight objects and the environment";
  const Picture picture = render(scene, settings);
  const size_t id = place(picture, "CryptoObject00.R"), share = place(picture, "CryptoObject00.G");
  for (int x = 8; x < 16; ++x) {  // in the box
    const float* const pixel = picture.pixel(x, 8);
    const auto found = std::ranges::find(names[0].ids, std::bit_cast<uint32_t>(pixel[id]),
                                         &std::pair<std::string, uint32_t>::second);
    EXPECT_NE(found, names[0].ids.end()) << x;
    EXPECT_GT(pixel[share], 0.0f);
    EXPECT_LE(pixel[share], 1.0f);
  }
  EXPECT_EQ(picture.channels.back(), "dropped.CryptoMaterial");
  const Scene nameless(scene_file("cornell_box.glb"), small());
  EXPECT_THROW(render(nameless, settings), UsageError);
  EXPECT_THROW(matte_names(nameless, settings), UsageError);
}

TEST_F(LibraryLayers, WorkingSpacesAreOfTheSceneAndTheFile) {
  const Settings settings = small().set("working-space", "acescg");
  const Scene scene(scene_file("cornell_box.glb"), settings);
  const RenderedPicture wide = render(RenderFiles::none(), scene, settings);
  EXPECT_EQ(wide.values, render(scene, settings).values);
  const Scene plain(scene_file("cornell_box.glb"), small());
  const Picture narrow = render(plain, small());
  EXPECT_THROW(render(plain, settings), UsageError);
  EXPECT_GT(std::abs(mean(wide, "R") - mean(narrow, "R")), 0.01 * mean(narrow, "R"));
  const std::string file = ::testing::TempDir() + "library_wide.exr";
  write_picture(file, wide);
  const Picture back = read_picture(file);
  EXPECT_NEAR(mean(back, "R"), mean(narrow, "R"), 0.01 * mean(narrow, "R"));
  EXPECT_EQ(wide.rec709(), RenderedPicture(back).rec709()) << "as compare() takes it";
  EXPECT_NE(wide.rec709(), RenderedPicture(static_cast<const Picture&>(wide)).rec709())
      << "which does not know its working space";
  EXPECT_THROW(RenderedPicture().rec709(), UsageError);
  std::filesystem::remove(file);
}

TEST_F(LibraryLayers, TheDenoisedPictureIsAnotherLayer) {
  const Settings settings = small().set("spp", "32").set("denoise", "yes");
  const Scene scene(scene_file("cornell_box.glb"), settings);
  const Picture picture = render(scene, settings);
  EXPECT_NE(mean(picture, "denoised.G"), mean(picture, "G"));
  EXPECT_NEAR(mean(picture, "denoised.G"), mean(picture, "G"), 0.1 * mean(picture, "G"));
  EXPECT_GT(mean(picture, "denoised.error"), 0);
  EXPECT_LT(mean(picture, "denoised.error"), 0.2);
  EXPECT_EQ(std::ranges::count(picture.channels, "half1.shared.0.R"), 0) << "they are summed";
  std::stop_source give_up;
  give_up.request_stop();
  EXPECT_THROW(render(scene, settings, {}, {}, {}, give_up.get_token()), Stopped);
}

TEST_F(LibraryLayers, FilesAreTheCommands) {
  const Settings settings = small().set("half", "RGBA").set("exr-parts", "layers").set("aov", "N");
  const Scene scene(scene_file("cornell_box.glb"), settings);
  RenderedPicture picture = render(RenderFiles::none(), scene, settings);
  const std::string file = ::testing::TempDir() + "library_half.exr";
  write_picture(file, picture);
  const Picture back = read_picture(file);
  EXPECT_NE(mean(back, "R"), mean(picture, "R"));
  EXPECT_NEAR(mean(back, "R"), mean(picture, "R"), 1e-3);
  EXPECT_EQ(mean(back, "N.X"), mean(picture, "N.X"));
  picture.x = 1;
  EXPECT_THROW(write_picture(file, picture), UsageError) << "not what was rendered";
  std::filesystem::remove(file);
}

// A file shows the scene as it was rendered, even if the scene changes before the file is written.
TEST_F(LibraryLayers, FilesAreOfTheSceneThatWasRendered) {
  const Settings settings = small().set("time", "0.25").set("spp", "1");
  Scene scene = Scene::animated(scene_file("moving_blade.glb"), settings);
  const RenderedPicture picture = render(RenderFiles::none(), scene, settings);
  const std::string file = ::testing::TempDir() + "library_posed.exr";
  const auto bytes = [&](const RenderedPicture& of) {
    write_picture(file, of);
    std::ifstream stream(file, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(stream), {});
  };
  const std::string before = bytes(picture);
  scene.pose(Settings(settings).set("time", "0.5"));
  EXPECT_EQ(bytes(picture), before);
  EXPECT_NE(bytes(render(RenderFiles::none(), scene, Settings(settings).set("time", "0.5"))),
            before);
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace emberline::api
