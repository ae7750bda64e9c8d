// Tests summaries of studies with known curves: exact power laws, and noise with a known spread.
#include "renderer/statistics/study_summary.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "renderer/core/hash.h"

namespace emberline {
namespace {

// A method whose squared metrics are scale * samples^-order. The other metrics are the square root
// of this. A sample takes `seconds`.
struct PowerLaw {
  double scale = 1, order = 1, seconds = 1e-3;
};

StudyError error_of(double mse) {
  StudyError error;
  error.mse = error.rel_mse = error.rel_mse_trimmed = error.display_mse = mse;
  error.flip = error.p95_absolute = error.p95_display = std::sqrt(std::max(0.0, mse));
  return error;
}

StudyCheckpoint checkpoint_of(const PowerLaw& law, double budget, double factor = 1) {
  StudyCheckpoint c;
  c.budget = budget;
  c.samples = uint64_t(budget * 100);
  c.mean_samples = budget;
  c.wall_s = law.seconds * budget;
  c.cpu_s = 2 * c.wall_s;
  c.error = error_of(factor * law.scale * std::pow(budget, -law.order));
  return c;
}

StudyResults study_of(const std::vector<PowerLaw>& laws, uint32_t seeds,
                      const std::vector<double>& budgets = {1, 2, 4, 8}) {
  StudyResults r;
  r.settings.budgets = budgets;
  r.settings.seeds = seeds;
  for (size_t m = 0; m < laws.size(); ++m) {
    r.methods.emplace_back().name = std::string(1, char('a' + m));
  }
  r.settings.baseline = "a";
  for (uint32_t seed = 0; seed < seeds; ++seed) {
    for (size_t m = 0; m < laws.size(); ++m) {
      StudyRun& run = r.runs.emplace_back();
      run.method = m;
      run.seed = seed;
      for (const double b : budgets) run.checkpoints.push_back(checkpoint_of(laws[m], b));
    }
  }
  return r;
}

TEST(StudentT, IsTheTables) {
  // The quantiles are those of published tables, to three decimals. Cauchy's quantile is tan(.475
  // pi).
  const std::pair<int, double> table[] = {{1, 12.706}, {2, 4.303},  {3, 3.182},  {4, 2.776},
                                          {9, 2.262},  {10, 2.228}, {30, 2.042}, {1000, 1.962}};
  for (const auto& [degrees, quantile] : table) {
    EXPECT_NEAR(student_t_975(degrees), quantile, 6e-4) << degrees << " degrees of freedom";
  }
}

TEST(StudyMean, HasStudentsInterval) {
  const std::vector<double> values = {1, 2, 3, 4};
  const Estimate e = *mean_estimate(values);
  EXPECT_DOUBLE_EQ(e.value, 2.5);
  EXPECT_EQ(e.runs, 4u);
  // s^2 is 5/3, so s / sqrt(4) = 0.6455, which is multiplied by 3.1824.
  EXPECT_NEAR(*e.high - e.value, 3.18245 * std::sqrt(5.0 / 3.0 / 4.0), 1e-4);
  EXPECT_NEAR(e.value - *e.low, *e.high - e.value, 1e-12);
}

TEST(StudyMean, IsGeometricAndOneValueHasNoInterval) {
  const Estimate e = *geometric_mean_estimate(std::vector<double>{1, 4, 0, -3});
  EXPECT_DOUBLE_EQ(e.value, 2);
  EXPECT_EQ(e.runs, 2u);
  EXPECT_NEAR(*e.low * *e.high, 4, 1e-9);
  const Estimate one = *geometric_mean_estimate(std::vector<double>{3});
  EXPECT_DOUBLE_EQ(one.value, 3);
  EXPECT_FALSE(one.low || one.high);
  EXPECT_FALSE(mean_estimate({}));
  EXPECT_FALSE(geometric_mean_estimate(std::vector<double>{0, -1}));
}

// 95 % of the intervals contain the true value. With 2000 intervals, this is 1900 with a standard
// deviation of 9.7. The tolerance is 5 deviations, with a false-alarm rate of 6e-7.
TEST(StudyMean, IntervalsHoldTheTruthAsOftenAsTheySay) {
  int covered = 0;
  for (uint32_t trial = 0; trial < 2000; ++trial) {
    std::vector<double> values;
    for (uint32_t i = 0; i < 5; ++i) {
      const double u = (hash32(trial * 64 + 2 * i) + 0.5) * 0x1p-32;
      const double v = (hash32(trial * 64 + 2 * i + 1) + 0.5) * 0x1p-32;
      values.push_back(std::exp(0.3 * std::sqrt(-2 * std::log(u)) * std::cos(2 * M_PI * v)));
    }
    const Estimate e = *geometric_mean_estimate(values);
    if (*e.low <= 1 && 1 <= *e.high) ++covered;
  }
  EXPECT_NEAR(covered, 1900, 49);
}

TEST(StudySummary, SlopesAreTheOrders) {
  const StudyResults r = study_of({{1, 1, 1e-3}, {2, 1.5, 1e-3}}, 3);
  for (const StudyAxis axis : {StudyAxis::kSamples, StudyAxis::kWall, StudyAxis::kCpu}) {
    EXPECT_NEAR(error_slope(r, 0, StudyMetric::kMse, axis)->value, -1, 1e-12);
    EXPECT_NEAR(error_slope(r, 1, StudyMetric::kMse, axis)->value, -1.5, 1e-12);
    EXPECT_NEAR(error_slope(r, 1, StudyMetric::kFlip, axis)->value, -0.75, 1e-12);
  }
  EXPECT_FALSE(error_slope(study_of({{}}, 2, {4}), 0, StudyMetric::kMse, StudyAxis::kSamples));
}

TEST(StudySummary, SpeedupOfAKnownFactor) {
  // Method b needs a third of the samples and twice the time per sample. It is 3 times as fast in
  // samples, and 1.5 times in time.
  const StudyResults r = study_of({{3, 1, 1e-3}, {1, 1, 2e-3}}, 4);
  for (size_t budget = 0; budget < 4; ++budget) {
    const Speedup samples =
        *equal_error_speedup(r, 1, StudyMetric::kMse, StudyAxis::kSamples, budget);
    EXPECT_NEAR(samples.ratio.value, 3, 1e-9);
    EXPECT_EQ(samples.ratio.runs, 4u);
    EXPECT_NEAR(*samples.ratio.low, 3, 1e-6);
    EXPECT_NEAR(
        equal_error_speedup(r, 1, StudyMetric::kFlip, StudyAxis::kWall, budget)->ratio.value, 1.5,
        1e-9);
    EXPECT_NEAR(
        equal_position_error_ratio(r, 1, StudyMetric::kMse, StudyAxis::kSamples, budget)->value,
        1 / 3.0, 1e-9);
    EXPECT_NEAR(equal_position_error_ratio(r, 1, StudyMetric::kMse, StudyAxis::kCpu, budget)->value,
                2 / 3.0, 1e-9);
    // To match the method at 1, 2, 4 and 8 samples, the baseline needs 3, 6, 12 and 24. It has at
    // most 8.
    EXPECT_EQ(samples.extrapolated, budget >= 2 ? 4u : 0u);
    EXPECT_NEAR(equal_error_speedup(r, 0, StudyMetric::kMse, StudyAxis::kCpu, budget)->ratio.value,
                1, 1e-9);
    EXPECT_NEAR(overhead(r, 1, budget)->value, 2, 1e-12);
  }
}

TEST(StudySummary, InterpolatesInLogarithms) {
  StudyResults r = study_of({{1, 2, 1e-3}, {1, 1, 1e-3}}, 1, {2, 8});
  // The baseline's error is 1/4 at 2 and 1/64 at 8 samples, so it is 1/8 at 2 sqrt(2). That of b is
  // 1/8 at 8.
  EXPECT_NEAR(equal_error_speedup(r, 1, StudyMetric::kMse, StudyAxis::kSamples, 1)->ratio.value,
              2 * std::sqrt(2) / 8, 1e-12);
}

// The baseline's error falls by 4 from 1 to 2 samples, by 2 from 2 to 4 and by 8 from 4 to 8. Each
// point is interpolated in its own segment.
TEST(StudySummary, ReadsABentCurvePieceByPiece) {
  StudyResults r = study_of({{1, 1, 1e-3}, {1, 1, 1e-3}}, 1);
  const double bent[] = {1, 1.0 / 4, 1.0 / 8, 1.0 / 64};
  for (size_t k = 0; k < 4; ++k) r.runs[0].checkpoints[k].error = error_of(bent[k]);
  const double middle = std::sqrt(2.0);
  for (StudyCheckpoint& c : r.runs[1].checkpoints) c.mean_samples *= middle;  // between the others
  const double between[] = {0.5, std::sqrt(1.0 / 32), std::sqrt(1.0 / 512)};
  for (size_t k = 0; k < 3; ++k) {
    const double error = r.runs[1].checkpoints[k].error.mse;
    EXPECT_NEAR(equal_position_error_ratio(r, 1, StudyMetric::kMse, StudyAxis::kSamples, k)->value,
                error / between[k], 1e-9);
    r.runs[1].checkpoints[k].error = error_of(between[k]);
    EXPECT_NEAR(equal_error_speedup(r, 1, StudyMetric::kMse, StudyAxis::kSamples, k)->ratio.value,
                1, 1e-9);
  }
}

// The two budgets are so close that the same picture counts for both.
TEST(StudySummary, LastCheckpointAtAPositionWins) {
  StudyResults r = study_of({{3, 1, 1e-3}, {1, 1, 1e-3}}, 1);
  r.runs[0].checkpoints[1] = r.runs[0].checkpoints[0];
  r.runs[0].checkpoints[1].budget = 2;
  EXPECT_NEAR(error_slope(r, 0, StudyMetric::kMse, StudyAxis::kSamples)->value, -1, 1e-9);
  EXPECT_NEAR(equal_error_speedup(r, 1, StudyMetric::kMse, StudyAxis::kSamples, 0)->ratio.value, 3,
              1e-9);
  EXPECT_NEAR(equal_position_error_ratio(r, 1, StudyMetric::kMse, StudyAxis::kSamples, 0)->value,
              1 / 3.0, 1e-9);
}

TEST(StudySummary, ABaselineOfOneCheckpointFallsAsIndependentSamplesDo) {
  const StudyResults r = study_of({{4, 1, 1e-3}, {1, 1, 1e-3}}, 2, {8});
  const Speedup s = *equal_error_speedup(r, 1, StudyMetric::kMse, StudyAxis::kSamples, 0);
  EXPECT_NEAR(s.ratio.value, 4, 1e-9);
  EXPECT_EQ(s.extrapolated, 2u);
  EXPECT_NEAR(equal_error_speedup(r, 1, StudyMetric::kFlip, StudyAxis::kSamples, 0)->ratio.value, 4,
              1e-9);
}

TEST(StudySummary, ABaselineThatDoesNotFallSaysNothing) {
  const StudyResults r = study_of({{1, 0, 1e-3}, {1, 1, 1e-3}}, 2);
  EXPECT_FALSE(equal_error_speedup(r, 1, StudyMetric::kMse, StudyAxis::kSamples, 3));
}

// Both methods share a factor per seed. So the paired interval is a point, while the interval of
// the method's own error is wide.
TEST(StudySummary, PairsBySeed) {
  StudyResults r = study_of({{2, 1, 1e-3}, {1, 1, 1e-3}}, 4);
  for (StudyRun& run : r.runs) {
    for (StudyCheckpoint& c : run.checkpoints) {
      c.error = error_of(c.error.mse * std::pow(2.0, double(run.seed)));
    }
  }
  const Estimate ratio =
      *equal_position_error_ratio(r, 1, StudyMetric::kMse, StudyAxis::kSamples, 2);
  EXPECT_NEAR(ratio.value, 0.5, 1e-9);
  EXPECT_NEAR(*ratio.high / *ratio.low, 1, 1e-6);
  const std::vector<CurvePoint> curve = study_curve(r, 1, StudyMetric::kMse);
  EXPECT_NEAR(curve[0].error.value, std::pow(2.0, 1.5), 1e-9);
  EXPECT_GT(*curve[0].error.high / *curve[0].error.low, 10);
}

TEST(StudySummary, FailedAndMissingRunsAreLeftOutAndCounted) {
  StudyResults r = study_of({{3, 1, 1e-3}, {1, 1, 1e-3}}, 3);
  r.runs[1].status = StudyRunStatus::kFailed;
  r.runs[1].reason = "it would not";
  r.runs[1].checkpoints.clear();
  r.runs.pop_back();  // the last run of b
  EXPECT_EQ(failures(r, 1).runs, 1u);
  EXPECT_EQ(failures(r, 1).reason, "it would not");
  EXPECT_EQ(failures(r, 0).runs, 0u);
  EXPECT_EQ(find_run(r, 1, 0), nullptr);
  const Speedup s = *equal_error_speedup(r, 1, StudyMetric::kMse, StudyAxis::kCpu, 0);
  EXPECT_EQ(s.ratio.runs, 1u);
  EXPECT_FALSE(s.ratio.low);
  r.settings.baseline = "z";
  EXPECT_FALSE(baseline_method(r));
  EXPECT_FALSE(equal_error_speedup(r, 1, StudyMetric::kMse, StudyAxis::kCpu, 0));
}

TEST(StudySummary, EmptyStudyHasNoResults) {
  const StudyResults r = study_of({{}}, 0);
  EXPECT_TRUE(study_curve(r, 0, StudyMetric::kMse).empty());
  EXPECT_FALSE(error_slope(r, 0, StudyMetric::kMse, StudyAxis::kCpu));
  EXPECT_FALSE(signed_bias(r, 0, 0));
  EXPECT_TRUE(calibration(r, 0).empty());
}

TEST(StudySummary, BiasIsAnArithmeticMeanWithItsSign) {
  StudyResults r = study_of({{}}, 2);
  for (StudyRun& run : r.runs) {
    for (StudyCheckpoint& c : run.checkpoints) c.error.signed_bias = run.seed == 0 ? -0.03 : 0.01;
  }
  EXPECT_NEAR(signed_bias(r, 0, 1)->value, -0.01, 1e-12);
}

TEST(StudySummary, CalibrationByPowersOfTwo) {
  StudyResults r = study_of({{}}, 2);
  r.runs[0].calibration = {{15, 0.2, 0.1}, {32, 0.1, 0.1}};
  r.runs[1].calibration = {{17, 0.05, 0.1}, {33, 0.1, NAN}};
  const std::vector<CalibrationGroup> groups = calibration(r, 0);
  ASSERT_EQ(groups.size(), 2u);
  EXPECT_NEAR(groups[0].mean_samples, std::sqrt(15.0 * 17.0), 1e-9);
  EXPECT_NEAR(groups[0].ratio.value, 1, 1e-9);
  EXPECT_EQ(groups[0].ratio.runs, 2u);
  EXPECT_EQ(groups[1].ratio.runs, 1u);
  EXPECT_DOUBLE_EQ(groups[1].mean_samples, 32) << "of the points that have a ratio";
}

TEST(StudySummary, FractionOfTheNeymanLimit) {
  StudyResults r = study_of({{3, 1, 1e-3}, {1, 1, 2e-3}}, 2);
  EXPECT_FALSE(neyman_fraction(r, 1, StudyMetric::kMse, 1));
  r.limits = NeymanLimits{2, 3, 1.5};
  EXPECT_NEAR(neyman_fraction(r, 1, StudyMetric::kMse, 1)->value, 0.75, 1e-9);
  EXPECT_NEAR(neyman_fraction(r, 1, StudyMetric::kRelMse, 1)->value, 0.5, 1e-9);
  EXPECT_NEAR(neyman_fraction(r, 1, StudyMetric::kDisplay, 1)->value, 1, 1e-9);
  EXPECT_FALSE(neyman_fraction(r, 1, StudyMetric::kFlip, 1));
}

}  // namespace
}  // namespace emberline
