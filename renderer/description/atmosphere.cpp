#include "renderer/description/atmosphere.h"

#include <cmath>

#include "renderer/core/constants.h"

namespace emberline::atmosphere {
namespace {

constexpr double kFirstWavelength = 380, kWavelengthStep = 20;  // nm

// kSun is the sun's irradiance outside the atmosphere in W/m^2/nm, after ASTM G-173 (E-490). kOzone
// is the absorption cross-section of ozone at 233 K in 1e-26 m^2, after V. Gorshelev, A.
// Serdyuchenko et al., "High spectral resolution ozone absorption cross-sections" (2014).
constexpr std::array<double, kBands> kSun = {1.0798, 1.7291, 1.6506, 1.9734, 2.0213, 1.9459,
                                             1.8733, 1.8808, 1.8509, 1.8343, 1.7981, 1.7249,
                                             1.6642, 1.5631, 1.5338, 1.4611};
constexpr std::array<double, kBands> kOzone = {0.0473, 0.2145, 0.6986, 1.949, 4.2965, 8.384,
                                               15.41,  24.47,  32.955, 44.69, 45.495, 46.62,
                                               34.775, 24.5,   16.625, 10.757};

// Peak density of ozone in molecules/m^3. The total is 300 Dobson units of 2.687e20 molecules/m^2,
// which is as much ozone as in a layer 15 km thick at the peak density.
constexpr double kOzoneMolecules = 300 * 2.687e20 / 15e3;

// The colour matching functions of the CIE 1931 observer, by the multi-lobe fit of C. Wyman, P.-P.
// Sloan, P. Shirley, "Simple Analytic Approximations to the CIE XYZ Color Matching Functions" (JCGT
// 2013).
Vec3d cie_1931(double nm) {
  const auto lobe = [nm](double mean, double below, double above) {
    const double t = (nm - mean) / (nm < mean ? below : above);
    return std::exp(-0.5 * t * t);
  };
  return {1.056 * lobe(599.8, 37.9, 31.0) + 0.362 * lobe(442.0, 16.0, 26.7) -
              0.065 * lobe(501.1, 20.4, 26.2),
          0.821 * lobe(568.8, 46.9, 40.5) + 0.286 * lobe(530.9, 16.3, 31.1),
          1.217 * lobe(437.0, 11.8, 36.0) + 0.681 * lobe(459.0, 26.0, 13.8)};
}

// Uses the matrix of IEC 61966-2-1, annex F.
Vec3d rec709_of_xyz(const Vec3d& xyz) {
  return {3.2406 * xyz.x - 1.5372 * xyz.y - 0.4986 * xyz.z,
          -0.9689 * xyz.x + 1.8758 * xyz.y + 0.0415 * xyz.z,
          0.0557 * xyz.x - 0.2040 * xyz.y + 1.0570 * xyz.z};
}

// Returns for each band the Rec. 709 colour, in cd/m^2, of light whose spectral radiance has the
// values of kSun.
std::array<Vec3d, kBands> make_colours() {
  constexpr double kLumensPerWatt = 683;
  std::array<Vec3d, kBands> colours;
  for (size_t b = 0; b < kBands; ++b) {
    Vec3d sum(0.0);
    for (double nm = 0.5; nm < kWavelengthStep; ++nm)
      sum += cie_1931(kFirstWavelength + kWavelengthStep * double(b) + nm);
    colours[b] = rec709_of_xyz(sum * (kLumensPerWatt * kSun[b]));
  }
  return colours;
}

}  // namespace

// Returns the values of E. Bruneton, F. Neyret, "Precomputed Atmospheric Scattering" (EGSR 2008),
// section 2.1. The values for air are from their table; those for haze are from the clear sky of
// their program. Ozone follows E. Bruneton, "A Qualitative and Quantitative Evaluation of 8 Clear
// Sky Models" (TVCG 2017).
const Coefficients& coefficients() {
  static const Coefficients kEarth = [] {
    Coefficients c{};
    for (size_t b = 0; b < kBands; ++b) {
      const double micrometres = (kFirstWavelength + kWavelengthStep * (double(b) + 0.5)) * 1e-3;
      c.rayleigh[b] = float(1.24062e-6 / std::pow(micrometres, 4));
      c.ozone[b] = float(kOzone[b] * 1e-26 * kOzoneMolecules);
    }
    c.haze_scattering = 2e-5f;
    c.haze_extinction = 2e-5f / 0.9f;
    return c;
  }();
  return kEarth;
}

Density density(double height) {
  const double h = std::max(height, 0.0);
  return {std::exp(-h / 8000), std::exp(-h / 1200), std::max(0.0, 1 - std::abs(h - 25e3) / 15e3)};
}

double rayleigh_phase(double cosine) { return 3 / (16 * kPiD) * (1 + cosine * cosine); }

// Uses the phase function of L. Henyey, J. Greenstein, "Diffuse radiation in the galaxy" (1941).
double haze_phase(double cosine) {
  constexpr double kAsymmetry = 0.76;
  const double t = 1 + kAsymmetry * kAsymmetry - 2 * kAsymmetry * cosine;
  return (1 - kAsymmetry * kAsymmetry) / (4 * kPiD * t * std::sqrt(t));
}

Vec3d to_rgb(const Spectrum& relative_to_sun) {
  static const std::array<Vec3d, kBands> kColours = make_colours();
  Vec3d rgb(0.0);
  for (size_t b = 0; b < kBands; ++b) rgb += kColours[b] * double(relative_to_sun[b]);
  return rgb;
}

}  // namespace emberline::atmosphere
