#include "renderer/statistics/flip.h"

#include <Imath/ImathMatrix.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <numeric>

#include "renderer/core/parallel.h"
#include "renderer/core/vector.h"
#include "renderer/statistics/plane.h"

namespace emberline {
namespace {

constexpr double kPi = std::numbers::pi;

// Sections 4.1.3 and 4.3: the exponent qc and the knee (pc, pt) of the colour error, and the
// exponent qf of the feature error.
constexpr double kQc = 0.7;
constexpr double kPc = 0.4;
constexpr double kPt = 0.95;
constexpr double kQf = 0.5;
// Section 4.2: the width, in degrees, of the features that are detected.
constexpr double kFeatureWidth = 0.082;

// Section 4.1.1, table 1: the spatial contrast sensitivity of each channel of YCxCz is a sum of one
// or two Gaussians a sqrt(pi / b) exp(-pi^2 x^2 / b), where x is the angle in degrees.
struct Gaussian {
  double a, b;
};
constexpr Gaussian kAchromatic = {1.0, 0.0047};
constexpr Gaussian kRedGreen = {1.0, 0.0053};
constexpr std::array<Gaussian, 2> kBlueYellow = {{{34.1, 0.04}, {13.5, 0.025}}};

// ---- colour ------------------------------------------------------------------------------------

// Returns the matrix from linear sRGB to XYZ (for row vectors), which follows from the primaries
// and the white of ITU-R BT.709.
Imath::M33d rgb_to_xyz_matrix() {
  constexpr double kPrimaries[3][2] = {{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}};
  const Vec3d white(0.3127 / 0.3290, 1.0, (1 - 0.3127 - 0.3290) / 0.3290);
  Imath::M33d primaries;
  for (int i = 0; i < 3; ++i) {
    const double x = kPrimaries[i][0], y = kPrimaries[i][1];
    primaries[i][0] = x;
    primaries[i][1] = y;
    primaries[i][2] = 1 - x - y;
  }
  const Vec3d scale = white * primaries.inverse();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) primaries[i][j] *= scale[i];
  }
  return primaries;
}

const Imath::M33d kRgbToXyz = rgb_to_xyz_matrix();
const Imath::M33d kXyzToRgb = kRgbToXyz.inverse();
const Vec3d kWhite = Vec3d(1, 1, 1) * kRgbToXyz;

