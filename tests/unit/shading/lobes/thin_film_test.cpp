// Compares the thin film with two sums over wavelengths: one of the same model, one of the exact
// model.
#include "renderer/shading/lobes/thin_film.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "renderer/shading/lobes/colour_matching.h"
#include "support/chi_square.h"

namespace emberline {
namespace {

using test::TestRandom;

// The reflectance of two interfaces of amplitudes a and b with all interreflections (Airy 1833).
// Light from the second interface is delayed by `phase`.
double airy(double a, double b, double phase) {
  const std::complex<double> late = std::polar(b, phase);
  return std::norm((a + late) / (1.0 + a * late));
}

struct Amplitudes {
  double s, p, cosine;  // cosine beyond the interface
};
Amplitudes fresnel(double n1, double cos1, double n2) {
  const double cos2 = std::sqrt(std::max(0.0, 1 - square(n1 / n2) * (1 - cos1 * cos1)));
  return {(n1 * cos1 - n2 * cos2) / (n1 * cos1 + n2 * cos2),
          (n2 * cos1 - n1 * cos2) / (n2 * cos1 + n1 * cos2), cos2};
}

double schlick(double f0, double cosine) { return f0 + (1 - f0) * std::pow(1 - cosine, 5); }

struct Film {
  double cosine, ior, thickness;
  double path() const {
    return 2 * ior * thickness * std::sqrt(1 - (1 - cosine * cosine) / (ior * ior));
  }
};

// The model of thin_film.h at one phase.
double model(const Film& film, double f0, double phase) {
  const Amplitudes top = fresnel(1, film.cosine, film.ior);
  const double a = std::sqrt(0.5 * (square(top.s) + square(top.p)));
  const double whole = std::sqrt(schlick(f0, film.cosine));
  const double b = (whole - a) / (1 - whole * a);
  const double root = std::sqrt(f0), base = (1 + root) / (1 - root + 1e-9);
  const double metal = schlick(square((base - film.ior) / (base + film.ior)), top.cosine);
  const double t = std::min(1.0, film.path() / 137.5);
  const double share = std::clamp((f0 - .1) / .3, 0.0, 1.0) * t * t * (3 - 2 * t);
  return airy(a, std::copysign(std::sqrt(b * b + (metal - b * b) * share), b), phase);
}

// The exact reflectance with both polarisations, for a base of complex index.
using Index = std::complex<double>;
double truth(const Film& film, const Index& base, double phase) {
  const Amplitudes top = fresnel(1, film.cosine, film.ior);
  const Index cos3 = std::sqrt(1.0 - (1 - square(film.cosine)) / (base * base));
  const Index s = (film.ior * top.cosine - base * cos3) / (film.ior * top.cosine + base * cos3);
  const Index p = (base * top.cosine - film.ior * cos3) / (base * top.cosine + film.ior * cos3);
  const auto sum = [phase](double a, Index b) {
    b *= std::polar(1.0, phase);
    return std::norm((a + b) / (1.0 + a * b));
  };
  return 0.5 * (sum(top.s, s) + sum(top.p, p));
}

// The extension's model has two interfaces, which both follow Schlick.
double extension(const Film& film, double f0, double phase) {
  const double r = std::sqrt(f0), base = (1 + r) / (1 - r);
  const double bottom = (base - film.ior) / (base + film.ior);
  const double cos2 = std::sqrt(1 - (1 - square(film.cosine)) / square(film.ior));
  return airy(std::sqrt(schlick(square((film.ior - 1) / (film.ior + 1)), film.cosine)),
              std::copysign(std::sqrt(schlick(square(bottom), cos2)), bottom), phase);
}

template <typename Reflectance>
Vec3d over_wavelengths(const Reflectance& reflectance, const Film& film, const Vec3d& f0) {
  Vec3d sum(0.0), white(0.0);
  for (double nanometres = 360.5; nanometres < 830; nanometres += 1) {
    const Vec3d response = rec709_response(nanometres);
    const double phase = 2 * kPiD * film.path() / nanometres;
    for (int c = 0; c < 3; ++c) sum[c] += response[c] * reflectance(film, f0[c], phase);
    white += response;
  }
  for (int c = 0; c < 3; ++c) sum[c] = std::clamp(sum[c] / white[c], 0.0, 1.0);
  return sum;
}

Vec3d film_colour(const Film& film, const Vec3d& f0) {
  return to_double(thin_film_reflectance(float(film.cosine), float(film.ior), float(film.thickness),
                                         to_float(f0)));
}

const Vec3d kBases[] = {Vec3d(.02),           Vec3d(.04),           Vec3d(.17), Vec3d(1, .77, .34),
                        Vec3d(.96, .64, .54), Vec3d(.91, .92, .92), Vec3d(.5)};

TEST(ThinFilm, WithoutAFilmIsTheBase) {
  for (const Vec3d& f0 : kBases)
    for (float mu = 0; mu <= 1; mu += .01f) {
      const auto expect_base = [&](float ior, float thickness, double tolerance) {
        const Rgb got = thin_film_reflectance(mu, ior, thickness, to_float(f0));
        for (int c = 0; c < 3; ++c)
          EXPECT_NEAR(double(got[c]), schlick(f0[c], double(mu)), tolerance)
              << "ior " << ior << " thickness " << thickness << " mu " << mu << " f0 " << f0[c];
      };
      for (const float ior : {1.0f, 1.3f, 1.8f, 2.4f}) {
        expect_base(ior, 0, 1e-6);
        expect_base(ior, 1e-3f, 2e-4);  // the transition is continuous
        expect_base(ior, .1f, 5e-3);
      }
      for (const float thickness : {100.0f, 400.0f, 900.0f}) {
        expect_base(1, thickness, 1e-6);
        expect_base(1 + 1e-5f, thickness, 2e-2);
      }
    }
}

// A film with the index of its base has only one face. In the model, the upper face has the exact
// Fresnel reflectance, while the whole has Schlick's. So the lower face reflects the difference of
// the two, and the error is about as large as this difference.
TEST(ThinFilm, FilmWithTheBasesIndexIsNearlyTheBase) {
  for (const double ior : {1.33, 1.5, 1.8, 2.4}) {
    double steep = 0, grazing = 0;
    for (double mu = .005; mu < 1; mu += .01)
      for (const double thickness : {50.0, 150.0, 250.0, 500.0, 900.0}) {
        const Vec3d f0(square((ior - 1) / (ior + 1)));
        const double error = std::abs(film_colour({mu, ior, thickness}, f0).y - schlick(f0.y, mu));
        double& largest = mu > .2 ? steep : grazing;
        largest = std::max(largest, error);
      }
    std::printf("film of the base's index %.2f: %.4f, below cosine 0.2 %.4f\n", ior, steep,
                grazing);
    EXPECT_LT(steep, .09) << ior;
    EXPECT_LT(grazing, .15) << ior;
  }
}

TEST(ThinFilm, MeetsTheSumOverWavelengths) {
  double largest = 0, squares = 0;
  int count = 0;
  for (uint64_t i = 0; i < 2500; ++i) {
    TestRandom random(51, i);
    const Film film{random.next_double(), 1 + 1.5 * random.next_double(),
                    1000 * random.next_double()};
    const Vec3d f0 = i % 2
                         ? kBases[random.bits() % std::size(kBases)]
                         : Vec3d(random.next_double(), random.next_double(), random.next_double());
    const Vec3d got = film_colour(film, f0), want = over_wavelengths(model, film, f0);
    for (int c = 0; c < 3; ++c) {
      const double error = std::abs(got[c] - want[c]);
      largest = std::max(largest, error);
      EXPECT_LT(error, 1.5e-3) << "mu " << film.cosine << " ior " << film.ior << " thickness "
                               << film.thickness << " f0 " << f0[c] << " channel " << c;
      squares += square(error);
      ++count;
    }
  }
  std::printf("against the model's own sum: rms %.2e, largest %.2e\n", std::sqrt(squares / count),
              largest);
}

// Measures the error of scalar amplitudes compared with both polarisations, and the error of the
// extension's model. The bases are dielectrics and metals (aluminium, gold, copper, chromium, iron
// near 600 nm).
TEST(ThinFilm, IsNearTheWholeTruth) {
  const Index metals[] = {{1.2, 7.0}, {.25, 3.0}, {.6, 3.1}, {3.1, 3.3}, {2.9, 2.9}};
  for (const bool dielectric : {true, false}) {
    double ours = 0, theirs = 0, bias = 0, their_bias = 0;
    const int n = 700;
    for (uint64_t i = 0; i < n; ++i) {
      TestRandom random(52, i);
      const Film film{random.next_double(), 1.2 + random.next_double(),
                      1000 * random.next_double()};
      const Index base = dielectric ? Index(1.3 + random.next_double()) : metals[i % 5];
      const Vec3d f0(std::norm((1.0 - base) / (1.0 + base)));
      const Vec3d exact = over_wavelengths(
          [&](const Film& f, double, double phase) { return truth(f, base, phase); }, film, f0);
      const Vec3d a = film_colour(film, f0) - exact;
      const Vec3d b = over_wavelengths(extension, film, f0) - exact;
      ours += dot(a, a) / (3 * n);
      theirs += dot(b, b) / (3 * n);
      bias += (a.x + a.y + a.z) / (3 * n);
      their_bias += (b.x + b.y + b.z) / (3 * n);
    }
    ours = std::sqrt(ours);
    theirs = std::sqrt(theirs);
    std::printf("%s: rms %.4f, mean %.4f; the extension's interfaces %.4f, mean %.4f\n",
                dielectric ? "dielectrics" : "metals", ours, bias, theirs, their_bias);
    EXPECT_LT(ours, dielectric ? .02 : .14);
    EXPECT_LT(ours, (dielectric ? .6 : 1.05) * theirs);
    EXPECT_LT(std::abs(bias), .02);
  }
}

// Thick films have no colour of their own, so every channel gets the mean over phases.
TEST(ThinFilm, ThickFilmsAreGrey) {
  for (const float thickness : {2e4f, 1e6f, 1e30f}) {
    const Rgb got = thin_film_reflectance(.8f, 1.4f, thickness, Rgb(.3f));
    double mean = 0;
    for (int i = 0; i < 360; ++i) mean += model({.8, 1.4, 1e4}, .3, 2 * kPiD * i / 360) / 360;
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(double(got[c]), mean, 1e-4);
  }
}

TEST(ThinFilm, StaysBetweenZeroAndOne) {
  const float edges[] = {0, 1e-38f, 1e-7f, 1e-3f, .5f, 1 - 0x1p-24f, 1, -1, 2, INFINITY, NAN};
  const float thicknesses[] = {0, 1e-30f, 1, 300, 1e6f, INFINITY, -5, NAN};
  const float indices[] = {0, .5f, 1, 1 + 0x1p-23f, 1.3f, 3, 1e6f, INFINITY, NAN};
  for (const float mu : edges)
    for (const float f0 : edges)
      for (const float thickness : thicknesses)
        for (const float ior : indices) {
          const Rgb r = thin_film_reflectance(mu, ior, thickness, Rgb(f0, .3f, 1));
          for (int c = 0; c < 3; ++c)
            ASSERT_TRUE(r[c] >= 0 && r[c] <= 1)
                << mu << " " << f0 << " " << thickness << " " << ior << " gives " << r[c];
        }
  for (uint64_t i = 0; i < 300000; ++i) {
    TestRandom random(53, i);
    const float mu = random.next() < .5f ? random.next() : std::pow(10.0f, -8 * random.next());
    const Rgb f0(random.next(), random.next() < .3f ? 1.0f : random.next(), random.next());
    const Rgb r = thin_film_reflectance(mu, 1 + 2 * random.next(), 1200 * random.next(), f0);
    for (int c = 0; c < 3; ++c) ASSERT_TRUE(r[c] >= 0 && r[c] <= 1) << i;
  }
}

}  // namespace
}  // namespace emberline
