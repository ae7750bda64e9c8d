#include "renderer/shading/lobes/thin_film.h"

#include <array>

#include "renderer/core/color4.h"
#include "renderer/core/constants.h"
#include "renderer/shading/lobes/colour_matching.h"
#include "renderer/shading/lobes/transmission_lobe.h"

namespace emberline {

namespace {

// Response of each channel to cos(2 pi D / lambda) as a function of the path difference D. It is 1
// at D = 0, then oscillates and decays. The table stores values and slopes at even steps. Lookups
// interpolate cubically between the steps.
constexpr double kStep = 25.0;  // nanometres
constexpr int kSteps = 400;
constexpr int kMaxOrder = 32;

struct Sensitivity {
  struct Node {
    Color4 value;
    Color4 slope;  // per step
  };
  std::array<Node, size_t(kSteps + 1)> nodes;

  Sensitivity() {
    constexpr int kWavelengths = 201;
    std::array<Vec3d, size_t(kWavelengths)> response;
    std::array<double, size_t(kWavelengths)> wave;  // 2 pi / lambda, per step
    Vec3d sum(0.0);
    for (int i = 0; i < kWavelengths; ++i) {
      const double nanometres =
          kFirstNanometre + (kLastNanometre - kFirstNanometre) * i / (kWavelengths - 1);
      response[size_t(i)] = rec709_response(nanometres);
      wave[size_t(i)] = 2 * kPiD * kStep / nanometres;
      sum += response[size_t(i)];
    }
    for (int n = 0; n <= kSteps; ++n) {
      Vec3d value(0.0), slope(0.0);
      for (size_t i = 0; i < size_t(kWavelengths); ++i) {
        value += response[i] * std::cos(wave[i] * n);
        slope -= response[i] * (wave[i] * std::sin(wave[i] * n));
      }
      nodes[size_t(n)] = {color4(to_float(value / sum)), color4(to_float(slope / sum))};
    }
  }

  // Interpolates by a cubic Hermite polynomial. `d` is the path difference in steps, at least 0.
  Color4 at(float d) const {
    const int i = int(d);
    const float t = d - float(i), s = 1.0f - t;
    const Node &a = nodes[size_t(i)], &b = nodes[size_t(i + 1)];
    const float t2s = t * t * s, s2t = s * s * t, second = t * t * fma(2.0f, s, 1.0f);
    return fma(a.value, 1.0f - second,
               fma(b.value, second, fma(a.slope, s2t, b.slope * splat4(-t2s))));
  }
};

const Sensitivity& sensitivity() {
  static const Sensitivity instance;
  return instance;
}

float clamp_unit(float x) { return x > 0.0f ? std::min(x, 1.0f) : 0.0f; }  // 0 for NaN

// Rounding can raise an amplitude above 1 if both interfaces reflect nearly everything.
Color4 clamp_amplitude(Color4 r) {
  const Color4 one = splat4(1.0f);
  r = r < one ? r : one;
  return r > -one ? r : -one;
}
Color4 sqrt4(Color4 c) {
#ifdef __SSE__
  return __builtin_ia32_sqrtps(c);
#else
  return Color4{std::sqrt(c[0]), std::sqrt(c[1]), std::sqrt(c[2]), std::sqrt(c[3])};
#endif
}
float max_abs(Color4 c) {
  return std::max(std::abs(c[0]), std::max(std::abs(c[1]), std::abs(c[2])));
}

// The ranges of the transition in lower_amplitude_of_metals() (see the header). base_f0 goes from
// kDielectric to kMetal. The path difference goes from 0 to kQuarterWave, a quarter of 550 nm in
// units of kStep.
constexpr float kDielectric = 0.1f, kMetal = 0.4f;
constexpr float kQuarterWave = float(137.5 / kStep);

Color4 lower_amplitude_of_metals(Color4 r23, Color4 f0, float film_ior, float cos_t, float path) {
  const float film = (film_ior - 1.0f) / (film_ior + 1.0f), m = 1.0f - cos_t;
  const Color4 root = sqrt4(f0), normal = (root - film) / fma(-root, film, splat4(1.0f));
  const Color4 squared = normal * normal;
  const Color4 schlick = fma(1.0f - squared, square(square(m)) * m, squared);
  const float t = std::min(1.0f, path / kQuarterWave);
  const Color4 metal = (f0 - kDielectric) / (kMetal - kDielectric), zero = {}, one = splat4(1.0f);
  const Color4 share = (metal < zero  ? zero
                        : metal > one ? one
                                      : metal) *
                       (t * t * fma(-2.0f, t, 3.0f));
  const Color4 magnitude = sqrt4(fma(schlick - r23 * r23, share, r23 * r23));
  return r23 < zero ? -magnitude : magnitude;
}

}  // namespace

Rgb thin_film_reflectance(float cos_i, float film_ior, float thickness_nm, const Rgb& base_f0) {
  const float cosine = clamp_unit(cos_i), m = 1.0f - cosine, m2 = square(m);
  const Color4 f0 =
      color4(Rgb(clamp_unit(base_f0.x), clamp_unit(base_f0.y), clamp_unit(base_f0.z)));
  const Color4 base = fma(1.0f - f0, square(m2) * m, f0);
  const bool film = film_ior > 1.0f && thickness_nm > 0.0f;
  const float reflect = film ? fresnel_dielectric(cosine, film_ior) : 0.0f;
  if (!film || !(reflect < 1.0f)) return to_rgb(base);

  const float r12 = std::sqrt(reflect), pass = 1.0f - reflect;
  const float cos_t = safe_sqrt(1.0f - fma(-cosine, cosine, 1.0f) / square(film_ior));
  const float path = 2.0f * film_ior * thickness_nm * cos_t * float(1.0 / kStep);
  const Color4 r13 = sqrt4(base);
  Color4 r23 = clamp_amplitude((r13 - r12) / fma(-r13, r12, splat4(1.0f)));
  if (max_abs(f0) > kDielectric) r23 = lower_amplitude_of_metals(r23, f0, film_ior, cos_t, path);
  // Airy's sum over the orders m: C0 + 2 C (sum of q^m cos(m delta)), where C0 is all + reflect, C
  // is all - pass, and delta is 2 pi path / lambda.
  const Color4 q = r23 * splat4(-r12);
  const Color4 r23_squared = r23 * r23;
  const Color4 all = r23_squared * (square(pass)) / fma(r23_squared, -reflect, splat4(1.0f));
  Color4 sum = all + reflect;
  Color4 term = (all - pass) * splat4(2.0f);
  const Sensitivity& table = sensitivity();
  constexpr float kNegligible = 5e-4f;
  const float ratio = max_abs(q);
  float bound = 2.0f * ratio;  // bound on the next order
  for (int order = 1; order <= kMaxOrder; ++order) {
    const float d = path * float(order);
    if (!(d < float(kSteps))) break;
    term *= q;
    // The last order also accounts for the remaining orders, as a geometric series. This is exact
    // for a film of thickness 0, where every cosine is 1.
    bound *= ratio;
    const bool last = order == kMaxOrder || bound < kNegligible;
    const Color4 scaled = last ? term / (1.0f - q) : term;
    sum = fma(scaled, table.at(d), sum);
    if (last) break;
  }
  return {clamp_unit(sum[0]), clamp_unit(sum[1]), clamp_unit(sum[2])};
}

}  // namespace emberline
