// Compares LDR-FLIP with values computed by hand from the paper's formulas, and with a literal
// implementation. The latter has two-dimensional kernels and printed colour matrices, and shares no
// code with the implementation under test.
#include "renderer/statistics/flip.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "support/constant_picture.h"

namespace emberline {
namespace {

using test::constant_picture;

constexpr double kPi = 3.14159265358979323846;
using Colour = std::array<double, 3>;

double mean(const std::vector<float>& map) {
  double sum = 0;
  for (const float value : map) sum += double(value);
  return sum / double(map.size());
}

// ---- literal implementation --------------------------------------------------------------------

Colour multiply(const double (&m)[3][3], const Colour& v) {
  Colour out{};
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = 0; j < 3; ++j) out[i] += m[i][j] * v[j];
  }
  return out;
}

// The matrices from and to sRGB, and the white D65, computed from the chromaticities of BT.709 to
// ten digits.
constexpr double kToXyz[3][3] = {{0.4123907993, 0.3575843394, 0.1804807884},
                                 {0.2126390059, 0.7151686788, 0.0721923154},
                                 {0.0193308187, 0.1191947798, 0.9505321522}};
constexpr double kFromXyz[3][3] = {{3.2409699419, -1.5373831776, -0.4986107603},
                                   {-0.9692436363, 1.8759675015, 0.0415550574},
                                   {0.0556300797, -0.2039769589, 1.0569715142}};
constexpr double kWhiteX = 0.9504559271, kWhiteZ = 1.0890577508;

double decode(double v) { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); }

