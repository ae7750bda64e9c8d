// White furnaces: an object in an environment of radiance 1 shows its directional albedo. This file
// tests mixtures; lobe_furnace_test.cpp tests each lobe alone.
#include "closed_form.h"

#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

// Renders a floor under an environment of radiance 1, seen orthographically at cosine mu. The
// picture's radiance is the albedo at mu.
RenderedImage albedo_of(const MaterialDescription& material, double mu, RenderSettings s) {
  SceneBuilderForTests b;
  b.add_floor(100, 0, b.add_material(material));
  b.set_environment(Rgb(1.0f));
  const auto scene = b.build();
  const double sine = std::sqrt(1 - mu * mu);
  return render(*scene, orthographic({10 * sine, 10 * mu, 0}, {0, 0, 0}, 0.01), s);
}

RenderSettings furnace_settings() {
  RenderSettings s;
  s.width = s.height = 8;
  s.spp = 256;
  s.max_depth = 4;
  return s;
}

class Furnace : public ByGuiding {};

// Mixtures of metal and dielectric keep all energy, whereas other glTF renderers lose some here.
TEST_P(Furnace, IntermediateMetalness) {
  for (const float metallic : {0.25f, 0.5f, 0.75f}) {
    MaterialDescription m;
    m.base_color = Rgb(1.0f);
    m.metallic = metallic;
    m.roughness = 0.6f;
    const RenderSettings s = with_guiding(furnace_settings());
    expect_exact(albedo_of(m, 0.7, s), 1.0, 2e-3, s,
                 name("1", "metallic " + format_value(double(metallic))));
  }
}

// KHR_materials_specular expresses "no reflection" by an index of 1000 and a colour of 0. The index
// alone would reflect everything, and the colour removes all of it except the grazing F90. The base
// is black, so the picture shows only the reflection.
TEST(Reflection, SpecularColorScalesTheReflection) {
  MaterialDescription m;
  m.base_color = Rgb(0.0f);
  m.metallic = 0.0f;
  m.roughness = 0.0f;
  m.ior = 1000.0f;
  const RenderSettings s = furnace_settings();
  for (const float color : {0.0f, 0.5f, 1.0f}) {
    m.specular_color = Rgb(color);
    const double f0 = color * square(999.0 / 1001.0), grazing = std::pow(1 - 0.6, 5.0);
    expect_exact(albedo_of(m, 0.6, s), f0 + (1 - f0) * grazing, 1e-5, s,
                 {"1", "specular colour " + format_value(double(color))});
  }
}

// Light and BSDF sampling together estimate the same integral as BSDF sampling alone.
TEST_P(Furnace, WithAndWithoutLightSampling) {
  MaterialDescription m;
  m.base_color = {0.8f, 0.4f, 0.2f};
  m.metallic = 0.3f;
  m.roughness = 0.4f;
  RenderSettings s = with_guiding(furnace_settings());
  s.spp = 1024;
  const RenderedImage both = albedo_of(m, 0.6, s);
  s.light_samples = 0;
  s.seed = 77;
  const RenderedImage bsdf = albedo_of(m, 0.6, s);
  expect_case(name("1", "light and BSDF sampling against BSDF sampling alone"),
              {bsdf.mean, both.mean, std::hypot(both.standard_error, bsdf.standard_error), 1e-6},
              replay(s));
}

// A white convex object disappears in the furnace, including its silhouette.
TEST_P(Furnace, WhiteSphereDisappears) {
  SceneBuilderForTests b;
  b.place(b.add_mesh(SceneBuilderForTests::sphere(1.0f, 32, b.add_material(metal(Rgb(1.0f), 0.5f)),
                                                  false, false)));
  b.set_environment(Rgb(1.0f));
  const auto scene = b.build();
  RenderSettings s = with_guiding(furnace_settings());
  s.width = s.height = 24;
  const RenderedImage image = render(*scene, perspective({0, 0, 4}, {0, 0, 0}, 40), s);
  expect_exact(image, 1.0, 2e-3, s, name("1", "white sphere"));
}

INSTANTIATE_TEST_SUITE_P(Paths, Furnace, kWithAndWithoutGuiding, guiding_name);

}  // namespace
}  // namespace emberline