double srgb_to_linear(double v) {
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

// Converts to linearised L*a*b* (the paper's YCxCz), whose opponent channels are linear in light.
Vec3d xyz_to_ycxcz(const Vec3d& xyz) {
  const Vec3d n = xyz / kWhite;
  return {116 * n.y - 16, 500 * (n.x - n.y), 200 * (n.y - n.z)};
}

Vec3d ycxcz_to_xyz(const Vec3d& c) {
  const double y = (c.x + 16) / 116;
  return Vec3d(y + c.y / 500, y, y - c.z / 200) * kWhite;
}

// Converts to CIE L*a*b* with Hunt-adjusted a* and b*: these are multiplied by lightness / 100,
// because colour differences look smaller in the dark.
Vec3d linear_rgb_to_hunt_lab(const Vec3d& rgb) {
  constexpr double kDelta = 6.0 / 29.0;
  const auto f = [](double t) {
    return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0 / 29.0;
  };
  const Vec3d n = rgb * kRgbToXyz / kWhite;
  const double fx = f(n.x), fy = f(n.y), fz = f(n.z);
  const double lightness = 116 * fy - 16;
  return {lightness, 0.01 * lightness * 500 * (fx - fy), 0.01 * lightness * 200 * (fy - fz)};
}

// Returns the HyAB distance: the absolute difference in lightness, plus the Euclidean distance in
// a* and b*.
double hyab(const Vec3d& a, const Vec3d& b) {
  return std::abs(a.x - b.x) + std::hypot(a.y - b.y, a.z - b.z);
}

// The HyAB distance between green and blue, which is the largest in the sRGB gamut, to the power
// qc.
const double kLargestColourError =
    std::pow(hyab(linear_rgb_to_hunt_lab({0, 1, 0}), linear_rgb_to_hunt_lab({0, 0, 1})), kQc);

// Section 4.1.3: maps errors below pc times the largest error to [0, pt], and larger errors to [pt,
// 1].
double redistribute(double distance) {
  const double error = std::pow(distance, kQc);
  const double knee = kPc * kLargestColourError;
  if (error < knee) return kPt / knee * error;
  return kPt + (error - knee) / (kLargestColourError - knee) * (1 - kPt);
}

// ---- filters -----------------------------------------------------------------------------------

// The weights of a filter at the offsets -r to r. All kernels here are separable, or sums of two
// separable kernels.
using Taps = std::vector<double>;

template <typename Function>
Taps make_taps(int radius, const Function& fn) {
  Taps taps;
  for (int i = -radius; i <= radius; ++i) taps.push_back(fn(double(i)));
  return taps;
}

double sum(const Taps& taps) { return std::accumulate(taps.begin(), taps.end(), 0.0); }

Taps scaled(Taps taps, double factor) {
  for (double& tap : taps) tap *= factor;
  return taps;
}

Taps normalized(const Taps& taps) { return scaled(taps, 1 / sum(taps)); }

// Scales the positive taps to a sum of 1, and the negative taps to a sum of -1.
Taps balanced(Taps taps) {
  double positive = 0, negative = 0;
  for (const double tap : taps) (tap > 0 ? positive : negative) += std::abs(tap);
  for (double& tap : taps) tap /= tap > 0 ? positive : negative;
  return taps;
}

struct Kernels {
  int spatial_radius = 0, feature_radius = 0;
  Taps achromatic, red_green;       // the sum of each is 1
  std::array<Taps, 2> blue_yellow;  // one per Gaussian; the squares of their sums add up to 1
  Taps smooth, edge, point;         // Gaussian with sum 1; its derivatives, balanced()
};

Kernels make_kernels(double pixels_per_degree) {
  Kernels k;
  double widest = std::max(kAchromatic.b, kRedGreen.b);
  for (const Gaussian& g : kBlueYellow) widest = std::max(widest, g.b);
  // exp(-pi^2 x^2 / b) has the standard deviation sqrt(b / 2) / pi degrees.
  k.spatial_radius = int(std::ceil(3 * std::sqrt(widest / 2) / kPi * pixels_per_degree));
  const auto spatial = [&](const Gaussian& g) {
    return make_taps(k.spatial_radius, [&](double i) {
      const double x = i / pixels_per_degree;
      return std::exp(-kPi * kPi * x * x / g.b);
    });
  };
  k.achromatic = normalized(spatial(kAchromatic));
  k.red_green = normalized(spatial(kRedGreen));
  // The two Gaussians of blue-yellow keep their ratio, and together sum to 1 over the plane. The
  // factor of each is split evenly between its taps along x and its taps along y.
  double total = 0;
  for (size_t i = 0; i < 2; ++i) {
    const Gaussian& g = kBlueYellow[i];
    k.blue_yellow[i] = scaled(spatial(g), std::sqrt(g.a * std::sqrt(kPi / g.b)));
    total += square(sum(k.blue_yellow[i]));
  }
  for (Taps& taps : k.blue_yellow) taps = scaled(taps, 1 / std::sqrt(total));

  // Section 4.2: the first and second derivatives of a Gaussian that is as wide as the features to
  // detect.
  const double sigma = 0.5 * kFeatureWidth * pixels_per_degree;
  k.feature_radius = int(std::ceil(3 * sigma));
  const auto gaussian = [&](double i) { return std::exp(-i * i / (2 * sigma * sigma)); };
  k.smooth = normalized(make_taps(k.feature_radius, gaussian));
  k.edge = balanced(make_taps(k.feature_radius, [&](double i) { return -i * gaussian(i); }));
  k.point = balanced(make_taps(
      k.feature_radius, [&](double i) { return (i * i / (sigma * sigma) - 1) * gaussian(i); }));
  return k;
}

// Filters the plane vertically with `down` and horizontally with `along`, and returns row `y` of
// the result. Beyond the border, repeats the values at the border.
std::vector<double> filter(const Plane& plane, int y, const Taps& down, const Taps& along) {
  const size_t width = size_t(plane.width), margin = along.size() / 2;
  const int radius = int(down.size() / 2);
  std::vector<double> padded(width + 2 * margin), out(width);
  double* const row = padded.data() + margin;
  for (int k = -radius; k <= radius; ++k) {
    const float* const source =
        &plane.values[size_t(std::clamp(y + k, 0, plane.height - 1)) * width];
    const double tap = down[size_t(k + radius)];
    for (size_t x = 0; x < width; ++x) row[x] += tap * double(source[x]);
  }
  std::fill_n(padded.begin(), margin, row[0]);
  std::fill_n(padded.rbegin(), margin, row[width - 1]);
  for (size_t k = 0; k < along.size(); ++k) {
    for (size_t x = 0; x < width; ++x) out[x] += along[k] * padded[k + x];
  }
  return out;
}

using Opponent = std::array<Plane, 3>;  // Y, Cx, Cz

Opponent to_opponent(const RgbImage& picture) {
  Opponent planes;
  for (Plane& plane : planes) {
    plane = {picture.width, picture.height, std::vector<float>(picture.rgb.size() / 3)};
  }
  parallel_each(planes[0].values.size(), [&](size_t i) {
    Vec3d rgb;
    for (int c = 0; c < 3; ++c) rgb[c] = srgb_to_linear(double(picture.rgb[3 * i + size_t(c)]));
    const Vec3d opponent = xyz_to_ycxcz(rgb * kRgbToXyz);
    for (int c = 0; c < 3; ++c) planes[size_t(c)].values[i] = float(opponent[c]);
  });
  return planes;
}

// Section 4.1: returns the colours of a row as perceived at the viewing distance, in Hunt-adjusted
// L*a*b*.
std::vector<Vec3d> perceived_row(const Opponent& planes, int y, const Kernels& k) {
  const std::vector<double> luminance = filter(planes[0], y, k.achromatic, k.achromatic);
  const std::vector<double> red_green = filter(planes[1], y, k.red_green, k.red_green);
  std::vector<double> blue_yellow = filter(planes[2], y, k.blue_yellow[0], k.blue_yellow[0]);
  const std::vector<double> second = filter(planes[2], y, k.blue_yellow[1], k.blue_yellow[1]);
  std::vector<Vec3d> row(luminance.size());
  for (size_t x = 0; x < row.size(); ++x) {
    const Vec3d opponent(luminance[x], red_green[x], blue_yellow[x] + second[x]);
    Vec3d rgb = ycxcz_to_xyz(opponent) * kXyzToRgb;
    for (int c = 0; c < 3; ++c) rgb[c] = std::clamp(rgb[c], 0.0, 1.0);
    row[x] = linear_rgb_to_hunt_lab(rgb);
  }
  return row;
}

struct Features {
  double edge, point;
};

// Section 4.2: returns the strength, in [0, sqrt 2], of the edges and points in the luminance of a
// row.
std::vector<Features> feature_row(const Plane& luminance, int y, const Kernels& k) {
  const std::vector<double> edge_x = filter(luminance, y, k.smooth, k.edge);
  const std::vector<double> edge_y = filter(luminance, y, k.edge, k.smooth);
  const std::vector<double> point_x = filter(luminance, y, k.smooth, k.point);
  const std::vector<double> point_y = filter(luminance, y, k.point, k.smooth);
  std::vector<Features> row(edge_x.size());
  for (size_t x = 0; x < row.size(); ++x) {
    // Y of YCxCz is 116 Y/Yn - 16. The derivatives remove the offset -16, but not the factor 116.
    row[x] = {std::hypot(edge_x[x], edge_y[x]) / 116, std::hypot(point_x[x], point_y[x]) / 116};
  }
  return row;
}

}  // namespace

