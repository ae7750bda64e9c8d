#include "renderer/shading/material.h"

#include <gtest/gtest.h>

#include <cmath>

#include "renderer/core/constants.h"
#include "renderer/core/errors.h"
#include "renderer/shading/lobes/transmission_lobe.h"
#include "support/material_values.h"

namespace emberline {
namespace {

using namespace test;

TEST(Material, DefaultIsTheOneOfGltf) {
  const MaterialSet set{SceneDescription{}};
  EXPECT_EQ(set.size(), 0u);
  EXPECT_TRUE(set.features().empty());
  EXPECT_EQ(set.texture_bytes(), 0u);
  const Material& m = set[-1];
  EXPECT_FALSE(m.needs_uv() || m.is_emissive() || m.has_normal_map() || m.unlit() ||
               m.double_sided() || m.has_alpha(true));
  MaterialPoint p = evaluated(m, SurfaceAttributes{}, .5f);
  EXPECT_FALSE(m.has_layers() || m.needs_tangents() || m.is_transmissive());
  EXPECT_EQ(p.bsdf.base_color, Rgb(1));
  EXPECT_EQ(p.bsdf.specular_color, Rgb(1));
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
  MaterialPoint p = evaluated(m, a, .3f);
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

// Slots have their own UV parametrisation or share one. Each slot gets the same texel as its
// texture would alone. Normals are filtered.
TEST(Material, EachSlotUsesItsOwnTextureCoordinates) {
  const auto noise = [](int size, int channels) {
    std::vector<uint8_t> bytes(size_t(size * size * channels));
    for (size_t i = 0; i < bytes.size(); ++i) bytes[i] = uint8_t(i * 2654435761u >> 13);
    return byte_image(size, size, channels, bytes);
  };
  SceneDescription scene;
  scene.images = {noise(8, 4), noise(8, 3), noise(4, 3)};
  MaterialDescription d;
  d.base_color_texture = {.image = 0};
  d.metallic_roughness_texture = {.image = 1};
  d.emission = Rgb(1);
  d.normal_texture = {.image = 2};
  scene.materials.assign(6, d);
  scene.materials[1].metallic_roughness_texture.wrap_s = WrapMode::kMirroredRepeat;
  scene.materials[2].metallic_roughness_texture.wrap_t = WrapMode::kClampToEdge;
  scene.materials[3].metallic_roughness_texture.nearest = true;
  scene.materials[4].metallic_roughness_texture.uv_set = 1;
  scene.materials[5].metallic_roughness_texture.uv_transform = {2, .5f, .1f, 0, 1.5f, .3f};
  const MaterialSet set(scene);
  const Texture base(scene.images[0], d.base_color_texture, true);
  const Texture normal(scene.images[2], d.normal_texture, false);
  for (size_t i = 0; i < scene.materials.size(); ++i) {
    const TextureRef& ref = scene.materials[i].metallic_roughness_texture;
    const Texture other(scene.images[1], ref, false);
    int apart = 0;
    for (int k = 0; k < 200; ++k) {
      SurfaceAttributes a = at(.37f * float(k) - 9, .23f * float(k) - 5);
      a.uv[1] = Vec2f(.19f * float(k), -.41f * float(k));
      const float u = (float(k) + .5f) / 200;
      const MaterialPoint p = evaluated(set[int(i)], a, u);
      const Vec4f color = base.lookup(a.uv[0], u);
      const Vec4f rough = other.lookup(a.uv[size_t(ref.uv_set)], u);
      EXPECT_EQ(p.bsdf.base_color, Rgb(color.x, color.y, color.z)) << i << " " << k;
      EXPECT_EQ(p.bsdf.roughness, rough.y) << i << " " << k;
      EXPECT_EQ(p.bsdf.metallic, rough.z) << i << " " << k;
      const Vec4f bump = normal.bilinear(a.uv[0]);
      const Vec3f n = fma(Vec3f(bump.x, bump.y, bump.z), 2.0f, Vec3f(-1.0f));
      EXPECT_NEAR((p.normal - normalize(n)).length(), 0, 1e-6) << i << " " << k;
      const Texture plain(scene.images[1], d.metallic_roughness_texture, false);
      apart += plain.lookup(a.uv[0], u).y != rough.y;
    }
    EXPECT_EQ(apart > 0, i > 0) << i;
  }
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
  EXPECT_EQ(set.features().front(), "textures (2 images)");
  EXPECT_EQ(set.texture_bytes(), 64u + 12u);
  EXPECT_GE(set.bytes(), set.texture_bytes());
  // After the set is moved, materials still find their textures.
  MaterialSet a(scene);
  const MaterialSet b = std::move(a);
  MaterialPoint p = evaluated(b[2], at(.5f, .5f), .5f);
  EXPECT_NEAR(p.bsdf.roughness, 9 / 255.f, 1e-6);
}

TEST(Material, CoverageFollowsTheAlphaMode) {
  SceneDescription scene;
  // The first image has alpha 0 and 255 next to each other. The second image is opaque.
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
  // The filtered alpha crosses the cutoff halfway between the texel centres, for any random number.
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

TEST(Material, UnlitShowsItsColourButEmitsNoLight) {
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
  MaterialPoint p = evaluated(set[0], a, 0);
  EXPECT_EQ(p.emission, d.base_color);
}

TEST(Material, TransmissionTextureIsReadOnlyIfNeeded) {
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
  MaterialPoint p = evaluated(set[0], at(0, 0), .5f);
  EXPECT_NEAR(p.bsdf.transmission, .1f, 1e-6);
  EXPECT_FALSE(p.bsdf.thin_walled);
  const Rgb passed = beer_transmittance(set[0].attenuation(), 1);
  EXPECT_NEAR(passed.x, .5f, 1e-6);
  EXPECT_EQ(passed.y, 1);
  EXPECT_NEAR(passed.z, 1e-3f, 1e-6);
  p = evaluated(set[1], at(0, 0), .5f);
  EXPECT_EQ(p.bsdf.transmission, 0);
}

TEST(Material, DirectionsInTangentSpaceNeedTangents) {
  SceneDescription scene;
  scene.images = {byte_image(1, 1, 3, {128, 128, 255})};
  MaterialDescription brushed, coated, bumpy, plain;
  brushed.anisotropy = .1f;
  coated.clearcoat = .1f;
  coated.clearcoat_normal_texture.image = 0;
  bumpy.normal_texture.image = 0;
  plain.clearcoat = 1;
  scene.materials = {brushed, coated, bumpy, plain};
  const MaterialSet set(scene);
  for (int i = 0; i < 3; ++i)
    EXPECT_TRUE(set[i].needs_tangents() && set[i].reads_attributes(false));
  EXPECT_FALSE(set[3].needs_tangents() || set[3].reads_attributes(false));
}

TEST(Material, GlossinessIsOneMinusRoughness) {
  SceneDescription scene;
  scene.images = {byte_image(1, 1, 4, {188, 255, 0, 51})};
  MaterialDescription glossy;
  glossy.metallic = 0;
  glossy.ior = 0;
  glossy.roughness = .25f;
  glossy.specular_color = Rgb(.5f, .25f, 1);
  glossy.specular_color_texture.image = glossy.glossiness_texture.image = 0;
  MaterialDescription rough = glossy;
  rough.roughness = 1;
  scene.materials = {glossy, rough};
  const MaterialSet set(scene);
  MaterialPoint p = evaluated(set[0], at(.5f, .5f), .5f);
  EXPECT_NEAR(p.bsdf.roughness, 1 - .75f * .2f, 1e-6);
  const float srgb_188 = std::pow((188 / 255.f + .055f) / 1.055f, 2.4f);
  EXPECT_NEAR((p.bsdf.specular_color - Rgb(.5f * srgb_188, .25f, 0)).length(), 0, 1e-6);
  EXPECT_EQ(p.bsdf.ior, 0);
  p = evaluated(set[1], at(.5f, .5f), .5f);
  EXPECT_EQ(p.bsdf.roughness, 1);
}

TEST(Material, DispersionNeedsRefraction) {
  SceneDescription scene;
  MaterialDescription gem;
  gem.metallic = 0;
  gem.transmission = 1;
  gem.thin_walled = false;
  gem.dispersion = .36f;
  MaterialDescription pane = gem, opaque = gem, mirror = gem, leaf = gem;
  pane.thin_walled = true;
  opaque.transmission = 0;
  mirror.ior = 0;
  leaf.transmission = 0;
  leaf.diffuse_transmission = 1;
  leaf.attenuation_color = Rgb(.5f);
  leaf.attenuation_distance = 1;
  scene.materials = {gem, pane, opaque, mirror, leaf};
  const MaterialSet set(scene);
  EXPECT_EQ(set[0].dispersion(), .36f);
  for (int i = 1; i < 5; ++i) EXPECT_EQ(set[i].dispersion(), 0) << i;
  // Diffusely transmitted light is also absorbed in the interior.
  EXPECT_TRUE(set[4].is_transmissive() && set[4].has_diffuse_transmission());
  EXPECT_FALSE(set[4].has_transmission());
  EXPECT_NEAR(beer_transmittance(set[4].attenuation(), 1).x, .5f, 1e-6);
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
    d.dispersion = d.specular_color.x = x;
    d.anisotropy = d.anisotropy_rotation = d.iridescence = d.iridescence_ior = x;
    d.iridescence_thickness_minimum = d.iridescence_thickness_maximum = x;
    d.diffuse_transmission = d.sheen_roughness = d.clearcoat = d.clearcoat_roughness = x;
    d.clearcoat_normal_scale = x;
    d.diffuse_transmission_color = d.sheen_color = Rgb(x);
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
      MaterialPoint p = evaluated(set[i], a, .5f);
      for (const float v : {p.bsdf.base_color.x, p.bsdf.metallic, p.bsdf.roughness, p.bsdf.specular,
                            1 / (p.bsdf.ior + 1), set[i].coverage(a, .5f)})
        EXPECT_TRUE(v >= 0 && v <= 1) << i << " " << c;
      EXPECT_TRUE(is_finite(p.emission) && is_finite(set[i].attenuation()));
      EXPECT_TRUE(p.bsdf.transmission >= 0 && p.bsdf.transmission <= 1);
      EXPECT_TRUE(is_finite(p.bsdf.specular_color) && std::isfinite(set[i].dispersion()));
      MaterialLayers layers = evaluated_layers(set[i], a, .5f);
      const LayerParameters& l = layers.parameters;
      for (const float v : {l.anisotropy, l.iridescence, l.diffuse_transmission, l.sheen_roughness,
                            l.clearcoat, l.clearcoat_roughness, l.sheen_color.x,
                            l.diffuse_transmission_color.x, 1 / l.iridescence_ior})
        EXPECT_TRUE(v >= 0 && v <= 1) << i;
      EXPECT_TRUE(l.iridescence_thickness >= 0 && std::isfinite(l.iridescence_thickness));
      EXPECT_NEAR(l.anisotropy_direction.length(), 1, 1e-5);
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
