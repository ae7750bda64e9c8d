#include "renderer/description/clear_sky.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "renderer/core/constants.h"
#include "renderer/core/parallel.h"
#include "renderer/core/setting_names.h"
#include "renderer/description/atmosphere.h"

namespace emberline {
namespace {

using namespace atmosphere;

constexpr double kRadian = kPiD / 180;
constexpr double kSunRadius = 0.265 * kRadian;

// Densities of air, haze and ozone, integrated over a ray in metres. They are relative to the
// densities for which Coefficients are given.
struct Column {
  double rayleigh = 0, haze = 0, ozone = 0;

  void add(const Density& d, double metres) {
    rayleigh += d.rayleigh * metres;
    haze += d.haze * metres;
    ozone += d.ozone * metres;
  }
  Column operator+(const Column& o) const {
    return {rayleigh + o.rayleigh, haze + o.haze, ozone + o.ozone};
  }
  Column operator*(double s) const { return {rayleigh * s, haze * s, ozone * s}; }
};

Spectrum transmittance(const Column& column) {
  const Coefficients& c = coefficients();
  const auto rayleigh = float(column.rayleigh), ozone = float(column.ozone);
  const float haze = float(column.haze) * c.haze_extinction;
  Spectrum result;
  for (size_t b = 0; b < kBands; ++b) {
    result[b] = std::exp(-(c.rayleigh[b] * rayleigh + c.ozone[b] * ozone + haze));
  }
  return result;
}

// These functions return the distance from a position at `radius` to the top of the atmosphere, or
// to the ground. `cosine` is the cosine of the angle between the direction and the zenith.
double distance_to_top(double radius, double cosine) {
  const double across = radius * cosine;
  return -across +
         std::sqrt(std::max(0.0, across * across + kTopRadius * kTopRadius - radius * radius));
}
double distance_to_ground(double radius, double cosine) {  // negative: misses it
  const double across = radius * cosine,
               d = across * across + kGroundRadius * kGroundRadius - radius * radius;
  return cosine < 0 && d >= 0 ? std::max(0.0, -across - std::sqrt(d)) : -1;
}

// Divides a ray into `steps` pieces, whose length grows with the distance. At the midpoint of each
// piece, calls visit(position, radius, length of the piece in metres, density, column from the
// start of the ray). Returns the column of the whole ray.
template <typename Visit>
Column march(const Vec3d& from, const Vec3d& direction, double length, int steps,
             const Visit& visit) {
  Column column;
  for (int i = 0; i < steps; ++i) {
    const double metres = length * (2 * i + 1) / (double(steps) * steps);
    const double s = (i + 0.5) / steps;
    const Vec3d position = from + direction * (length * (s * s + 0.25 / (double(steps) * steps)));
    const double radius = position.length();
    const Density d = density(radius - kGroundRadius);
    Column half = column;
    half.add(d, 0.5 * metres);
    column.add(d, metres);
    visit(position, radius, metres, d, half);
  }
  return column;
}

// A table of values over two variables: the height, and the angle between zenith and sun. Heights
// are denser near the ground. Angles lie within `reach` of `middle`.
template <typename Value>
class SkyTable {
 public:
  SkyTable(int heights, int angles, double middle, double reach)
      : heights_(heights),
        angles_(angles),
        first_(std::max(0.0, middle - reach)),
        last_(std::min(kPiD, middle + reach)),
        values_(size_t(heights) * size_t(angles)) {}

  template <typename Make>
  void fill(const Make& make) {
    parallel_each(values_.size(), [&](size_t i) {
      const double s = double(i / size_t(angles_)) / (heights_ - 1);
      const double angle = first_ + (last_ - first_) * double(i % size_t(angles_)) / (angles_ - 1);
      values_[i] = make(kGroundRadius + (kTopRadius - kGroundRadius) * s * s, angle);
    });
  }

