// How a measured mean is held against an exact value.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "support/render.h"

namespace emberline::test {

// Passes when |mean - exact| <= 5 standard errors + tolerance * |exact|. Five standard errors fail
// by chance once in 1.7 million assertions (two-sided normal). The tolerance is for what is known
// to be approximate (a table's interpolation, a tessellated sphere) and says so where it is used.
inline void expect_exact(const RenderedImage& image, double exact, double tolerance,
                         const RenderSettings& s, const std::string& what) {
  const double allowed = 5 * image.standard_error + tolerance * std::abs(exact);
  EXPECT_NEAR(image.mean, exact, allowed)
      << what << ": standard error " << image.standard_error << ", off by "
      << (image.mean - exact) / std::max(1e-300, image.standard_error)
      << " standard errors; replay with seed " << s.seed << ", " << s.spp << " spp, " << s.width
      << " x " << s.height << ", sampler " << s.sampler;
  EXPECT_EQ(image.counters.non_finite_samples, 0u) << what;
}

}  // namespace emberline::test
