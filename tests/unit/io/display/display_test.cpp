// Compares the display transform with closed forms, and tests configs named by $OCIO.
#include "io/display/display.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>

#include "renderer/core/errors.h"
#include "support/srgb.h"
#include "unit/output_folder.h"

namespace emberline {
namespace {

// Unsets $OCIO before and after each test.
class DisplayTest : public OutputFolder {
 protected:
  void SetUp() override {
    unsetenv("OCIO");
    OutputFolder::SetUp();
  }
  void TearDown() override {
    unsetenv("OCIO");
    OutputFolder::TearDown();
  }
  void use_config(const std::string& text) {
    std::ofstream(path("config.ocio")) << text;
    setenv("OCIO", path("config.ocio").c_str(), 1);
  }
};

DisplaySettings with_view(const std::string& view, float exposure = 0.0f) {
  DisplaySettings settings;
  settings.view = view;
  settings.exposure = exposure;
  return settings;
}

std::array<float, 3> shown(const DisplaySettings& settings, float r, float g, float b) {
  std::array<float, 3> rgb = {r, g, b};
  DisplayTransform(settings).apply(rgb.data(), 1);
  return rgb;
}

TEST_F(DisplayTest, SrgbIsTheStandardCurve) {
  std::vector<float> values;
  for (int i = 0; i <= 3000; ++i) values.push_back(float(i) / 2500.0f - 0.1f);
  while (values.size() % 3) values.push_back(0);
  std::vector<float> result = values;
  DisplayTransform({}).apply(result.data(), result.size() / 3);
  for (size_t i = 0; i < values.size(); ++i) {
    // OpenColorIO derives the slope of the linear part from gamma and offset (12.9232).
    ASSERT_NEAR(result[i], test::srgb(double(values[i])), 2e-5) << values[i];
  }
  EXPECT_EQ(std::lround(shown({}, 0.18f, 0.18f, 0.18f)[1] * 255), 118);  // 117.6 before rounding
  EXPECT_NEAR(shown({}, 1.0f, 1.0f, 1.0f)[0], 1.0f, 1e-6);
  EXPECT_EQ(shown({}, 0.0f, 0.0f, 0.0f)[2], 0.0f);
}

TEST_F(DisplayTest, ExposureIsInStops) {
  const auto shifted = shown(with_view("sRGB", 1.5f), 0.1f, 0.02f, 0.3f);
  const double scale = std::pow(2.0, 1.5);
  EXPECT_NEAR(shifted[0], test::srgb(0.1 * scale), 2e-5);
  EXPECT_NEAR(shifted[1], test::srgb(0.02 * scale), 2e-5);
  EXPECT_NEAR(shifted[2], test::srgb(0.3 * scale), 2e-5);
  EXPECT_NEAR(shown(with_view("raw", -2.0f), 8.0f, 4.0f, 2.0f)[0], 2.0f, 1e-6);
}

TEST_F(DisplayTest, RawIsTheIdentity) {
  const auto raw = shown(with_view("Raw"), -0.5f, 0.18f, 12.0f);
  EXPECT_EQ(raw, (std::array{-0.5f, 0.18f, 12.0f}));
}

TEST_F(DisplayTest, AcesShowsMiddleGreyAtATenthOfPeak) {
  // ACES 1.0: the rendering transform maps 0.18 to 4.8 of 48 cd/m2. The video output scales 0.02 to
  // 48 cd/m2 onto 0 to 1, and compensates for the dim surround with an exponent of 0.9811.
  const auto grey = shown(with_view("ACES"), 0.18f, 0.18f, 0.18f);
  EXPECT_NEAR(grey[0], test::srgb(std::pow((4.8 - 0.02) / (48.0 - 0.02), 0.9811)), 1e-3);
  // Neutral colours stay neutral, because D65 is adapted to the ACES white and back.
  EXPECT_NEAR(grey[0], grey[1], 2e-3);
  EXPECT_NEAR(grey[2], grey[1], 2e-3);
  // Highlights roll off: 1.0 is not yet white, but 16.3 (the end of the curve) is.
  EXPECT_LT(shown(with_view("ACES"), 1.0f, 1.0f, 1.0f)[1], 0.95f);
  EXPECT_GT(shown(with_view("ACES"), 1.0f, 1.0f, 1.0f)[1], 0.70f);
  EXPECT_NEAR(shown(with_view("ACES"), 20.0f, 20.0f, 20.0f)[1], 1.0f, 5e-3);
}

TEST_F(DisplayTest, GreysAreMonotone) {
  for (const char* view : {"sRGB", "ACES"}) {
    std::vector<float> greys;
    for (int i = 0; i < 4000; ++i)
      greys.insert(greys.end(), 3, std::exp2(float(i) / 200.0f - 12.0f));
    DisplayTransform(with_view(view)).apply(greys.data(), greys.size() / 3);
    for (size_t i = 3; i < greys.size(); ++i) {
      ASSERT_GE(greys[i], greys[i - 3] - 1e-6f) << view << " at " << i / 3;
    }
  }
}

TEST_F(DisplayTest, AnythingInGivesSomethingFiniteOut) {
  const float inf = std::numeric_limits<float>::infinity();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float largest = std::numeric_limits<float>::max();
  for (const char* view : {"sRGB", "ACES", "Raw"}) {
    for (const float exposure : {0.0f, 200.0f, -200.0f}) {
      std::vector<float> rgb = {nan, inf, -inf, largest, -largest, 0.0f, nan,  nan,  nan,
                                inf, inf, inf,  1e-40f,  1e30f,    0.5f, 0.0f, 1.0f, -1.0f};
      DisplayTransform(with_view(view, exposure)).apply(rgb.data(), rgb.size() / 3);
      for (const float value : rgb) EXPECT_TRUE(std::isfinite(value)) << view;
    }
  }
  const auto pixel = shown({}, inf, nan, -inf);
  EXPECT_NEAR(pixel[0], 1.0f, 1e-6);
  EXPECT_EQ(pixel[1], 0.0f);
  EXPECT_EQ(pixel[2], 0.0f);
}

TEST_F(DisplayTest, UnknownNamesListTheValidOnes) {
  expect_error<UsageError>(
      [] { DisplayTransform(with_view("Filmic")); },
      "unknown view \"Filmic\" in display \"sRGB\"; valid names are: sRGB, ACES, Raw");
  DisplaySettings settings;
  settings.display = "Rec.2020";
  expect_error<UsageError>(
      [&] { DisplayTransform{settings}; },
      "unknown display \"Rec.2020\" in the built-in OpenColorIO config; valid names are: sRGB");
  settings = {};
  settings.look = "warm";
  expect_error<UsageError>([&] { DisplayTransform{settings}; }, "unknown look \"warm\"");
  settings = {};
  settings.exposure = std::numeric_limits<float>::infinity();
  expect_error<UsageError>([&] { DisplayTransform{settings}; }, "exposure");
}

TEST_F(DisplayTest, DescribesItself) {
  EXPECT_EQ(DisplayTransform({}).describe(), "built-in: sRGB / sRGB");
  EXPECT_EQ(DisplayTransform(with_view("aces")).describe(), "built-in: sRGB / ACES");
}

// In this config the reference space is linear Rec. 709 under a usual name, while scene_linear is
// another space, which is twice as bright. The source must be the reference space. The view halves
// blue, and the look zeroes red.
constexpr const char* kNamedConfig = R"(ocio_profile_version: 2
roles:
  scene_linear: other
  default: other
displays:
  Monitor:
    - !<View> {name: Half, colorspace: half_blue}
    - !<View> {name: Plain, colorspace: lin_rec709}
active_displays: []
active_views: []
looks:
  - !<Look>
    name: no_red
    process_space: lin_rec709
    transform: !<MatrixTransform> {matrix: [0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}
colorspaces:
  - !<ColorSpace>
    name: lin_rec709
  - !<ColorSpace>
    name: other
    to_scene_reference: !<MatrixTransform> {matrix: [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1]}
  - !<ColorSpace>
    name: half_blue
    from_scene_reference: !<MatrixTransform> {matrix: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 1]}
)";

TEST_F(DisplayTest, OcioVariableWins) {
  use_config(kNamedConfig);
  EXPECT_EQ(shown({}, 0.25f, 0.5f, 1.0f), (std::array{0.25f, 0.5f, 0.5f}));
  EXPECT_EQ(shown(with_view("plain"), 0.25f, 0.5f, 1.0f), (std::array{0.25f, 0.5f, 1.0f}));
  DisplaySettings settings;
  settings.look = "NO_RED";
  EXPECT_EQ(shown(settings, 0.25f, 0.5f, 1.0f), (std::array{0.0f, 0.5f, 0.5f}));
  EXPECT_EQ(DisplayTransform(settings).describe(),
            path("config.ocio") + ": Monitor / Half / look no_red (from lin_rec709)");
  expect_error<UsageError>([] { DisplayTransform(with_view("sRGB")); },
                           "valid names are: Half, Plain");
  setenv("OCIO", "", 1);
  EXPECT_EQ(DisplayTransform({}).describe(), "built-in: sRGB / sRGB");
}

TEST_F(DisplayTest, OcioConfigWithoutRec709GoesThroughAces) {
  use_config(R"(ocio_profile_version: 2
roles: {scene_linear: ap0, aces_interchange: ap0, default: ap0}
displays:
  Monitor:
    - !<View> {name: Plain, colorspace: ap0}
    - !<View> {name: Data, colorspace: data}
colorspaces:
  - !<ColorSpace>
    name: ap0
  - !<ColorSpace>
    name: data
    isdata: true
)");
  // The expected value is Rec. 709 green in ACES2065-1, adapted from D65 by Bradford's matrix. It
  // is the second column of the published matrix, 0.38298 0.81342 0.11154.
  const auto green = shown({}, 0.0f, 1.0f, 0.0f);
  EXPECT_NEAR(green[0], 0.38298f, 1e-4f);
  EXPECT_NEAR(green[1], 0.81342f, 1e-4f);
  EXPECT_NEAR(green[2], 0.11154f, 1e-4f);
  EXPECT_EQ(shown(with_view("Data"), 0.0f, 1.0f, 0.0f), (std::array{0.0f, 1.0f, 0.0f}));
}

TEST_F(DisplayTest, UnusableOcioConfigs) {
  setenv("OCIO", path("missing.ocio").c_str(), 1);
  expect_error<InputError>([] { DisplayTransform({}); }, "missing.ocio");
  use_config("this is : not [ a config");
  expect_error<InputError>([] { DisplayTransform({}); }, "config.ocio: ");
  use_config(R"(ocio_profile_version: 2
roles: {default: odd}
displays:
  Monitor:
    - !<View> {name: Plain, colorspace: odd}
colorspaces:
  - !<ColorSpace>
    name: odd
)");
  expect_error<InputError>([] { DisplayTransform({}); }, "scene_linear");
}

// OpenColorIO would wait for the pipe, and would read the device until memory is full.
TEST_F(DisplayTest, OcioConfigsAreRegularFilesOfSomeSize) {
  ASSERT_EQ(mkfifo(path("pipe.ocio").c_str(), 0600), 0);
  std::ofstream(path("huge.ocio")) << "ocio_profile_version: 2\n";
  std::filesystem::resize_file(path("huge.ocio"), uintmax_t(1) << 40);  // sparse
  for (const std::string& name :
       {path("pipe.ocio"), path("huge.ocio"), path("."), std::string("/dev/zero")}) {
    setenv("OCIO", name.c_str(), 1);
    expect_error<InputError>([] { DisplayTransform({}); }, name);
  }
}

// OpenColorIO 2.1 does not terminate on any of these.
TEST_F(DisplayTest, CyclicOcioConfigsAreRefused) {
  const auto with = [&](const std::string& transform) {
    use_config(R"(ocio_profile_version: 2
search_path: "."
roles: {default: raw, scene_linear: lin}
file_rules: [!<Rule> {name: Default, colorspace: default}]
displays: {sRGB: [!<View> {name: V, colorspace: out}]}
looks: [!<Look> {name: l, process_space: lin, transform: !<LookTransform> {src: lin, dst: lin, looks: +m}},
        !<Look> {name: m, process_space: lin, transform: !<CDLTransform> {slope: [1, 2, 1]}}]
colorspaces:
  - !<ColorSpace> {name: lin}
  - !<ColorSpace> {name: raw, isdata: true}
  - !<ColorSpace> {name: other, from_reference: !<ColorSpaceTransform> {src: lin, dst: out}}
  - !<ColorSpace>
    name: out
    from_reference: )" +
               transform + "\n");
  };
  ASSERT_EQ(mkfifo(path("pipe.cube").c_str(), 0600), 0);
  std::ofstream(path("huge.cube")) << "LUT_3D_SIZE 2\n";
  std::filesystem::resize_file(path("huge.cube"), uintmax_t(1) << 40);
  const std::string xml = R"(<ProcessList id="a" version="1.7">)";
  std::ofstream(path("a.ctf")) << xml << "<Reference path=\"/dev/zero\"/></ProcessList>";
  std::ofstream(path("b.cube")) << "\n  <!DOCTYPE ProcessList [<!ENTITY r \"&#60;Reference/>\">]>"
                                << xml << "&r;</ProcessList>";
  std::string doubled =
      "!<GroupTransform> {children: [&a0 !<MatrixTransform> {offset: [1, 0, 0, 0]}";
  for (int i = 1; i < 30; ++i) {
    const std::string last = "*a" + std::to_string(i - 1);
    doubled +=
        ", &a" + std::to_string(i) + " !<GroupTransform> {children: [" + last + "," + last + "]}";
  }
  const std::vector<std::pair<std::string, std::string>> wrong = {
      {"!<ColorSpaceTransform> {src: out, dst: lin}", "\"out\" refers back to itself"},
      {"!<ColorSpaceTransform> {src: lin, dst: other}", "refers back to itself"},
      {"!<DisplayViewTransform> {src: lin, display: sRGB, view: V}", "refers back to itself"},
      {"!<FileTransform> {src: pipe.cube}", "not a regular file"},
      {"!<FileTransform> {src: /dev/zero}", "not a regular file"},
      {"!<FileTransform> {src: huge.cube}", "too large"},
      {"!<FileTransform> {src: a.ctf}", "\"<Reference\" is not supported"},
      {"!<FileTransform> {src: b.cube}", "\"<!DOCTYPE\" is not supported"},
      {doubled + "]}", "YAML aliases"},
  };
  for (const auto& [transform, says] : wrong) {
    with(transform);
    expect_error<InputError>([] { DisplayTransform({}); }, says);
    expect_error<InputError>([] { display_names(); }, says);
    EXPECT_TRUE(ocio_table_files().empty());
  }
  with(
      "!<GroupTransform> {children: [!<LookTransform> {src: lin, dst: lin, looks: +l}, "
      "!<ColorSpaceTransform> {src: lin, dst: raw}, !<FileTransform> {src: my.cube}]}");
  std::ofstream(path("my.cube")) << "LUT_1D_SIZE 2\n0 0 0\n1 1 1\n";
  EXPECT_NO_THROW(DisplayTransform({}));
  EXPECT_EQ(ocio_table_files(), std::vector<std::string>{path("my.cube")});
}