  // Calls take(value, weight) for the four values that are interpolated at a position.
  template <typename Take>
  void around(double radius, double angle, const Take& take) const {
    const double height =
        std::clamp((radius - kGroundRadius) / (kTopRadius - kGroundRadius), 0.0, 1.0);
    const double y = std::sqrt(height) * (heights_ - 1);
    const double x = std::clamp((angle - first_) / (last_ - first_), 0.0, 1.0) * (angles_ - 1);
    const int row = std::min(int(y), heights_ - 2), at = std::min(int(x), angles_ - 2);
    const double down = y - row, right = x - at;
    const Value* upper = &values_[size_t(row * angles_ + at)];
    take(upper[0], (1 - down) * (1 - right));
    take(upper[1], (1 - down) * right);
    take(upper[angles_], down * (1 - right));
    take(upper[angles_ + 1], down * right);
  }

 private:
  int heights_, angles_;
  double first_, last_;
  std::vector<Value> values_;
};

// Angular ranges of the tables. A ray from the ground travels at most 10 degrees around the earth
// before it leaves the atmosphere. A ray that is scattered there and then grazes the ground travels
// up to 20 degrees more.
constexpr double kViewReach = 10.6 * kRadian, kSecondOrderReach = 32 * kRadian;
constexpr int kViewSteps = 64, kSecondOrderSteps = 24;

class Sky {
 public:
  explicit Sky(const SkySettings& settings)
      : settings_(settings),
        elevation_(settings.elevation * kRadian),
        sun_columns_(64, 257, kPiD / 2 - elevation_, kSecondOrderReach),
        multiple_table_(20, 25, kPiD / 2 - elevation_, kViewReach) {
    sun_columns_.fill([](double radius, double angle) {
      const double cosine = std::cos(angle);
      return march(Vec3d(0, radius, 0), Vec3d(std::sin(angle), cosine, 0),
                   distance_to_top(radius, cosine), 48, [](const auto&...) {});
    });
    if (!settings.multiple_scattering) return;
    multiple_table_.fill(
        [this](double radius, double angle) { return compute_multiple_scattering(radius, angle); });
  }

  // Returns the sunlight that reaches a position and then passes through the column `further`. The
  // horizon may hide part of the sun's disc.
  Spectrum sunlight(double radius, double angle, const Column& further) const {
    const double horizon = kPiD / 2 + std::acos(std::min(1.0, kGroundRadius / radius));
    const double sun_visibility = std::clamp(0.5 + (horizon - angle) / (2 * kSunRadius), 0.0, 1.0);
    if (sun_visibility <= 0) return {};
    Column column = further;
    sun_columns_.around(radius, angle,
                        [&](const Column& c, double weight) { column = column + c * weight; });
    Spectrum light = transmittance(column);
    for (float& l : light) l *= float(sun_visibility);
    return light;
  }

  // Scattered light as seen from the ground. `rayleigh` and `haze` are singly scattered light, to
  // be multiplied by their phase functions.
  struct ScatteredLight {
    Vec3d rayleigh = Vec3d(0.0), haze = Vec3d(0.0), multiple = Vec3d(0.0);
  };
  // Returns the light from a direction above the horizon. `azimuth` is relative to the azimuth of
  // the sun.
  ScatteredLight scattered_light(double elevation, double azimuth) const {
    const Coefficients& c = coefficients();
    const Vec3d sun(std::cos(elevation_), std::sin(elevation_), 0);
    const Vec3d direction(std::cos(elevation) * std::cos(azimuth), std::sin(elevation),
                          std::cos(elevation) * std::sin(azimuth));
    Spectrum rayleigh{}, haze{}, multiple{};
    march(Vec3d(0, kGroundRadius, 0), direction, distance_to_top(kGroundRadius, direction.y),
          kViewSteps,
          [&](const Vec3d& position, double radius, double metres, const Density& d,
              const Column& before) {
            const double angle = std::acos(std::clamp(dot(position, sun) / radius, -1.0, 1.0));
            const Spectrum light = sunlight(radius, angle, before);
            const auto air = float(d.rayleigh * metres);
            const float dust = float(d.haze * metres) * c.haze_scattering;
            for (size_t b = 0; b < kBands; ++b) {
              rayleigh[b] += c.rayleigh[b] * air * light[b];
              haze[b] += dust * light[b];
            }
            if (!settings_.multiple_scattering) return;
            Spectrum around{};
            multiple_table_.around(radius, angle, [&](const Spectrum& s, double weight) {
              for (size_t b = 0; b < kBands; ++b) around[b] += float(weight) * s[b];
            });
            const Spectrum transmitted = transmittance(before);
            for (size_t b = 0; b < kBands; ++b) {
              multiple[b] += (c.rayleigh[b] * air + dust) * transmitted[b] * around[b];
            }
          });
    return {to_rgb(rayleigh), to_rgb(haze), to_rgb(multiple)};
  }