Colour ycxcz(const Colour& linear) {
  const Colour xyz = multiply(kToXyz, linear);
  const double x = xyz[0] / kWhiteX, y = xyz[1], z = xyz[2] / kWhiteZ;
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

Colour hunt_lab(const Colour& linear) {
  const Colour xyz = multiply(kToXyz, linear);
  const auto f = [](double t) {
    return t > 216.0 / 24389.0 ? std::cbrt(t) : (24389.0 / 27.0 * t + 16) / 116;
  };
  const double fx = f(xyz[0] / kWhiteX), fy = f(xyz[1]), fz = f(xyz[2] / kWhiteZ);
  const double l = 116 * fy - 16;
  return {l, 0.01 * l * 500 * (fx - fy), 0.01 * l * 200 * (fy - fz)};
}

double colour_distance(const Colour& a, const Colour& b) {
  return std::abs(a[0] - b[0]) +
         std::sqrt((a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

double colour_error(double distance) {
  const double largest = std::pow(colour_distance(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1})), 0.7);
  const double error = std::pow(distance, 0.7);
  if (error < 0.4 * largest) return 0.95 / (0.4 * largest) * error;
  return 0.95 + (error - 0.4 * largest) / (0.6 * largest) * 0.05;
}

struct Literal {
  int width, height;
  std::vector<Colour> opponent;

  explicit Literal(const RgbImage& image) : width(image.width), height(image.height) {
    for (size_t i = 0; i < image.rgb.size(); i += 3) {
      opponent.push_back(ycxcz({decode(double(image.rgb[i])), decode(double(image.rgb[i + 1])),
                                decode(double(image.rgb[i + 2]))}));
    }
  }

  const Colour& at(int x, int y) const {
    return opponent[size_t(std::clamp(y, 0, height - 1) * width + std::clamp(x, 0, width - 1))];
  }

  Colour perceived(int x, int y, double ppd) const {
    const double b[3][2] = {{0.0047, 1e-5}, {0.0053, 1e-5}, {0.04, 0.025}};
    const double a[3][2] = {{1, 0}, {1, 0}, {34.1, 13.5}};
    const int radius = int(std::ceil(3 * std::sqrt(0.04 / (2 * kPi * kPi)) * ppd));
    Colour filtered{};
    for (size_t c = 0; c < 3; ++c) {
      double weights = 0;
      for (int j = -radius; j <= radius; ++j) {
        for (int i = -radius; i <= radius; ++i) {
          const double d2 = (i * i + j * j) / (ppd * ppd);
          double weight = 0;
          for (size_t k = 0; k < 2; ++k) {
            weight += a[c][k] * std::sqrt(kPi / b[c][k]) * std::exp(-kPi * kPi * d2 / b[c][k]);
          }
          filtered[c] += weight * at(x + i, y + j)[c];
          weights += weight;
        }
      }
      filtered[c] /= weights;
    }
    const double relative_y = (filtered[0] + 16) / 116;
    Colour linear = multiply(kFromXyz, {(relative_y + filtered[1] / 500) * kWhiteX, relative_y,
                                        (relative_y - filtered[2] / 200) * kWhiteZ});
    for (double& value : linear) value = std::clamp(value, 0.0, 1.0);
    return hunt_lab(linear);
  }

  // The magnitude of the response to an edge (order 1) or a point (order 2).
  double feature(int x, int y, double ppd, int order) const {
    const double sigma = 0.5 * 0.082 * ppd;
    const int radius = int(std::ceil(3 * sigma));
    double response[2] = {0, 0}, positive = 0, negative = 0;
    for (int j = -radius; j <= radius; ++j) {
      for (int i = -radius; i <= radius; ++i) {
        const double g = std::exp(-(i * i + j * j) / (2 * sigma * sigma));
        const double weight = order == 1 ? -i * g : (i * i / (sigma * sigma) - 1) * g;
        (weight > 0 ? positive : negative) += std::abs(weight);
      }
    }
    for (int j = -radius; j <= radius; ++j) {
      for (int i = -radius; i <= radius; ++i) {
        const double g = std::exp(-(i * i + j * j) / (2 * sigma * sigma));
        double weight = order == 1 ? -i * g : (i * i / (sigma * sigma) - 1) * g;
        weight /= weight > 0 ? positive : negative;
        response[0] += weight * (at(x + i, y + j)[0] + 16) / 116;
        response[1] += weight * (at(x + j, y + i)[0] + 16) / 116;
      }
    }
    return std::sqrt(response[0] * response[0] + response[1] * response[1]);
  }
};

std::vector<double> literal_flip(const RgbImage& image, const RgbImage& reference, double ppd) {
  const Literal p(image), r(reference);
  std::vector<double> map;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const double colour =
          colour_error(colour_distance(p.perceived(x, y, ppd), r.perceived(x, y, ppd)));
      const double edge = std::abs(p.feature(x, y, ppd, 1) - r.feature(x, y, ppd, 1));
      const double point = std::abs(p.feature(x, y, ppd, 2) - r.feature(x, y, ppd, 2));
      const double feature = std::pow(std::max(edge, point) / std::sqrt(2.0), 0.5);
      map.push_back(std::pow(colour, 1 - feature));
    }
  }
  return map;
}

RgbImage random_picture(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  RgbImage image{width, height, {}};
  for (int i = 0; i < 3 * width * height; ++i) image.rgb.push_back(float(random() >> 8) * 0x1p-24f);
  return image;
}

// ---- tests -------------------------------------------------------------------------------------

TEST(Flip, EqualPicturesAreZero) {
  const RgbImage picture = random_picture(30, 20, 1);
  for (const float value : flip_map(picture, picture)) EXPECT_EQ(value, 0.0f);
}

TEST(Flip, BlackAgainstWhite) {
  // Constant pictures have no edges or points, and the filters do not change them. The lightness
  // differs by 100 and the chroma by 0, so the colour error is 100^0.7 = 25.1189.
  //
  // FLIP maps this error to [0, 1] relative to the largest possible error, which is that between
  // green and blue. Their L*a*b* values are (87.7355, -86.1816, 83.1866) and (32.3009, 79.1953,
  // -107.8555). After Hunt's adjustment (a and b times L / 100) their distance (the difference in L
  // plus the distance in a and b) is 203.3050, so the largest error is 203.3050^0.7 = 41.2766. The
  // mapping has a knee at 0.4 of this, 16.5106. Our error is above the knee, so the result is
  // 0.95 + 0.05 (25.1189 - 16.5106) / (41.2766 - 16.5106) = 0.967379.
  const double expected = colour_error(100.0);
  EXPECT_NEAR(expected, 0.967379, 1e-6);
  const std::vector<float> map =
      flip_map(constant_picture(40, 30, 0, 0, 0), constant_picture(40, 30, 1, 1, 1));
  for (const float value : map) ASSERT_NEAR(double(value), expected, 1e-5);
}

