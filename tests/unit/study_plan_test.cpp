// From the options of a study to its methods.
#include "renderer/app/study_plan.h"

#include <gtest/gtest.h>

#include <set>

#include "renderer/app/fingerprint.h"
#include "renderer/core/errors.h"

namespace emberline {
namespace {

std::vector<std::string> names(const StudyPlan& plan) {
  std::vector<std::string> list;
  for (const PlannedMethod& m : plan.methods) list.push_back(m.method.name);
  return list;
}

TEST(StudyPlan, EveryCombinationOnceWithAShortNameAndAnIdOfItsOwn) {
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
    EXPECT_EQ(m.impossible.empty(),
              m.method.driver != "adaptive" || m.method.sampler != "blue_noise")
        << m.impossible;
  }
  options.separate = true;
  for (const PlannedMethod& m : plan_study(options).methods) EXPECT_TRUE(m.separate);
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

TEST(StudyPlan, TheReferenceHasASamplerThatIsNotStudied) {
  StudyOptions options;
  EXPECT_EQ(plan_study(options).reference_sampler, "independent");
  options.samplers = "independent,stratified";
  EXPECT_EQ(plan_study(options).reference_sampler, "sobol");
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