 private:
  // Computes the light of the second order of scattering at a position (Hillaire's equations 5 to
  // 10). Adds the light of all higher orders as a geometric series. The sun's irradiance outside
  // the atmosphere is taken to be 1.
  Spectrum compute_multiple_scattering(double radius, double angle) const {
    constexpr int kZeniths = 16, kAzimuths = 4;  // half the sphere; the other half is symmetric
    const Coefficients& c = coefficients();
    const Vec3d from(0, radius, 0), sun(std::sin(angle), std::cos(angle), 0);
    Spectrum second{}, scattered_fraction{};
    for (int i = 0; i < kZeniths * kAzimuths; ++i) {
      const double y = -1 + (i / kAzimuths + 0.5) * 2 / kZeniths;
      const double azimuth = kPiD * (i % kAzimuths + 0.5) / kAzimuths;
      const double level = std::sqrt(1 - y * y);
      const Vec3d direction(level * std::cos(azimuth), y, level * std::sin(azimuth));
      const double down = distance_to_ground(radius, y);
      const double length = down >= 0 ? down : distance_to_top(radius, y);
      const auto angle_at = [&](const Vec3d& position, double r) {
        return std::acos(std::clamp(dot(position, sun) / r, -1.0, 1.0));
      };
      const Column whole = march(from, direction, length, kSecondOrderSteps,
                                 [&](const Vec3d& position, double r, double metres,
                                     const Density& d, const Column& before) {
                                   const Spectrum light =
                                       sunlight(r, angle_at(position, r), before);
                                   const Spectrum transmitted = transmittance(before);
                                   const auto air = float(d.rayleigh * metres);
                                   const float dust = float(d.haze * metres) * c.haze_scattering;
                                   for (size_t b = 0; b < kBands; ++b) {
                                     const float scattered = c.rayleigh[b] * air + dust;
                                     second[b] += scattered * light[b] * float(0.25 / kPiD);
                                     scattered_fraction[b] += scattered * transmitted[b];
                                   }
                                 });
      if (down < 0) continue;
      const Vec3d ground = from + direction * length;
      const double at = angle_at(ground, kGroundRadius), facing = std::max(0.0, std::cos(at));
      const Spectrum light = sunlight(kGroundRadius, at, whole);
      for (size_t b = 0; b < kBands; ++b) {
        second[b] += light[b] * float(facing * settings_.ground_albedo / kPiD);
      }
    }
    constexpr float kDirectionWeight = 1.0f / (kZeniths * kAzimuths);
    for (size_t b = 0; b < kBands; ++b)
      second[b] *= kDirectionWeight / (1 - scattered_fraction[b] * kDirectionWeight);
    return second;
  }

  SkySettings settings_;
  double elevation_;
  SkyTable<Column> sun_columns_;
  SkyTable<Spectrum> multiple_table_;  // light of multiple scattering, taken as isotropic
};

// Computes the upper half of the map. Scattered light is interpolated between rays, which are
// denser towards the horizon, and the phase functions are evaluated for each texel.
class SkyPainter {
 public:
  SkyPainter(const Sky& sky, const SkySettings& settings)
      : elevation_(settings.elevation * kRadian), rays_(size_t(kRows) * kColumns) {
    parallel_each(rays_.size(), [&](size_t i) {
      const double s = double(i / kColumns) / (kRows - 1);
      rays_[i] =
          sky.scattered_light(kPiD / 2 * s * s, kPiD * double(i % kColumns) / (kColumns - 1));
    });
  }

