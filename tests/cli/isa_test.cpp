// Tests --isa, which selects Embree's kernels. Parts of a frame that were rendered with different
// kernels must not be mixed.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "cli/command_test.h"

namespace emberline::test {
namespace {

// The instruction sets of x86-64. The first has the narrowest vectors.
const Words kIsas = {"sse4.2", "avx2", "avx512"};

class IsaOption : public CommandTest {
 protected:
  void SetUp() override {
    render(frame("", {"-o", path("auto.exr")}));
    widest_ = isa_of("auto.exr");
    const auto at = std::ranges::find(kIsas, widest_);
    if (at == kIsas.end()) GTEST_SKIP() << "not an x86-64";
    supported_ = Words(kIsas.begin(), at + 1);
  }

  Words frame(const std::string& isa, const Words& more) {
    const Words words = {
        "render", EMBERLINE_SCENES "/teapot.glb", "--size", "32x18", "--spp", "4", "--bucket-size",
        "8"};
    return words + (isa.empty() ? Words{} : Words{"--isa", isa}) + more;
  }
  std::string isa_of(const std::string& file) {
    return read_exr(path(file)).attributes.at("emberline:isa");
  }

  Words supported_;
  std::string widest_;
};

TEST_F(IsaOption, AllKernelsGiveTheSamePicture) {
  for (const std::string& isa : supported_) {
    render(frame(isa, {"-o", path("one.exr")}));
    EXPECT_EQ(isa_of("one.exr"), isa);
    const RunResult both = run({"compare", path("one.exr"), path("auto.exr"), "--json"});
    // If a ray hits the shared edge of two triangles, Embree may report either triangle.
    EXPECT_LT(nlohmann::json::parse(both.out)["relmse"].get<double>(), 1e-3) << isa;
    const auto different = nlohmann::json::parse(both.out)["different_pixels"].get<int>();
    EXPECT_TRUE(isa != widest_ || different == 0) << different;
  }
}

TEST_F(IsaOption, CheckpointsOfDifferentKernelsAreNotMixed) {
  if (supported_.size() == 1) GTEST_SKIP() << "this machine has one kind";
  const std::string narrowest = supported_.front();
  render(frame(narrowest, {"-o", path("a.exr"), "--part", "1/2"}));
  render(frame(widest_, {"-o", path("b.exr"), "--part", "2/2"}));
  const std::string a = path("a.exr.part-1-of-2.checkpoint"),
                    b = path("b.exr.part-2-of-2.checkpoint");
  expect_failure({"merge", a, b, "-o", path("all.exr")}, 3,
                 {b, "--isa: " + widest_ + " (now " + narrowest + ")"});
  expect_failure(frame(widest_, {"-o", path("a.exr"), "--part", "1/2", "--resume"}), 3,
                 {a, "--isa: " + narrowest + " (now " + widest_ + ")"});
  render(frame(narrowest, {"-o", path("b.exr"), "--part", "2/2"}));
  run({"merge", a, b, "-o", path("all.exr")});
  render(frame(narrowest, {"-o", path("whole.exr")}));
  EXPECT_EQ(isa_of("all.exr"), narrowest);
  EXPECT_EQ(read_exr(path("all.exr")).channels, read_exr(path("whole.exr")).channels);
}

TEST_F(IsaOption, UnsupportedKernelsAreRefused) {
  if (supported_.size() == kIsas.size()) GTEST_SKIP() << "this machine has all";
  const std::string& next = kIsas[supported_.size()];
  expect_failure(frame(next, {"-o", path("a.exr")}), 2,
                 {"--isa " + next, "supports at most " + widest_});
}

}  // namespace
}  // namespace emberline::test
