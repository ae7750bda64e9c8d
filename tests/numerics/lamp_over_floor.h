// A white floor, objects above it, and the irradiance that the floor must show.
#pragma once

#include <functional>
#include <string>

#include "receiver.h"

namespace emberline::test {

// Compares the irradiance E of the floor at (.3, 0, .1) with `exact`. `tolerance` is relative. The
// floor is at y = 0 and its radiance is E / pi. max_depth is 1, since passing a clear wall does not
// count as an event.
inline void expect_irradiance_at(const char* number, const SceneBuilderForTests& b, double exact,
                                 double tolerance, const std::string& what) {
  const auto scene = b.build();
  const struct {
    int light_samples;
    uint32_t spp;
    const char* name;
  } estimators[] = {{1, 1024, ""},
                    {3, 512, ", three light samples"},
                    {0, long_or_short(4096u, 1024u), ", BSDF sampling alone"}};
  for (const auto& e : estimators) {
    // BSDF sampling cannot hit a point light.
    if (e.light_samples == 0 && !b.description.lights.empty()) continue;
    const CaseName name{number, what + e.name};
    RenderSettings s = direct_light_settings(e.spp);
    s.light_samples = e.light_samples;
    s.seed = seed_of(name);
    const auto view = orthographic({.3, .5, .1}, {.3, 0, .1}, 1e-4);
    expect_case(name, measured_irradiance(render(*scene, view, s), exact, tolerance * exact),
                replay(s));
  }
}

inline SceneBuilderForTests white_floor() {
  SceneBuilderForTests b;
  b.add_floor(.5f, 0, b.add_material(lambert(Rgb(1.0f))));
  return b;
}

// Adds a lamp of 0.2 x 0.2 and radiance 50 at (1.3, 2, .1). From (.3, 0, .1) it is seen at 27
// degrees from the vertical. In lamp_irradiance, the transmittance between them depends on the
// cosine of that angle, which is the same at the floor and at the lamp.
inline void add_lamp(SceneBuilderForTests& b, const MaterialDescription& m = emitter(Rgb(50.0f))) {
  b.add_quad({1.2f, 2, 0}, {1.4f, 2, 0}, {1.4f, 2, .2f}, {1.2f, 2, .2f}, b.add_material(m));
}

inline double lamp_irradiance(const std::function<double(double)>& transmittance) {
  double sum = 0;
  constexpr int kSteps = 200;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      const Vec3d to(1 + .2 * ((i + .5) / kSteps - .5), 2, .2 * ((j + .5) / kSteps - .5));
      const double cosine = to.y / to.length();
      sum += square(cosine) / to.length2() * transmittance(cosine);
    }
  }
  return 50 * square(.2 / kSteps) * sum;
}

}  // namespace emberline::test
