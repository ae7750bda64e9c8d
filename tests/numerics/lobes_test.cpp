// Case 28: every lobe is reciprocal, the integral of its pdf and the share of rejected samples add
// up to 1, and sample weights are bounded.
#include "closed_form.h"
#include "renderer/core/moments.h"
#include "renderer/shading/bsdf.h"
#include "renderer/shading/gauss_legendre.h"
#include "support/chi_square.h"
#include "support/single_queries.h"

namespace emberline {
namespace {

using namespace test;

struct Lobe {
  const char* name;
  BsdfParameters parameters;
};

std::vector<Lobe> lobes() {
  std::vector<Lobe> list;
  const auto add = [&](const char* name, auto change) {
    BsdfParameters p;
    p.base_color = Rgb(.9f, .5f, .2f);
    change(p);
    list.push_back({name, p});
  };
  add("Lambert", [](BsdfParameters& p) { p.specular = 0; });
  add("rough dielectric", [](BsdfParameters& p) { p.roughness = .8f; });
  add("glossy dielectric", [](BsdfParameters& p) { p.roughness = .2f; });
  add("dense dielectric", [](BsdfParameters& p) { p.roughness = .5f, p.ior = 2.4f; });
  add("rough metal", [](BsdfParameters& p) { p.roughness = 1, p.metallic = 1; });
  add("glossy metal", [](BsdfParameters& p) { p.roughness = .1f, p.metallic = 1; });
  add("half metal", [](BsdfParameters& p) { p.roughness = .4f, p.metallic = .5f; });
  add("thin rough glass", [](BsdfParameters& p) { p.roughness = .5f, p.transmission = 1; });
  add("rough glass",
      [](BsdfParameters& p) { p.roughness = .5f, p.transmission = 1, p.thin_walled = false; });
  add("rough glass from inside", [](BsdfParameters& p) {
    p.roughness = .5f, p.transmission = 1, p.thin_walled = false, p.inside = true;
  });
  add("half clear", [](BsdfParameters& p) { p.roughness = .6f, p.transmission = .5f; });
  return list;
}

Vec3f direction(double mu, double phi) {
  const double r = std::sqrt((1 - mu) * (1 + mu));
  return {float(r * std::cos(phi)), float(r * std::sin(phi)), float(mu)};
}

// f(o, i) = f(i, o) on the side of reflection. The tolerance of 1e-4 covers albedo tables and half
// vectors in float.
TEST(Lobes, AreReciprocal) {
  for (const Lobe& lobe : lobes()) {
    double worst = 0;
    for (uint64_t i = 0; i < 20'000; ++i) {
      TestRandom random(28, i);
      const Vec3f a = direction(.02 + .98 * random.next_double(), 6.28 * random.next_double());
      const Vec3f b = direction(.02 + .98 * random.next_double(), 6.28 * random.next_double());
      const Rgb there = SurfaceBsdf(lobe.parameters, a).eval(b) / b.z;
      const Rgb back = SurfaceBsdf(lobe.parameters, b).eval(a) / a.z;
      for (int c = 0; c < 3; ++c) {
        const double sum = double(there[c]) + double(back[c]);
        if (sum > 0) worst = std::max(worst, std::abs(double(there[c]) - double(back[c])) / sum);
      }
    }
    const CaseName name{"28", std::string("largest asymmetry, ") + lobe.name};
    const std::string replay = "TestRandom(28, pair)";
    if (lobe.parameters.transmission > 0) {
      // The asymmetry is at most |E(o) - E(i)| / (E(o) + E(i)), where E is the
      // albedo that scales the lobe, and far below 1.
      expect_known_failure(name, {0, worst, 0, 1e-4}, .3,
                           "transmission is scaled by its albedo at wo alone (Turquin 2019): white "
                           "in a furnace, at the price of reciprocity",
                           replay);
    } else {
      expect_case(name, {0, worst, 0, 1e-4}, replay);
    }
  }
}

// Integrates the pdf over one hemisphere, by Gauss-Legendre in angles that sinh stretches around
// `peak`. phi runs once around, starting opposite to `peak`. A lobe of roughness alpha is about 2
// alpha wide in theta and 2 alpha cos(theta) wide across, since tilting the half vector sideways
// turns wi by the cosine only. The nodes resolve a quarter of these widths.
template <int N>
double integral(const SurfaceBsdf& bsdf, const Vec3f& peak, double alpha, double side) {
  static const GaussLegendre<N> rule;
  const double mu = std::abs(double(peak.z));
  const double theta0 = std::acos(std::min(1.0, mu));
  const double phi0 = std::atan2(double(peak.y), double(peak.x));
  // The refracted lobe is broad at this roughness.
  const double width = side < 0 ? .3 : .5 * alpha;
  const double width_phi = side < 0 ? .3 : .5 * alpha * mu / std::max(std::sin(theta0), alpha);
  const double s0 = std::asinh(-theta0 / width), s1 = std::asinh((kPiD / 2 - theta0) / width);
  const double p1 = std::asinh(kPiD / width_phi);
  double sum = 0;
  for (size_t i = 0; i < N; ++i) {
    const double s = s0 + (s1 - s0) * rule.x[i], theta = theta0 + width * std::sinh(s);
    const double dtheta = (s1 - s0) * rule.w[i] * width * std::cosh(s) * std::sin(theta);
    for (size_t j = 0; j < N; ++j) {
      const double p = p1 * (2 * rule.x[j] - 1), phi = phi0 + width_phi * std::sinh(p);
      const double dphi = 2 * p1 * rule.w[j] * width_phi * std::cosh(p);
      Vec3f wi = direction(std::cos(theta), phi);
      wi.z *= float(side);
      sum += double(test::pdf_of(bsdf, wi)) * dtheta * dphi;
    }
  }
  return sum;
}

// The tolerance of 1e-3 is the catalogue's. The share of rejected samples is counted over 2^18
// points. Even random points would give it to better than 1 / (2 x 2^9), and its standard error is
// added. A weight (value over pdf) is at most the albedo of a white surface divided by the least
// probability of selecting a lobe, .02.
TEST(Lobes, DensityIntegratesToOne) {
  for (const Lobe& lobe : lobes()) {
    for (const double mu : {.95, .5, .1}) {
      const Vec3f wo = direction(mu, .7);
      const SurfaceBsdf bsdf(lobe.parameters, wo);
      const double alpha = square(double(lobe.parameters.roughness));
      // Estimates the quadrature error from a run with fewer nodes. Refraction has an edge where
      // microfacets turn away, which a smooth rule resolves badly.
      double rule_error = 0;
      const auto over = [&](const Vec3f& peak, double side) {
        const double fine = integral<256>(bsdf, peak, alpha, side);
        rule_error += std::abs(fine - integral<160>(bsdf, peak, alpha, side));
        return fine;
      };
      double total = over(Vec3f(-wo.x, -wo.y, wo.z), 1);
      if (lobe.parameters.transmission > 0) {
        // The peak on the other side is that of refraction, or lies straight ahead.
        Vec3f peak(-wo.x, -wo.y, -wo.z);
        if (!lobe.parameters.thin_walled) {
          const double eta = lobe.parameters.inside ? 1 / 1.5 : 1.5;
          const double sine = std::min(1.0, std::sqrt(1 - mu * mu) / eta);
          peak = -direction(std::sqrt(1 - sine * sine), .7);
        }
        total += over(peak, -1);
      }
      EXPECT_LT(rule_error, 3e-3) << "the quadrature tells nothing: " << lobe.name << " " << mu;
      Moments refused;
      double heaviest = 0;
      for (uint64_t i = 0; i < 1u << 18; ++i) {
        TestRandom random(29, i);
        const float u_lobe = random.next();
        const BsdfSample sample = bsdf.sample(u_lobe, random.vec2());
        refused.add(sample.valid ? 0 : 1);
        if (sample.valid) {
          heaviest = std::max(heaviest, double(max_component(sample.weight) * sample.eta_scale));
        }
      }
      const std::string what = std::string(lobe.name) + " at cosine " + std::to_string(mu);
      expect_case({"28", "integral of the density with what is refused, " + what},
                  {1, total + refused.mean(), refused.standard_error(), 1e-3 + rule_error},
                  "TestRandom(29, draw)");
      expect_case({"28", "heaviest sample, below 50, " + what}, {0, heaviest, 0, 50},
                  "TestRandom(29, draw)");
    }
  }
}

}  // namespace
}  // namespace emberline