// A word between stars is not an alias. An alias needs an anchor with its name.
TEST_F(DisplayTest, StarredWordsAreNotAliases) {
  std::string comments, bullets, commented;
  for (int i = 0; i < 40; ++i) {
    comments += "# the *linear* space, *not* the [*display*] one, {*see* the R&D &notes\n";
    bullets += "      *bold*, *look* and '*it*'\n";
    commented += "# - *shared is not used here\n";
  }
  const auto config = [](const std::string& description, const std::string& transform) {
    return "ocio_profile_version: 2\nroles: {default: raw, scene_linear: lin}\n"
           "file_rules: [!<Rule> {name: Default, colorspace: default}]\n"
           "displays: {sRGB: [!<View> {name: V, colorspace: out}]}\n"
           "colorspaces:\n  - !<ColorSpace> {name: lin}\n  - !<ColorSpace> {name: raw, isdata: "
           "true}\n"
           "  - !<ColorSpace>\n    name: out\n    description: |\n" +
           description + "    from_reference: !<GroupTransform> {children: [" + transform + "]}\n";
  };
  const std::string anchored = "&shared !<MatrixTransform> {offset: [1, 0, 0, 0]}, *shared";
  use_config(comments + config(bullets, anchored) + commented + comments);
  EXPECT_NO_THROW(DisplayTransform({}));

  // Real aliases are found after comments, quotes and text that seem to hide them.
  std::string seventeen = "&a !<MatrixTransform> {offset: [1, 0, 0, 0]}";
  for (int i = 0; i < 17; ++i) seventeen += ", *a";
  const std::string tagged = "!<MatrixTransform>&a {offset: [1, 0, 0, 0]}" + seventeen.substr(44);
  std::string hidden = "!<FileTransform> {src: \"# x\n  # \"}, " + seventeen;
  for (const std::string& transform : {seventeen, tagged, hidden}) {
    use_config(config("      text\n", transform));
    expect_error<InputError>([] { DisplayTransform({}); }, "16 YAML aliases");
  }
  // To a parser, two names with different invalid bytes are the same name.
  std::string damaged = "&\xff !<MatrixTransform> {offset: [1, 0, 0, 0]}";
  for (int i = 0; i < 17; ++i) damaged += ", *\xfe";
  use_config(config("      text\n", damaged));
  expect_error<InputError>([] { DisplayTransform({}); }, "16 YAML aliases");
  // The same config in UTF-16.
  std::string wide;
  for (const char c : config("      text\n", seventeen)) wide += std::string{c, '\0'};
  use_config("\xff\xfe" + wide);
  expect_error<InputError>([] { DisplayTransform({}); }, "not UTF-8 text");
}

TEST_F(DisplayTest, NamesOfTheBuiltInConfigStartWithTheDefaults) {
  const DisplayNames names = display_names();
  ASSERT_EQ(names.displays.size(), 1u);
  EXPECT_EQ(names.displays[0].name, "sRGB");
  EXPECT_EQ(names.displays[0].views, (std::vector<std::string>{"sRGB", "ACES", "Raw"}));
  EXPECT_TRUE(names.looks.empty());
}

TEST_F(DisplayTest, EveryNameThatIsListedCanBeUsed) {
  for (const DisplayNames::Display& display : display_names().displays) {
    for (const std::string& view : display.views) {
      DisplaySettings settings;
      settings.display = display.name;
      settings.view = view;
      EXPECT_NO_THROW(DisplayTransform{settings}) << display.name << " / " << view;
    }
  }
}

TEST_F(DisplayTest, MissingConfigIsAnInputError) {
  setenv("OCIO", path("missing.ocio").c_str(), 1);
  EXPECT_THROW(display_names(), InputError);
}

}  // namespace
}  // namespace emberline
