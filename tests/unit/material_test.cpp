#include "renderer/shading/material.h"

#include <gtest/gtest.h>

#include "renderer/core/errors.h"
#include "renderer/shading/lobes/transmission_lobe.h"

namespace emberline {
namespace {

std::shared_ptr<Image> byte_image(int width, int height, int channels,
                                  std::vector<uint8_t> values) {
  auto image = std::make_shared<Image>();
  image->width = width;
  image->height = height;
  image->channels = channels;
  for (const uint8_t v : values) image->texels.push_back(std::byte(v));
  return image;
}

SurfaceAttributes at(float u, float v) {
  SurfaceAttributes a;
  a.uv.fill(Vec2f(u, v));
  return a;
}

TEST(Material, DefaultIsTheOneOfGltf) {
  const MaterialSet set{SceneDescription{}};
  EXPECT_EQ(set.size(), 0u);
  EXPECT_TRUE(set.features().empty());
  EXPECT_EQ(set.texture_bytes(), 0u);
  const Material& m = set[-1];
  EXPECT_FALSE(m.needs_uv() || m.is_emissive() || m.has_normal_map() || m.unlit() ||
               m.double_sided() || m.has_alpha(true));
  MaterialPoint p;
  m.evaluate(SurfaceAttributes{}, .5f, p);
  EXPECT_EQ(p.bsdf.base_color, Rgb(1));
  EXPECT_EQ(p.bsdf.metallic, 1);
  EXPECT_EQ(p.bsdf.roughness, 1);
  EXPECT_EQ(p.normal, Vec3f(0, 0, 1));
  EXPECT_EQ(p.emission, Rgb(0));
  EXPECT_EQ(m.coverage(SurfaceAttributes{}, .5f), 1);
}

TEST(Material, FactorsTimesTexturesTimesVertexColour) {
  SceneDescription scene;
  scene.images = {byte_image(1, 1, 3, {255, 188, 0}), byte_image(1, 1, 3, {7, 128, 51}),
                  byte_image(1, 1, 3, {128, 255, 255})};
  MaterialDescription d;
  d.base_color = Rgb(.5f, .5f, 1);
  d.base_color_texture.image = 0;
  d.metallic = .5f;
  d.roughness = .8f;
  d.metallic_roughness_texture = {.image = 1, .uv_set = 1};
  d.normal_texture = {.image = 2, .uv_set = 3};
  d.normal_scale = .5f;
  d.emission = Rgb(10, 20, 30);
  d.emission_texture.image = 0;
  d.double_sided = true;
  scene.materials = {d};
  const MaterialSet set(scene);
  const Material& m = set[0];
  EXPECT_EQ(m.uv_mask(), 0b1011u);
  EXPECT_TRUE(m.is_emissive() && m.has_normal_map() && m.double_sided() && m.needs_uv());
  EXPECT_EQ(set.features(), (std::vector<std::string>{"textures (3 images)", "normal maps",
                                                      "emission", "double-sided"}));
  SurfaceAttributes a = at(.3f, .7f);
  a.color = Vec4f(1, .5f, 1, 1);
  a.has_color = true;
  MaterialPoint p;
  m.evaluate(a, .3f, p);
  const float srgb_188 = std::pow((188 / 255.f + .055f) / 1.055f, 2.4f);
  EXPECT_NEAR(p.bsdf.base_color.x, .5f, 1e-6);
  EXPECT_NEAR(p.bsdf.base_color.y, .25f * srgb_188, 1e-6);
  EXPECT_EQ(p.bsdf.base_color.z, 0);
  EXPECT_NEAR(p.bsdf.roughness, .8f * 128 / 255, 1e-6);  // green
  EXPECT_NEAR(p.bsdf.metallic, .5f * .2f, 1e-6);         // blue
  EXPECT_NEAR(p.emission.y, 20 * srgb_188, 1e-4);
  EXPECT_TRUE(p.has_normal_map);
  const Vec3f want = normalize(Vec3f(.5f / 255, .5f, 1));
  EXPECT_NEAR((p.normal - want).length(), 0, 1e-6);
  EXPECT_NEAR(m.mean_emission(a, a, a).y, p.emission.y, 1e-4);
  EXPECT_NEAR(m.emission(a, .3f).y, p.emission.y, 1e-6);
}

TEST(Material, SharesTexturesAndCountsImagesOnce) {
  SceneDescription scene;
  scene.images = {byte_image(4, 4, 4, std::vector<uint8_t>(64, 200)),
                  byte_image(2, 2, 3, std::vector<uint8_t>(12, 9)),
                  byte_image(64, 64, 3, std::vector<uint8_t>(64 * 64 * 3, 9))};  // never used
  for (int i = 0; i < 3; ++i) {
    MaterialDescription d;
    d.base_color_texture.image = 0;
    d.metallic_roughness_texture.image = i == 2 ? 1 : 0;
    scene.materials.push_back(d);
  }
  const MaterialSet set(scene);
  EXPECT_EQ(set.image_count(), 2u);
  EXPECT_EQ(set.texture_bytes(), 64u + 12u);
  EXPECT_GE(set.bytes(), set.texture_bytes());
  // Moving the set keeps the textures where the materials look for them.
  MaterialSet a(scene);
  const MaterialSet b = std::move(a);
  MaterialPoint p;
  b[2].evaluate(at(.5f, .5f), .5f, p);
  EXPECT_NEAR(p.bsdf.roughness, 9 / 255.f, 1e-6);
}

TEST(Material, CoverageFollowsTheAlphaMode) {
  SceneDescription scene;
  // Alpha 0 and 255 side by side; then an image that is opaque throughout.
  scene.images = {byte_image(2, 1, 4, {255, 255, 255, 0, 255, 255, 255, 255}),
                  byte_image(1, 1, 4, {255, 255, 255, 255})};
  MaterialDescription mask;
  mask.base_color_texture = {
      .image = 0, .wrap_s = WrapMode::kClampToEdge, .wrap_t = WrapMode::kClampToEdge};
  mask.alpha_mode = AlphaMode::kMask;
  MaterialDescription blend = mask;
  blend.alpha_mode = AlphaMode::kBlend;
  blend.alpha = .5f;
  MaterialDescription opaque = mask;
  opaque.alpha_mode = AlphaMode::kOpaque;
  MaterialDescription solid = blend;
  solid.alpha = 1;
  solid.base_color_texture.image = 1;
  MaterialDescription cut = mask;
  cut.base_color_texture.image = -1;
  cut.alpha = .4f;
  scene.materials = {mask, blend, opaque, solid, cut};
  const MaterialSet set(scene);

  EXPECT_TRUE(set[0].has_alpha(false) && set[1].has_alpha(false) && set[4].has_alpha(false));
  EXPECT_FALSE(set[2].has_alpha(true) || set[3].has_alpha(false));
  EXPECT_TRUE(set[3].has_alpha(true));
  EXPECT_EQ(set[4].coverage(at(0, 0), 0), 0);
  // The filtered alpha crosses the cutoff halfway between the texel centres, whatever the number.
  for (const float u_texture : {0.0f, .3f, .99f}) {
    EXPECT_EQ(set[0].coverage(at(.49f, 0), u_texture), 0);
    EXPECT_EQ(set[0].coverage(at(.51f, 0), u_texture), 1);
    EXPECT_EQ(set[2].coverage(at(.1f, 0), u_texture), 1);
    SurfaceAttributes faded = at(.9f, 0);
    faded.color.w = .4f;
    EXPECT_EQ(set[0].coverage(faded, u_texture), 0);
  }
  double sum = 0;
  for (int i = 0; i < 1000; ++i)
    sum += double(set[1].coverage(at(.4f, 0), (float(i) + .5f) / 1000));
  EXPECT_NEAR(sum / 1000, .5 * .3, 2e-3);
}

TEST(Material, UnlitShowsItsColourAndIsNoLight) {
  SceneDescription scene;
  MaterialDescription d;
  d.base_color = Rgb(.2f, .4f, .8f);
  d.emission = Rgb(5);
  d.unlit = true;
  scene.materials = {d};
  const MaterialSet set(scene);
  EXPECT_TRUE(set[0].unlit());
  EXPECT_FALSE(set[0].is_emissive());
  const SurfaceAttributes a;
  EXPECT_EQ(set[0].emission(a, 0), d.base_color);
  EXPECT_EQ(set[0].mean_emission(a, a, a), Rgb(0));
  MaterialPoint p;
  set[0].evaluate(a, 0, p);
  EXPECT_EQ(p.emission, d.base_color);
}

TEST(Material, TransmissionIsReadOnlyWhereThereIsAny) {
  SceneDescription scene;
  scene.images = {byte_image(1, 1, 3, {51, 0, 0})};
  MaterialDescription glass;
  glass.metallic = 0;
  glass.transmission = .5f;
  glass.transmission_texture.image = 0;
  glass.thin_walled = false;
  glass.attenuation_color = Rgb(.25f, 1, 0);
  glass.attenuation_distance = 2;
  MaterialDescription metal = glass;
  metal.metallic = 1;
  scene.materials = {glass, metal};
  const MaterialSet set(scene);
  EXPECT_TRUE(set[0].has_transmission());
  EXPECT_FALSE(set[1].has_transmission());
  EXPECT_EQ(set.features(),
            (std::vector<std::string>{"textures (1 image)", "transmission", "absorption"}));
  MaterialPoint p;
  set[0].evaluate(at(0, 0), .5f, p);
  EXPECT_NEAR(p.bsdf.transmission, .1f, 1e-6);
  EXPECT_FALSE(p.bsdf.thin_walled);
  const Rgb passed = beer_transmittance(set[0].attenuation(), 1);
  EXPECT_NEAR(passed.x, .5f, 1e-6);
  EXPECT_EQ(passed.y, 1);
  EXPECT_NEAR(passed.z, 1e-3f, 1e-6);
  set[1].evaluate(at(0, 0), .5f, p);
  EXPECT_EQ(p.bsdf.transmission, 0);
}

TEST(Material, StrangeNumbersAreContained) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  SceneDescription scene;
  for (const float x : {nan, inf, -inf, -1.0f, 1e30f}) {
    MaterialDescription d;
    d.base_color = Rgb(x);
    d.alpha = d.metallic = d.roughness = d.normal_scale = x;
    d.emission = Rgb(x);
    d.ior = d.specular = d.transmission = d.attenuation_distance = x;
    d.attenuation_color = Rgb(x);
    d.thin_walled = false;
    d.alpha_mode = AlphaMode::kBlend;
    d.unlit = x == 1e30f;
    scene.materials.push_back(d);
  }
  const MaterialSet set(scene);
  for (int i = 0; i < 5; ++i) {
    SurfaceAttributes a;
    for (const float c : {nan, inf, -2.0f, 1.0f}) {
      a.color = Vec4f(c, c, c, c);
      a.has_color = true;
      MaterialPoint p;
      set[i].evaluate(a, .5f, p);
      for (const float v : {p.bsdf.base_color.x, p.bsdf.metallic, p.bsdf.roughness, p.bsdf.specular,
                            1 / (p.bsdf.ior + 1), set[i].coverage(a, .5f)})
        EXPECT_TRUE(v >= 0 && v <= 1) << i << " " << c;
      EXPECT_TRUE(is_finite(p.emission) && is_finite(set[i].attenuation()));
      EXPECT_TRUE(p.bsdf.transmission >= 0 && p.bsdf.transmission <= 1);
    }
  }
}

TEST(Material, UvSetsBeyondTheLimitAreRefused) {
  SceneDescription scene;
  scene.file = "a.gltf";
  scene.images = {byte_image(1, 1, 3, {1, 2, 3})};
  MaterialDescription d;
  d.name = "paint";
  d.base_color_texture = {.image = 0, .uv_set = kMaxUvSets};
  scene.materials = {d};
  try {
    const MaterialSet set(scene);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "a.gltf: material \"paint\": its base colour texture uses TEXCOORD_4; sets 0 to 3 "
                 "are supported");
  }
}

}  // namespace
}  // namespace emberline
