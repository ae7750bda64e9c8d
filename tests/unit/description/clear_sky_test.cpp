// Compares the clear sky with integrals and random walks, which share only the model of the
// atmosphere with it, and with measurements of real skies.
#include "renderer/description/clear_sky.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "renderer/core/moments.h"
#include "renderer/description/atmosphere.h"
#include "support/chi_square.h"
#include "support/long_tests.h"

namespace emberline {
namespace {

using namespace atmosphere;
using test::TestRandom;

constexpr double kRadian = kPiD / 180;

double luminance_of(const Vec3d& c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

Vec3d direction_of(double elevation, double azimuth) {
  const double e = elevation * kRadian, a = azimuth * kRadian;
  return {std::cos(e) * std::sin(a), std::sin(e), -std::cos(e) * std::cos(a)};
}

// The picture of a clear sky, in cd/m^2.
struct Picture {
  EnvironmentDescription sky;

  explicit Picture(const SkySettings& settings) : sky(clear_sky(settings)) {}
  Vec3d at(int x, int y) const {
    std::array<float, 3> rgb;
    std::memcpy(&rgb, sky.image->texels.data() + sizeof rgb * size_t(y * sky.image->width + x),
                sizeof rgb);
    return Vec3d(rgb[0], rgb[1], rgb[2]) * kUnitLuminance;
  }
  Vec3d direction(int x, int y) const {
    const double theta = (y + 0.5) / sky.image->height * kPiD;
    const double phi = ((x + 0.5) / sky.image->width - 0.5) * 2 * kPiD;
    return {std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)};
  }
  Vec3d sun() const {
    return sky.sun ? to_double(sky.sun->irradiance) * kUnitLuminance : Vec3d(0.0);
  }
  // The irradiance on level ground, from the sky without the sun.
  Vec3d irradiance() const {
    Vec3d sum(0.0);
    const int w = sky.image->width, h = sky.image->height;
    for (int y = 0; y < h / 2; ++y) {
      const double theta = (y + 0.5) / h * kPiD;
      for (int x = 0; x < w; ++x) {
        sum += at(x, y) * (std::sin(theta) * std::cos(theta) * 2 * square(kPiD) / (w * h));
      }
    }
    return sum;
  }
  Vec3d zenith() const { return at(0, 0); }
};

// ---- independent integration in the same atmosphere

float extinction(const Density& d, size_t band) {
  const Coefficients& c = coefficients();
  return float(double(c.rayleigh[band]) * d.rayleigh + double(c.ozone[band]) * d.ozone +
               double(c.haze_extinction) * d.haze);
}

// The distance to the ground, or to the top of the atmosphere if the ray misses the ground.
// `ground` tells which.
double distance_out(const Vec3d& from, const Vec3d& direction, bool* ground = nullptr) {
  const double b = dot(from, direction), r2 = from.length2();
  const double d = b * b - r2 + square(kGroundRadius);
  const bool down = b < 0 && d >= 0;
  if (ground) *ground = down;
  return down ? -b - std::sqrt(d) : -b + std::sqrt(b * b - r2 + square(kTopRadius));
}

// The optical depth of each band along the way out of the atmosphere, by Simpson's rule. It is
// infinite if the earth is in the way.
Spectrum depth_out(const Vec3d& from, const Vec3d& direction, int steps) {
  Spectrum depth{};
  bool ground = false;
  const double length = distance_out(from, direction, &ground);
  if (ground && from.length() > kGroundRadius + 0.5) {
    depth.fill(INFINITY);
    return depth;
  }
  for (int i = 0; i <= steps; ++i) {
    const double weight = (i == 0 || i == steps ? 1 : i % 2 ? 4 : 2) * length / (3.0 * steps);
    const Density d = density((from + direction * (length * i / steps)).length() - kGroundRadius);
    for (size_t b = 0; b < kBands; ++b) depth[b] += float(weight) * extinction(d, b);
  }
  return depth;
}

// Integrates single scattering in small, equal steps.
Vec3d single_scattering(const Vec3d& direction, const Vec3d& sun) {
  constexpr int kSteps = 6000;
  const Vec3d eye(0, kGroundRadius + 1, 0);
  const double length = distance_out(eye, direction), step = length / kSteps;
  const double cosine = dot(direction, sun);
  const Coefficients& c = coefficients();
  Spectrum light{}, before{};
  for (int i = 0; i < kSteps; ++i) {
    const Vec3d at = eye + direction * ((i + 0.5) * step);
    const Density d = density(at.length() - kGroundRadius);
    const Spectrum out = depth_out(at, sun, 200);
    for (size_t b = 0; b < kBands; ++b) {
      const float here = extinction(d, b) * float(step);
      const double scattering = double(c.rayleigh[b]) * d.rayleigh * rayleigh_phase(cosine) +
                                double(c.haze_scattering) * d.haze * haze_phase(cosine);
      light[b] += std::exp(-(before[b] + 0.5f * here + out[b])) * float(scattering * step);
      before[b] += here;
    }
  }
  return to_rgb(light);
}

// The tolerance allows for the steps, the tables and the interpolation between rays. It is 1 % of
// the luminance, and 1.7 % of it in a channel. A low sun reddens within a step of the table, so the
// tolerances are 3 % and 5.1 %.
TEST(ClearSky, ScatteredOnceIsTheIntegral) {
  for (const double elevation : {70.0, 30.0, 5.0, -3.0}) {
    const Picture sky({elevation, 40, 0.0, false, 64});
    for (const auto& [x, y] : {std::pair(3, 0), {90, 12}, {20, 20}, {70, 28}, {48, 31}}) {
      const Vec3d found = sky.at(x, y);
      const Vec3d exact = single_scattering(sky.direction(x, y), direction_of(elevation, 40));
      const double share = elevation > 10 ? 0.01 : 0.03;
      EXPECT_NEAR(luminance_of(found), luminance_of(exact), share * luminance_of(exact))
          << elevation << " " << x << "," << y;
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(found[c], std::max(exact[c], 0.0), 1.7 * share * luminance_of(exact))
            << elevation << " " << x << "," << y << " channel " << c;
      }
    }
  }
}

Vec3d turned(const Vec3d& axis, double cosine, double turns) {
  const Vec3d side = std::abs(axis.y) < 0.9 ? Vec3d(0, 1, 0) : Vec3d(1, 0, 0);
  const Vec3d x = side.cross(axis).normalized(), y = axis.cross(x);
  const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine)), a = 2 * kPiD * turns;
  return axis * cosine + (x * std::cos(a) + y * std::sin(a)) * sine;
}

