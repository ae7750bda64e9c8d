// Cases E11 and E12 test the error itself. Pixels and seeds are independent, and the variance falls
// with the sample count as theory predicts.
#include "receiver.h"

namespace emberline {
namespace {

using namespace test;

// Returns a receiver under a lamp. All pixels of the receiver have the same expected value.
std::unique_ptr<Scene> lit_floor() {
  SceneBuilderForTests b;
  add_receiver(b, {});
  b.add_quad({-.5f, 1.2f, -.3f}, {.9f, 1.2f, -.3f}, {.9f, 1.2f, .7f}, {-.5f, 1.2f, .7f},
             b.add_material(emitter(Rgb(1.0f))));
  b.set_environment(Rgb(.1f));
  return b.build();
}

RenderSettings noise_settings(const std::string& sampler, uint32_t spp) {
  RenderSettings s = direct_light_settings(spp);
  s.width = s.height = 64;
  s.sampler = sampler;
  return s;
}

// Returns the correlation between the errors of the pixels (x, y) in `a` and (x + dx, y + dy) in
// `b`. The coordinates wrap around.
double correlation(const RenderedImage& a, const RenderedImage& b, int dx, int dy) {
  double sum = 0, squares_a = 0, squares_b = 0;
  const int n = a.crop.width();
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const double p = double(a.rgb(x, y).y) - a.mean;
      const double q = double(b.rgb((x + dx) % n, (y + dy) % n).y) - b.mean;
      sum += p * q;
      squares_a += p * p;
      squares_b += q * q;
    }
  return sum / std::sqrt(squares_a * squares_b);
}

// The correlation of n independent pairs is 0 with a standard error of 1 / sqrt(n).
TEST(Noise, PixelsAndSeedsAreIndependent) {
  const auto scene = lit_floor();
  for (const std::string sampler : {"sobol", "independent"}) {
    RenderSettings s = noise_settings(sampler, 16);
    const RenderedImage one = render(*scene, view_of({}), s);
    s.seed = 2;
    const RenderedImage two = render(*scene, view_of({}), s);
    for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}, {1, 1}, {2, 0}, {0, 8}, {16, 16}})
      expect_case({"E11", sampler + ", pixels " + std::to_string(dx) + ", " + std::to_string(dy) +
                              " apart"},
                  {0, correlation(one, one, dx, dy), 1.0 / 64, 0}, replay(s));
    expect_case({"E11", sampler + ", seeds 1 and 2"}, {0, correlation(one, two, 0, 0), 1.0 / 64, 0},
                replay(s));
  }
}

// Estimates p in variance ~ N^-p, as the slope of log variance over log N. The variance at each N
// comes from the spread of 4096 pixels. A variance over n pixels has itself a relative variance of
// (2 + excess kurtosis) / n. The code uses 3 for 2 + excess kurtosis, since sums of 16 and more
// samples are nearly normal.
struct Slope {
  double value = 0, standard_error = 0;
};
Slope order(const Scene& scene, const CameraDescription& view, const std::string& sampler) {
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  int n = 0;
  double pixels = 0;
  for (uint32_t spp = 16; spp <= 256; spp *= 2) {
    const RenderSettings s = noise_settings(sampler, spp);
    const RenderedImage image = render(scene, view, s);
    pixels = double(image.crop.area());
    const double x = std::log(double(spp)), y = std::log(square(image.standard_error) * pixels);
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
    ++n;
  }
  const double spread = sxx - sx * sx / n;
  return {-(sxy - sx * sy / n) / spread, std::sqrt(3 / pixels / spread)};
}

TEST(Noise, IndependentSamplesGainTheirNumber) {
  const Slope p = order(*lit_floor(), view_of({}), "independent");
  expect_case({"E12", "order of convergence, independent samples, area light and sky"},
              {1, p.value, p.standard_error, 0}, "seed 1, 64 x 64, 16 to 256 spp");
}

// At a tilted edge, the variance of an Owen-scrambled net falls as N^-1.5, since only the sqrt(N)
// of N strata that the edge crosses contribute errors. The test renders one pixel with many seeds,
// so that all estimates are of the same edge. The tolerance is .1, since the order holds only as N
// goes to infinity.
TEST(Noise, StratifiedSamplesGainMoreAtAnEdge) {
  SceneBuilderForTests b;
  const float far = 100;
  b.add_quad({-far, 1, -far}, {.137f * far, 1, -far}, {-.211f * far, 1, far}, {-far, 1, far},
             b.add_material(emitter(Rgb(1.0f))));
  b.set_environment(Rgb(0.0f));
  const auto scene = b.build();
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  int n = 0;
  constexpr int kSeeds = 1000;
  for (uint32_t spp = 16; spp <= 512; spp *= 2) {
    RenderSettings s = direct_light_settings(spp);
    s.width = s.height = 1;
    s.max_depth = 0;
    s.threads = 1;
    double sum = 0, squares = 0;
    for (s.seed = 1; s.seed <= kSeeds; ++s.seed) {
      const double v = render(*scene, orthographic({-3.7, 0, 0}, {-3.7, 1, 0}, 10), s).mean;
      sum += v;
      squares += v * v;
    }
    EXPECT_GT(sum, 0);
    EXPECT_LT(sum, kSeeds);
    const double variance = squares / kSeeds - square(sum / kSeeds);
    const double x = std::log(double(spp)), y = std::log(variance);
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
    ++n;
  }
  const double spread = sxx - sx * sx / n;
  expect_case({"E12", "order of convergence, sobol, a tilted edge in a pixel"},
              {1.5, -(sxy - sx * sy / n) / spread, std::sqrt(3.0 / kSeeds / spread), .1},
              "seeds 1 to 1000, 1 x 1, 16 to 512 spp");
}

}  // namespace
}  // namespace emberline
