#include "renderer/core/names.h"
#include "renderer/core/errors.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>

#include "renderer/core/file_suffix.h"

namespace emberline {
namespace {

TEST(Names, EditDistance) {
  EXPECT_EQ(edit_distance("", ""), 0u);
  EXPECT_EQ(edit_distance("", "abc"), 3u);
  EXPECT_EQ(edit_distance("abc", ""), 3u);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
  EXPECT_EQ(edit_distance("bucket", "buckets"), 1u);
  EXPECT_EQ(edit_distance("same", "same"), 0u);
}

TEST(Names, MessageListsAndSuggests) {
  constexpr std::string_view kNames[] = {"path", "direct", "ambient_occlusion"};
  EXPECT_EQ(unknown_name_message("integrator", "pth", kNames),
            "unknown integrator 'pth' (did you mean 'path'?); valid names are path, direct, "
            "ambient_occlusion");
  EXPECT_EQ(unknown_name_message("integrator", "ambient-occlusion", kNames),
            "unknown integrator 'ambient-occlusion' (did you mean 'ambient_occlusion'?); valid "
            "names are path, direct, ambient_occlusion");
  // If no name is similar, the message suggests none.
  EXPECT_EQ(unknown_name_message("integrator", "photon", kNames),
            "unknown integrator 'photon'; valid names are path, direct, ambient_occlusion");
  EXPECT_EQ(unknown_name_message("integrator", "", kNames),
            "unknown integrator ''; valid names are path, direct, ambient_occlusion");
  EXPECT_EQ(unknown_name_message("integrator", std::string(100000, 'x'), kNames).find("did you"),
            std::string::npos);
}

// If there are more than twelve names, the message lists only the nearest three.
TEST(Names, MessageOfManyNamesHasTheNearest) {
  constexpr std::string_view kNames[] = {
      "one", "two", "spp", "fps",  "seed", "min-spp",        "max-spp",
      "sun", "env", "aov", "half", "crop", "noise-threshold"};
  EXPECT_EQ(unknown_name_message("setting", "sppp", kNames),
            "unknown setting 'sppp' (did you mean 'spp', 'min-spp' or 'max-spp'?)");
  EXPECT_EQ(nearest_indices("--threshold", kNames).front(), 12u);
  EXPECT_EQ(nearest_names("spp", std::span(kNames).first(2)), "'one' or 'two'");
  EXPECT_EQ(nearest_names("spp", {}), "");
}

// A message may contain a name of any length. It keeps its beginning, which names the place, and
// its end.
TEST(Names, MessagesCutNamesOfMegabytes) {
  const std::string name(3'000'000, 'n');
  const std::string_view valid[] = {"sobol", "independent"};
  const std::string message = unknown_name_message("sampler", name, valid);
  EXPECT_LT(message.size(), 200u);
  EXPECT_NE(message.find("nnn...'; valid names are sobol"), std::string::npos) << message;
  const InputError error("scene.glb", "the node {} is wrong; rename it", name);
  const std::string what = error.what();
  EXPECT_LT(what.size(), 2100u);
  EXPECT_TRUE(what.starts_with("scene.glb: the node nnn")) << what;
  EXPECT_TRUE(what.ends_with("n is wrong; rename it")) << what;
  const std::string plain(1900, 'p');
  EXPECT_EQ(std::string(UsageError(plain).what()), plain);
}

TEST(FileSuffix, FollowsTheLastDotOfTheFileName) {
  EXPECT_EQ(lower_suffix("shots/A.010.EXR"), ".exr");
  EXPECT_EQ(lower_suffix("a.b/frame"), "");
  EXPECT_EQ(lower_suffix(".exr"), "");
  EXPECT_EQ(lower_suffix("frame."), ".");
  EXPECT_EQ(lower_suffix(""), "");
}

}  // namespace
}  // namespace emberline