std::vector<float> flip_map(const RgbImage& picture, const RgbImage& reference,
                            double pixels_per_degree) {
  assert(picture.width > 0 && picture.height > 0);
  assert(picture.width == reference.width && picture.height == reference.height);
  const Kernels kernels = make_kernels(pixels_per_degree);
  const Opponent ours = to_opponent(picture), theirs = to_opponent(reference);

  std::vector<float> map(picture.rgb.size() / 3);
  for_each_row(picture.height, [&](int y) {
    const std::vector<Vec3d> our_colours = perceived_row(ours, y, kernels);
    const std::vector<Vec3d> their_colours = perceived_row(theirs, y, kernels);
    const std::vector<Features> our_features = feature_row(ours[0], y, kernels);
    const std::vector<Features> their_features = feature_row(theirs[0], y, kernels);
    float* const row = &map[size_t(y) * size_t(picture.width)];
    for (size_t x = 0; x < our_colours.size(); ++x) {
      const double colour = redistribute(hyab(our_colours[x], their_colours[x]));
      const double edge = std::abs(our_features[x].edge - their_features[x].edge);
      const double point = std::abs(our_features[x].point - their_features[x].point);
      const double feature = std::pow(std::max(edge, point) / std::numbers::sqrt2, kQf);
      // Section 4.3: a difference in features makes a colour error more visible.
      row[x] = float(std::pow(colour, 1 - feature));
    }
  });
  return map;
}

}  // namespace emberline