// Follows a random walk in one band and adds the sun's light at every event.
double walk(Vec3d at, Vec3d direction, const Vec3d& sun, size_t band, double albedo,
            TestRandom& random) {
  const Coefficients& c = coefficients();
  const double most = double(extinction(density(0), band)) + double(c.ozone[band]);
  double weight = 1, light = 0;
  const auto sunlight = [&](const Vec3d& place) {
    return std::exp(-double(depth_out(place, sun, 32)[band]));
  };
  for (int events = 0; events < 60;) {
    bool ground = false;
    const double end = distance_out(at, direction, &ground);
    const double metres = -std::log1p(-random.next_double()) / most;
    if (metres >= end) {
      if (!ground) return light;
      at = (at + direction * end).normalized() * (kGroundRadius + 1);
      const Vec3d up = at.normalized();
      weight *= albedo;
      light += weight * std::max(0.0, dot(up, sun)) / kPiD * sunlight(at);
      direction = turned(up, std::sqrt(random.next_double()), random.next_double());
      ++events;
      continue;
    }
    at += direction * metres;
    const Density d = density(at.length() - kGroundRadius);
    if (random.next_double() * most >= double(extinction(d, band))) continue;
    ++events;
    const double air = double(c.rayleigh[band]) * d.rayleigh;
    const double dust = double(c.haze_scattering) * d.haze;
    weight *= (air + dust) / double(extinction(d, band));
    const double cosine = dot(direction, sun);
    light += weight * (air * rayleigh_phase(cosine) + dust * haze_phase(cosine)) / (air + dust) *
             sunlight(at);
    // The direction is uniform, and the weight contains the phase function, whose peak is 7 times
    // its mean.
    const double turn = 2 * random.next_double() - 1;
    weight *= 4 * kPiD * (air * rayleigh_phase(turn) + dust * haze_phase(turn)) / (air + dust);
    direction = turned(direction, turn, random.next_double());
  }
  return light;
}