  // `azimuth` is relative to the azimuth of the sun, and may be more than a full turn. The
  // elevation must not be negative.
  Vec3d radiance(double elevation, double azimuth) const {
    const double relative_azimuth = std::abs(std::remainder(azimuth, 2 * kPiD));
    const double y = std::sqrt(elevation / (kPiD / 2)) * (kRows - 1);
    const double x = relative_azimuth / kPiD * (kColumns - 1);
    const int row = std::min(int(y), kRows - 2), at = std::min(int(x), kColumns - 2);
    const Sky::ScatteredLight* upper = &rays_[size_t(row * kColumns + at)];
    const double cosine = std::sin(elevation) * std::sin(elevation_) +
                          std::cos(elevation) * std::cos(elevation_) * std::cos(relative_azimuth);
    const double air = rayleigh_phase(cosine), dust = haze_phase(cosine);
    const auto total = [&](const Sky::ScatteredLight& s) {
      return s.rayleigh * air + s.haze * dust + s.multiple;
    };
    const auto across = [&](const Sky::ScatteredLight* s) {
      return lerp(total(s[0]), total(s[1]), x - at);
    };
    const Vec3d sum = lerp(across(upper), across(upper + kColumns), y - row) / kUnitLuminance;
    return {std::max(sum.x, 0.0), std::max(sum.y, 0.0), std::max(sum.z, 0.0)};
  }

 private:
  static constexpr int kRows = 64, kColumns = 33;
  static Vec3d lerp(const Vec3d& a, const Vec3d& b, double t) { return a * (1 - t) + b * t; }

  double elevation_;
  std::vector<Sky::ScatteredLight> rays_;
};

}  // namespace

EnvironmentDescription clear_sky(const SkySettings& settings) {
  const Sky sky(settings);
  const SkyPainter painter(sky, settings);
  const int height = settings.height, width = 2 * height, above = height / 2;
  const double elevation = settings.elevation * kRadian, azimuth = settings.azimuth * kRadian;

  auto image = std::make_shared<Image>();
  image->name =
      spell_setting_names(fmt::format("`sun` {},{}", settings.elevation, settings.azimuth));
  image->width = width;
  image->height = height;
  image->channels = 3;
  image->type = TexelType::kFloat;
  image->texels.resize(image->byte_count());
  const auto put = [&](int x, int y, const Vec3d& rgb) {
    const Vec3f value = to_float(rgb);
    std::memcpy(&image->texels[sizeof value * (size_t(y) * size_t(width) + size_t(x))], &value,
                sizeof value);
  };

  // The irradiance of the ground from each row of the sky.
  std::vector<Vec3d> row_irradiance(size_t(above), Vec3d(0.0));
  parallel_each(size_t(above), [&](size_t row) {
    const double up = kPiD / 2 - kPiD * (double(row) + 0.5) / height;
    for (int x = 0; x < width; ++x) {
      // Longitude is measured from +X towards +Z. Azimuth starts a quarter turn earlier, at -Z.
      const double longitude = (double(x) + 0.5) / width * 2 * kPiD - kPiD;
      const Vec3d radiance = painter.radiance(up, longitude + kPiD / 2 - azimuth);
      put(x, int(row), radiance);
      row_irradiance[row] += radiance * (std::cos(up) * std::sin(up));
    }
  });

  EnvironmentDescription environment;
  environment.file = image->name;
  const Spectrum direct = sky.sunlight(kGroundRadius, kPiD / 2 - std::max(elevation, 0.0), {});
  const double sun_visibility = std::clamp(0.5 + elevation / (2 * kSunRadius), 0.0, 1.0);
  Vec3d sunlight = to_rgb(direct) / kUnitLuminance;
  for (int c = 0; c < 3; ++c) sunlight[c] = std::max(sunlight[c], 0.0);
  if (sun_visibility > 0) {
    SunDisc sun;
    sun.direction = to_float(Vec3d(std::cos(elevation) * std::sin(azimuth), std::sin(elevation),
                                   -std::cos(elevation) * std::cos(azimuth)));
    sun.radius = float(kSunRadius);
    sun.irradiance = to_float(sunlight);
    environment.sun = std::make_shared<const SunDisc>(sun);
  }

  Vec3d ground = sunlight * (sun_visibility * std::max(0.0, std::sin(elevation)));
  for (const Vec3d& row : row_irradiance) ground += row * (kPiD / height * 2 * kPiD / width);
  ground *= settings.ground_albedo / kPiD;
  for (int y = above; y < height; ++y) {
    for (int x = 0; x < width; ++x) put(x, y, ground);
  }
  environment.image = std::move(image);
  return environment;
}

}  // namespace emberline
