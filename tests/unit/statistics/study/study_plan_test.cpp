// Tests how the options of a study are converted to its methods.
#include "renderer/statistics/study/plan.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>

#include "io/files/fingerprint.h"
#include "renderer/core/errors.h"
#include "renderer/engine/process_usage.h"
#include "renderer/engine/render_clock.h"
#include "renderer/engine/render_plan.h"
#include "unit/output_folder.h"

namespace emberline {
namespace {

std::vector<std::string> names(const StudyPlan& plan) {
  std::vector<std::string> list;
  for (const PlannedMethod& m : plan.methods) list.push_back(m.method.name);
  return list;
}

TEST(StudyPlan, CountsAndPartsAreCheckedForEveryClient) {
  for (const uint32_t seeds : {0u, kMaxStudySeeds + 1}) {
    StudyOptions options;
    options.seeds = seeds;
    EXPECT_THROW(plan_study(options), UsageError) << seeds;
  }
  StudyOptions options;
  options.reference_spp = 1;
  EXPECT_THROW(plan_study(options), UsageError) << "it is rendered in two halves";
  options.reference_spp = 2;
  EXPECT_NO_THROW(plan_study(options));
  options.frame.light_groups = true;
  EXPECT_THROW(plan_study(options), UsageError);
  options.frame.light_groups = false;
  options.frame.seed = 7;
  EXPECT_NO_THROW(plan_study(options));
  options.reference = "a.exr";
  options.cache = "folder";
  EXPECT_THROW(plan_study(options), UsageError) << "nothing is kept of a given reference";
  options.reference = options.cache = "";
  options.frame.part = FramePart{1, 2};
  EXPECT_THROW(plan_study(options), UsageError);
}

TEST(StudyPlan, EveryCombinationOnceWithAShortNameAndAUniqueId) {
  StudyOptions options;
  options.estimators = "two-stream,two-stream/mse/unbiased,kajiya";
  StudyPlan plan = plan_study(options);
  EXPECT_EQ(names(plan),
            (std::vector<std::string>{"bucket", "bisection", "adaptive/two-stream",
                                      "adaptive/two-stream/mse/unbiased", "adaptive/kajiya"}));
  EXPECT_EQ(plan.baseline, "bucket");
  EXPECT_EQ(plan.budgets, (std::vector<double>{1, 2, 4, 8, 16, 32, 64}));
  EXPECT_EQ(plan.methods[2].method.allocation, "display");
  EXPECT_EQ(plan.methods[3].method.allocation, "mse");
  EXPECT_TRUE(plan.methods[3].method.unbiased);
  EXPECT_EQ(plan.methods[4].method.allocation, "") << "an estimator that shares evenly";
  options.samplers = "sobol,stratified";
  options.baseline = "bisection/sobol";
  plan = plan_study(options);
  ASSERT_EQ(plan.methods.size(), 10u);
  EXPECT_EQ(names(plan)[6], "bisection/stratified");
  std::set<std::string> ids, different;
  for (const PlannedMethod& m : plan.methods) {
    ids.insert(m.id);
    different.insert(m.method.name);
  }
  EXPECT_EQ(ids.size(), 10u);
  EXPECT_EQ(different.size(), 10u);
}

TEST(StudyPlan, FramesThatCannotBeLookedAtOnTheirWayAreSeparate) {
  StudyOptions options;
  options.samplers = "sobol,blue_noise";
  for (const PlannedMethod& m : plan_study(options).methods) {
    EXPECT_EQ(m.separate, m.method.driver == "bucket" || m.method.sampler == "blue_noise")
        << m.method.name;
    EXPECT_EQ(m.unsupported_reason.empty(),
              m.method.driver != "adaptive" || m.method.sampler != "blue_noise")
        << m.unsupported_reason;
  }
  options.separate = true;
  for (const PlannedMethod& m : plan_study(options).methods) EXPECT_TRUE(m.separate);
}

TEST(StudyPlan, PlannedFramesAreMethods) {
  StudyOptions options;
  options.drivers = "adaptive";
  options.estimators =
      "nested,nested/planned,nested/mse/planned,two-stream/unbiased,kajiya/planned";
  const StudyPlan plan = plan_study(options);
  std::set<std::string> ids;
  for (const PlannedMethod& m : plan.methods) {
    SCOPED_TRACE(m.method.name);
    EXPECT_EQ(m.method.planned, m.method.name.ends_with("/planned"));
    EXPECT_EQ(m.separate, m.method.planned) << "their buckets are finished one by one";
    EXPECT_EQ(m.unsupported_reason.empty(), m.method.estimator != "kajiya");
    ids.insert(m.id);
  }
  EXPECT_EQ(ids.size(), 5u);
  EXPECT_FALSE(plan.methods[1].method.unbiased);
  EXPECT_EQ(plan.methods[2].method.allocation, "mse");
  options.estimators = "nested/unbiased/planned";
  EXPECT_THROW(plan_study(options), UsageError);
}

// A separate frame with a budget in seconds plans its own samples, if its sampler can do so.
TEST(StudyPlan, SeparateFramesKeepDeadlines) {
  StudyOptions options;
  options.drivers = "bucket,adaptive";
  options.samplers = "sobol,blue_noise";
  for (const bool separate : {false, true}) {
    options.separate = separate;
    options.seconds.reset();
    for (const PlannedMethod& m : plan_study(options).methods) EXPECT_FALSE(m.has_time_budget);
    options.seconds = "2,4";
    for (const PlannedMethod& m : plan_study(options).methods) {
      EXPECT_EQ(m.has_time_budget,
                m.method.sampler == "sobol" && (separate || m.method.driver == "bucket"))
          << m.method.name;
      const RenderOptions frame = deadline_options(m, 4, 9);
      EXPECT_EQ(frame.time_budget_s, 4);
      EXPECT_EQ(frame.seed, 9u);
      EXPECT_FALSE(frame.spp);
    }
  }
}

// A plan needs the number of samples in advance.
TEST(StudyPlan, PlannedFramesHaveNoTimeBudget) {
  StudyOptions options;
  options.drivers = "adaptive";
  options.estimators = "nested/planned";
  options.seconds = "2,4";
  const PlannedMethod method = plan_study(options).methods.at(0);
  EXPECT_FALSE(method.has_time_budget);
  EXPECT_EQ(method.unsupported_reason, "");
}

// Each method appears again with denoising.
TEST(StudyPlan, DenoisedMethodsFollowTheRawOnes) {
  StudyOptions options;
  options.drivers = "bucket,adaptive";
  options.estimators = "nested,nested/mse";
  options.denoise = true;
  StudyPlan plan = plan_study(options);
  EXPECT_EQ(names(plan), (std::vector<std::string>{"bucket", "bucket+denoise", "adaptive/nested",
                                                   "adaptive/nested+denoise", "adaptive/nested/mse",
                                                   "adaptive/nested/mse+denoise"}));
  EXPECT_EQ(plan.baseline, "bucket");
  std::set<std::string> ids;
  for (const PlannedMethod& m : plan.methods) {
    EXPECT_TRUE(m.separate) << m.id;
    const std::string& name = m.method.name;
    EXPECT_EQ(m.method.denoised, name.ends_with("+denoise")) << m.id;
    EXPECT_EQ(aovs_of(m.options).contains(Aov::kDenoising), m.method.denoised) << m.id;
    EXPECT_EQ(m.unsupported_reason, "") << m.id;
    ids.insert(m.id);
  }
  EXPECT_EQ(ids.size(), 6u);
}

TEST(StudyPlan, SamplersThatTakePowersOfTwoGetThem) {
  StudyOptions options;
  options.samplers = "blue_noise";
  options.drivers = "bucket";
  options.seconds = "1";
  const StudyPlan plan = plan_study(options);
  EXPECT_EQ(frame_options(plan.methods[0], 100, 7).spp, 64u);
  EXPECT_EQ(frame_options(plan.methods[0], 100, 7).seed, 7u);
  options.seconds.reset();
  options.spp = "4,6";
  EXPECT_THROW(plan_study(options), UsageError) << "the only method is impossible at 6 samples";
}

TEST(StudyPlan, ReferenceUsesASamplerThatIsNotStudied) {
  StudyOptions options;
  EXPECT_EQ(plan_study(options).reference_sampler, "independent");
  options.samplers = "independent,stratified";
  EXPECT_EQ(plan_study(options).reference_sampler, "sobol");
}

// Each method must be equally often at each position. With 6000 orders of 3 methods, this is 2000
// times with a standard deviation of 37. The tolerance is 5 deviations. For 9 cells, the
// false-alarm rate is 5e-6.
TEST(StudyPlan, OrdersArePermutationsWithoutFavourites) {
  int count[3][3] = {};
  for (uint32_t seed = 0; seed < 6000; ++seed) {
    const std::vector<size_t> order = study_order(3, seed);
    ASSERT_EQ(std::set<size_t>(order.begin(), order.end()), (std::set<size_t>{0, 1, 2}));
    for (size_t place = 0; place < 3; ++place) ++count[place][order[place]];
  }
  for (const auto& place : count) {
    for (const int n : place) EXPECT_NEAR(n, 2000, 183) << "seeds 0 to 5999";
  }
  EXPECT_TRUE(study_order(0, 1).empty());
}

TEST(RenderClock, ExcludesTheTimeOfObservers) {
  const Stopwatch whole;
  RenderClock clock;
  clock.exclude_time([] {
    const double until = process_cpu_seconds() + 0.1;
    while (process_cpu_seconds() < until) {
    }
  });
  EXPECT_GT(whole.seconds(), 0.09);
  EXPECT_LT(clock.seconds(), whole.seconds() - 0.09);
  EXPECT_LT(clock.cpu_seconds(), 0.05);
}

using SceneFingerprint = OutputFolder;
TEST_F(SceneFingerprint, IsOfAllItsFiles) {
  const auto write = [&](const std::string& name, const std::string& text) {
    std::ofstream(path(name)) << text;
  };
  const std::string scene = path("s.gltf");
  write("s.gltf", R"({"asset": {"version": "2.0"}, "buffers": [{"uri": "a%20b.bin",
                      "byteLength": 4}], "images": [{"uri": "i.png"}]})");
  write("a b.bin", "1234");
  write("i.png", "image");
  std::set<uint64_t> seen = {scene_fingerprint(scene)};
  EXPECT_EQ(scene_fingerprint(scene), *seen.begin());
  write("a b.bin", "1235");
  seen.insert(scene_fingerprint(scene));
  write("i.png", "other");
  seen.insert(scene_fingerprint(scene));
  std::filesystem::remove(path("i.png"));
  seen.insert(scene_fingerprint(scene));
  EXPECT_EQ(seen.size(), 4u);
  EXPECT_THROW(scene_fingerprint(path("none.gltf")), InputError);
}

TEST(Fingerprint, ChangesWithEveryByteAndTheLength) {
  const std::string text(100, 'a');
  std::set<uint64_t> seen = {fingerprint(text), fingerprint(text, 1),
                             fingerprint(text + std::string(1, '\0'))};
  for (size_t i = 0; i < text.size(); ++i) {
    std::string changed = text;
    changed[i] = 'b';
    seen.insert(fingerprint(changed));
  }
  EXPECT_EQ(seen.size(), 103u);
  EXPECT_EQ(hexadecimal(0xabcu), "0000000000000abc");
}

}  // namespace
}  // namespace emberline