// Multiple scattering is a third to a half of all light. It is less uniform than Hillaire's method
// assumes, so the tolerance is 5 % of the total under a high sun and 12 % under a low sun. With
// 600,000 walks the largest differences are 3 % and 9 %.
TEST(ClearSky, MultipleScatteringMatchesARandomWalk) {
  constexpr int kWalks = 30'000;
  for (const double elevation : {50.0, 10.0}) {
    const Picture sky({elevation, 0, 0.3, true, 64}), once({elevation, 0, 0.3, false, 64});
    for (const auto& [x, y] : {std::pair(96, 2), {100, 22}, {10, 28}}) {
      Moments walked;
      for (int i = 0; i < kWalks; ++i) {
        TestRandom random(uint64_t(1000 + x), uint64_t(i));
        Spectrum light{};
        const size_t band = size_t(i) % kBands;
        light[band] =
            float(double(kBands) * walk(Vec3d(0, kGroundRadius + 1, 0), sky.direction(x, y),
                                        direction_of(elevation, 0), band, 0.3, random));
        walked.add(luminance_of(to_rgb(light)));
      }
      const double found = luminance_of(sky.at(x, y));
      const double off = elevation > 20 ? 0.05 : 0.12;
      EXPECT_NEAR(found, walked.mean(), off * found + 4 * walked.standard_error())
          << elevation << " " << x << "," << y;
      EXPECT_LT(luminance_of(once.at(x, y)), 0.9 * found);
    }
  }
}

// ---- measurements

// The sun's illuminance outside the atmosphere is 133.1 klx (with the spectrum of ASTM E-490).
TEST(ClearSky, TheSunOutsideTheAir) {
  Spectrum all;
  all.fill(1.0f);
  EXPECT_NEAR(luminance_of(to_rgb(all)), 133.1e3, 0.5e3);
  // The Rayleigh depth at 550 nm is 0.0973: D. Bodhaine et al., "On Rayleigh Optical Depth
  // Calculations" (1999). Our exponential profile differs slightly from theirs, so the tolerance is
  // 12 %.
  EXPECT_NEAR(double(coefficients().rayleigh[8]) * 8000, 0.0973, 0.012);
}

// Under a clear sky the illuminance is about 100 klx at noon, with a tenth of it from the sky. It
// is 400 to 1000 lx at sunset, 3.4 lx at the end of civil twilight and 0.008 lx at the end of
// nautical twilight (IES Lighting Handbook; P. Seidelmann, "Explanatory Supplement to the
// Astronomical Almanac"). These values hold for particular conditions, while our air is clean and
// does not refract, so the tolerance is a factor of 2.
TEST(ClearSky, IsAsBrightAsRealOnes) {
  const auto level = [](double elevation) {
    const Picture sky({elevation, 0, 0.3, true, test::long_or_short(512, 64)});
    const double sky_alone = luminance_of(sky.irradiance());
    return std::pair(sky_alone, sky_alone + luminance_of(sky.sun()) *
                                                std::max(0.0, std::sin(elevation * kRadian)));
  };
  const auto [sky, all] = level(60);
  EXPECT_GT(all, 95e3);
  EXPECT_LT(all, 115e3);
  EXPECT_GT(sky, 0.07 * all);
  EXPECT_LT(sky, 0.2 * all);
  const auto expect_within_2 = [](double found, double measured) {
    EXPECT_GT(found, measured / 2);
    EXPECT_LT(found, measured * 2);
  };
  expect_within_2(level(0).second, 700);
  expect_within_2(level(-6).second, 3.4);
  expect_within_2(level(-12).second, 0.008);
  double before = 1e9;
  for (const double elevation : {90, 50, 20, 6, 1, -1, -3, -7, -11, -15, -19}) {
    const double now = level(elevation).second;
    EXPECT_LT(now, before) << elevation;
    before = now;
  }
  EXPECT_LT(before, 1e-4);          // starlight would add 1e-3 lx but is not modelled
  EXPECT_EQ(level(-45).second, 0);  // the whole atmosphere is in shadow
}

