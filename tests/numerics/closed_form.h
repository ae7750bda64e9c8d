// Compares a measured mean with an exact value, and writes the comparison as a row of the table in
// tests/numerics/table.csv.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>

#include "support/long_tests.h"
#include "support/render.h"

namespace emberline::test {

// Names one comparison. `number` is that of its case ("6", or "E3" for a case that the catalogue of
// hard cases lacks). `what` distinguishes the comparisons of a case.
struct CaseName {
  std::string number, what;
};

// `tolerance` is absolute and covers known approximations (a table's interpolation, a tessellated
// sphere). Derive it where it is used, never from a measurement.
struct Comparison {
  double exact = 0, measured = 0, standard_error = 0, tolerance = 0;

  double deviation() const { return measured - exact; }
  // A bound of five standard errors fails by chance once in 1.7 million comparisons (two-sided
  // normal).
  double allowed() const { return 5 * standard_error + tolerance; }
  bool passes() const { return std::abs(deviation()) <= allowed(); }  // false for a NaN
};

// Appends the comparison as one line of JSON to the file that the environment variable
// EMBERLINE_NUMERICS_TABLE names, if it is set. ci/numerics.sh makes the table from that file.
// `reason` says why a known failure remains.
void record(const CaseName& name, const Comparison& c, const std::string& reason = {});

inline std::string describe(const CaseName& name, const Comparison& c, const std::string& replay) {
  char text[256];
  std::snprintf(text, sizeof text,
                ": measured %.9g, exact %.9g, standard error %.3g: off by %.3g, %.3g standard "
                "errors; allowed %.3g; replay: ",
                c.measured, c.exact, c.standard_error, c.deviation(),
                c.deviation() / std::max(1e-300, c.standard_error), c.allowed());
  return "case " + name.number + ", " + name.what + text + replay;
}

inline void expect_case(const CaseName& name, const Comparison& c, const std::string& replay) {
  record(name, c);
  EXPECT_TRUE(c.passes()) << describe(name, c, replay);
}

// Expects a known failure, which the table lists as a failure with its `reason`. Its deviation must
// not exceed `bound` (absolute). Use expect_case instead once the failure is fixed.
inline void expect_known_failure(const CaseName& name, const Comparison& c, double bound,
                                 const std::string& reason, const std::string& replay) {
  record(name, c, reason);
  EXPECT_FALSE(c.passes()) << "mended: use expect_case. " << describe(name, c, replay);
  EXPECT_LE(std::abs(c.deviation()), bound) << describe(name, c, replay);
}

inline std::string replay(const RenderSettings& s) {
  return "seed " + std::to_string(s.seed) + ", " + std::to_string(s.spp) + " spp, " +
         std::to_string(s.width) + " x " + std::to_string(s.height) + ", sampler " + s.sampler;
}

// Formats a number as the table does, for example 0.1 or 1e-06.
inline std::string format_value(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

// Compares a picture whose pixels all have the expected value `exact`. `tolerance` is absolute.
// With 64 pixels, a bound of five standard errors fails by chance once in 200,000 comparisons
// (Student's t with 63 degrees of freedom).
inline Comparison compared(const RenderedImage& image, double exact, double tolerance) {
  EXPECT_EQ(image.counters.non_finite_samples, 0u);
  return {exact, image.mean, image.standard_error, tolerance};
}

// The mean of a picture whose pixels have different expected values, and the standard error of that
// mean. The two streams of a pixel are independent, even where the samples within a stream are
// correlated (film.h). So half the difference between the streams estimates the pixel's error.
// mean_of reads only the green channel and is for grey scenes.
struct MeasuredMean {
  double mean = 0, standard_error = 0;
};
inline MeasuredMean mean_of(const Scene& scene, const CameraDescription& view, RenderSettings s) {
  s.streams = StreamCount::kTwo;
  s.aovs = "variance";
  const RenderedImage image = render(scene, view, s);
  EXPECT_EQ(image.counters.non_finite_samples, 0u);
  double sum = 0, variance = 0;
  const double n = double(image.crop.area());
  for (size_t i = 0; i < image.values.size(); i += image.channels.size()) {
    sum += double(image.values[i + 1]);
    variance += double(image.values[i + 6]);  // channels: R G B A samples variance.R variance.G
  }
  return {sum / n, std::sqrt(variance) / n};
}

// Gives each comparison its own seed (FNV-1a). With shared random numbers the rows' errors would be
// correlated, and the spread over the table would not check the standard errors.
inline uint32_t seed_of(const CaseName& name) {
  uint32_t h = 2166136261u;
  for (const char c : name.number + " " + name.what) h = (h ^ uint8_t(c)) * 16777619u;
  return h;
}

// Compares like compared(), and expects agreement. `tolerance` is relative to `exact`.
inline void expect_exact(const RenderedImage& image, double exact, double tolerance,
                         const RenderSettings& s, const CaseName& name) {
  expect_case(name, {exact, image.mean, image.standard_error, tolerance * std::abs(exact)},
              replay(s));
  EXPECT_EQ(image.counters.non_finite_samples, 0u) << name.number << " " << name.what;
}

// For tests whose exact values hold whether or not paths are guided to indirect light.
class ByGuiding : public testing::TestWithParam<Guiding> {
 public:
  static RenderSettings with_guiding(RenderSettings s) {
    s.guiding = GetParam();
    return s;
  }
  // Expects that paths are guided if they are meant to be.
  static void expect_guide(const Scene& scene, const CameraDescription& view,
                           const RenderSettings& s) {
    const Camera camera(view, s.width, s.height, scene.origin(), scene.scale());
    EXPECT_EQ(plan_of(s).frame(scene, camera).indirect.guide != nullptr, s.guiding == Guiding::kOn);
  }
  static CaseName name(const std::string& number, const std::string& what) {
    return {number, GetParam() == Guiding::kOn ? what + ", guided" : what};
  }
};
inline const auto kWithAndWithoutGuiding = testing::Values(Guiding::kOff, Guiding::kOn);
inline std::string guiding_name(const testing::TestParamInfo<Guiding>& info) {
  return info.param == Guiding::kOn ? "Guided" : "Plain";
}

}  // namespace emberline::test