TEST(Flip, GreenAgainstBlueIsTheWorst) {
  EXPECT_NEAR(mean(flip_map(constant_picture(9, 9, 0, 1, 0), constant_picture(9, 9, 0, 0, 1))), 1.0,
              1e-5);
}

TEST(Flip, ConstantColours) {
  const std::array<std::array<float, 3>, 4> colours = {
      {{0.2f, 0.5f, 0.9f}, {0.21f, 0.5f, 0.9f}, {1, 0, 0}, {0.02f, 0.02f, 0.01f}}};
  for (const auto& a : colours) {
    for (const auto& b : colours) {
      const auto lab = [](const std::array<float, 3>& c) {
        return hunt_lab({decode(double(c[0])), decode(double(c[1])), decode(double(c[2]))});
      };
      const double expected = colour_error(colour_distance(lab(a), lab(b)));
      EXPECT_NEAR(mean(flip_map(constant_picture(7, 5, a[0], a[1], a[2]),
                                constant_picture(7, 5, b[0], b[1], b[2]))),
                  expected, 2e-4);
    }
  }
}

TEST(Flip, AgreesWithThePaperTakenLiterally) {
  struct Case {
    int width, height;
    double pixels_per_degree;
  };
  for (const Case& c :
       {Case{26, 22, 67.0}, Case{1, 1, 67.0}, Case{40, 3, 30.0}, Case{12, 9, 110.0}}) {
    const RgbImage reference = random_picture(c.width, c.height, 2);
    RgbImage picture = reference;  // equal in one half, different in the other
    const RgbImage other = random_picture(c.width, c.height, 3);
    for (size_t i = 0; i < picture.rgb.size(); ++i) {
      const float share = i < picture.rgb.size() / 2 ? 0.05f : 1.0f;
      picture.rgb[i] += share * (other.rgb[i] - picture.rgb[i]);
    }
    const std::vector<float> map = flip_map(picture, reference, c.pixels_per_degree);
    const std::vector<double> expected = literal_flip(picture, reference, c.pixels_per_degree);
    for (size_t i = 0; i < map.size(); ++i) {
      ASSERT_NEAR(double(map[i]), expected[i], 1e-4)
          << "pixel " << i << " of " << c.width << "x" << c.height;
    }
  }
}

TEST(Flip, IsSymmetricAndInRange) {
  const RgbImage a = random_picture(31, 24, 4), b = random_picture(31, 24, 5);
  const std::vector<float> ab = flip_map(a, b), ba = flip_map(b, a);
  EXPECT_EQ(ab, ba);
  for (const float value : ab) {
    EXPECT_GE(value, 0.0f);
    EXPECT_LE(value, 1.0f);
  }
}

TEST(Flip, EdgesCountMoreThanTheirColour) {
  // The step in grey is the same, once as a flat difference and once as an edge in only one
  // picture.
  const RgbImage grey = constant_picture(40, 40, 0.5f, 0.5f, 0.5f);
  RgbImage flat = constant_picture(40, 40, 0.6f, 0.6f, 0.6f), edge = flat;
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 20; ++x) {
      for (int c = 0; c < 3; ++c) edge.rgb[size_t(3 * (y * 40 + x) + c)] = 0.5f;
    }
  }
  const size_t beside = 20 * 40 + 22;  // two pixels into the brighter half
  EXPECT_GT(flip_map(edge, grey)[beside], flip_map(flat, grey)[beside] * 1.05f);
}

}  // namespace
}  // namespace emberline