// The sky is blue overhead, white at the horizon, and yellow and red in front of a low sun.
TEST(ClearSky, HasItsColours) {
  const Picture noon({50, 0}), evening({1, 0});
  const Vec3d zenith = noon.zenith();
  EXPECT_GT(zenith.z, 1.5 * zenith.y);
  EXPECT_GT(zenith.y, 1.2 * zenith.x);
  const int middle = noon.sky.image->width / 4, edge = noon.sky.image->height / 2 - 6;
  const Vec3d horizon = noon.at(3 * middle, edge);  // +Z
  EXPECT_GT(luminance_of(horizon), 2 * luminance_of(zenith));
  EXPECT_LT(horizon.z / horizon.x, 0.6 * zenith.z / zenith.x);
  const Vec3d before_the_sun = evening.at(middle, edge), sun = evening.sun();  // -Z
  EXPECT_GT(before_the_sun.x, 2 * before_the_sun.z);
  EXPECT_GT(sun.x, 2 * sun.y);
  EXPECT_GT(sun.y, 10 * sun.z);
  EXPECT_GT(noon.sun().z, 0.6 * noon.sun().x);
  const Vec3d dusk = Picture({-5, 0}).zenith();
  EXPECT_GT(dusk.z, 2 * dusk.y);  // ozone keeps the zenith blue
}

TEST(ClearSky, SunIsAtItsAngles) {
  for (const auto& [azimuth, direction] : {std::pair(0.0, Vec3d(0, 0, -1)),
                                           {90.0, Vec3d(1, 0, 0)},
                                           {180.0, Vec3d(0, 0, 1)},
                                           {-90.0, Vec3d(-1, 0, 0)}}) {
    const Picture sky({20, azimuth, 0.3, true, 64});
    const Vec3d sun = to_double(sky.sky.sun->direction);
    EXPECT_NEAR(
        (sun - (direction * std::cos(20 * kRadian) + Vec3d(0, std::sin(20 * kRadian), 0))).length(),
        0, 1e-6);
    std::pair brightest(0, 0);
    for (int y = 0; y < 32; ++y) {
      for (int x = 0; x < 128; ++x) {
        if (sky.at(x, y).x > sky.at(brightest.first, brightest.second).x) brightest = {x, y};
      }
    }
    // Haze glows around the sun, and the horizon below the sun is brighter still. So the test
    // compares only the azimuth of the brightest pixel.
    Vec3d at = sky.direction(brightest.first, brightest.second);
    at.y = 0;
    EXPECT_GT(dot(at.normalized(), direction), std::cos(3 * kRadian)) << azimuth;
  }
  EXPECT_TRUE(Picture({-0.2, 0}).sky.sun);
  EXPECT_FALSE(Picture({-0.3, 0}).sky.sun);
}

TEST(ClearSky, IsFiniteFromPoleToPole) {
  for (int elevation = -90; elevation <= 90; elevation += test::long_or_short(5, 15)) {
    const Picture sky({double(elevation), 359.5, 0.3, true, 32});
    for (int y = 0; y < 32; ++y) {
      for (int x = 0; x < 64; ++x) {
        const Vec3d c = sky.at(x, y);
        ASSERT_TRUE(c.x >= 0 && c.y >= 0 && c.z >= 0 && c.x + c.y + c.z < 1e6) << elevation;
      }
    }
  }
}

}  // namespace
}  // namespace emberline
