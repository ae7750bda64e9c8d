#include "renderer/shading/material.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "renderer/core/constants.h"
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
  EXPECT_FALSE(m.has_layers() || m.needs_tangents() || m.passes_light());
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

// One texel of (r, g, b, a), in bytes.
std::shared_ptr<const Image> texel(uint8_t r, uint8_t g, uint8_t b, uint8_t a) {
  return byte_image(1, 1, 4, {r, g, b, a});
}

MaterialLayers layers_of(const MaterialDescription& d,
                         std::vector<std::shared_ptr<const Image>> images, float u = .3f,
                         float v = .7f) {
  SceneDescription scene;
  scene.images = std::move(images);
  scene.materials = {d};
  const MaterialSet set(scene);
  EXPECT_TRUE(set[0].has_layers());
  MaterialLayers layers;
  set[0].evaluate_layers(at(u, v), .5f, layers);
  return layers;
}

MaterialDescription layered() {
  MaterialDescription d;
  d.metallic = 0;
  d.anisotropy = .5f;
  d.iridescence = .5f;
  d.iridescence_ior = 1.4f;
  d.diffuse_transmission = .5f;
  d.diffuse_transmission_color = Rgb(.5f, 1, 1);
  d.sheen_color = Rgb(1, .5f, 1);
  d.sheen_roughness = .5f;
  d.clearcoat = .5f;
  d.clearcoat_roughness = .5f;
  return d;
}

TEST(MaterialLayers, FactorsWhereThereIsNoTexture) {
  MaterialDescription d = layered();
  d.anisotropy_rotation = kPi / 2;
  const MaterialLayers layers = layers_of(d, {});
  const LayerParameters& p = layers.parameters;
  EXPECT_EQ(p.anisotropy, .5f);
  EXPECT_NEAR(p.anisotropy_direction.x, 0, 1e-6);
  EXPECT_NEAR(p.anisotropy_direction.y, 1, 1e-6);
  EXPECT_EQ(p.iridescence, .5f);
  EXPECT_EQ(p.iridescence_ior, 1.4f);
  EXPECT_EQ(p.iridescence_thickness, 400);  // the maximum
  EXPECT_EQ(p.diffuse_transmission, .5f);
  EXPECT_EQ(p.diffuse_transmission_color, Rgb(.5f, 1, 1));
  EXPECT_EQ(p.sheen_color, Rgb(1, .5f, 1));
  EXPECT_EQ(p.sheen_roughness, .5f);
  EXPECT_EQ(p.clearcoat, .5f);
  EXPECT_EQ(p.clearcoat_roughness, .5f);
  EXPECT_FALSE(layers.has_clearcoat_normal_map);
}

// Every slot has an image of its own, so that a channel or a slot in another's place shows.
TEST(MaterialLayers, FactorsTimesTheirChannels) {
  MaterialDescription d = layered();
  d.clearcoat_normal_scale = .5f;
  TextureRef* const slots[] = {&d.anisotropy_texture,
                               &d.iridescence_texture,
                               &d.iridescence_thickness_texture,
                               &d.diffuse_transmission_texture,
                               &d.diffuse_transmission_color_texture,
                               &d.sheen_color_texture,
                               &d.sheen_roughness_texture,
                               &d.clearcoat_texture,
                               &d.clearcoat_roughness_texture,
                               &d.clearcoat_normal_texture};
  for (int i = 0; i < int(std::size(slots)); ++i) slots[i]->image = i;
  const MaterialLayers layers = layers_of(
      d, {texel(255, 255, 51, 7), texel(51, 7, 7, 7), texel(7, 51, 7, 7), texel(7, 7, 7, 51),
          texel(255, 188, 0, 7), texel(188, 255, 0, 7), texel(7, 7, 7, 51), texel(51, 7, 7, 7),
          texel(7, 51, 7, 7), texel(128, 255, 255, 7)});
  const LayerParameters& p = layers.parameters;
  const float srgb_188 = std::pow((188 / 255.f + .055f) / 1.055f, 2.4f);
  EXPECT_NEAR(p.anisotropy, .1f, 1e-6);
  EXPECT_NEAR(p.anisotropy_direction.x, std::sqrt(.5f), 1e-6);
  EXPECT_NEAR(p.anisotropy_direction.y, std::sqrt(.5f), 1e-6);
  EXPECT_NEAR(p.iridescence, .1f, 1e-6);
  EXPECT_NEAR(p.iridescence_thickness, 160, 1e-3);  // 100 + 0.2 (400 - 100)
  EXPECT_NEAR(p.diffuse_transmission, .1f, 1e-6);
  EXPECT_NEAR((p.diffuse_transmission_color - Rgb(.5f, srgb_188, 0)).length(), 0, 1e-6);
  EXPECT_NEAR((p.sheen_color - Rgb(srgb_188, .5f, 0)).length(), 0, 1e-6);
  EXPECT_NEAR(p.sheen_roughness, .1f, 1e-6);
  EXPECT_NEAR(p.clearcoat, .1f, 1e-6);
  EXPECT_NEAR(p.clearcoat_roughness, .1f, 1e-6);
  EXPECT_TRUE(layers.has_clearcoat_normal_map);
  const Vec3f want = normalize(Vec3f(.5f / 255, .5f, 1));
  EXPECT_NEAR((p.clearcoat_normal - want).length(), 0, 1e-6);
}

TEST(MaterialLayers, SlotsHaveTheirOwnCoordinates) {
  // Left black, right white, without alpha between them.
  const auto halves = byte_image(2, 1, 1, {0, 255});
  MaterialDescription d;
  d.clearcoat = 1;
  d.sheen_color = Rgb(1);
  d.clearcoat_texture = {.image = 0, .uv_set = 2, .nearest = true};
  d.sheen_color_texture = {
      .image = 0, .uv_set = 3, .nearest = true, .uv_transform = {1, 0, .5f, 0, 1, 0}};
  SceneDescription scene;
  scene.images = {halves};
  scene.materials = {d};
  const MaterialSet set(scene);
  EXPECT_EQ(set[0].uv_mask(), 0b1100u);
  SurfaceAttributes a;
  MaterialLayers layers;
  for (const float u : {.25f, .75f}) {
    a.uv[2] = Vec2f(u, .5f);
    a.uv[3] = Vec2f(.25f, .5f);
    set[0].evaluate_layers(a, .5f, layers);
    EXPECT_EQ(layers.parameters.clearcoat, u < .5f ? 0 : 1);
    EXPECT_EQ(layers.parameters.sheen_color, Rgb(1));  // moved by half the image
  }
}

TEST(MaterialLayers, DirectionsAreTurnedCounterClockwise) {
  MaterialDescription d;
  d.anisotropy = 1;
  d.anisotropy_texture.image = 0;
  d.anisotropy_rotation = kPi / 2;
  // Up becomes left.
  LayerParameters p = layers_of(d, {byte_image(1, 1, 3, {128, 255, 255})}).parameters;
  EXPECT_NEAR(p.anisotropy_direction.x, -1, 1e-4);
  EXPECT_NEAR(p.anisotropy_direction.y, 0, 5e-3);
  // No direction at all is the tangent's, turned.
  auto none = std::make_shared<Image>();
  none->width = none->height = 1;
  none->channels = 3;
  none->type = TexelType::kFloat;
  const std::array<float, 3> texel = {.5f, .5f, .25f};
  none->texels.resize(sizeof(texel));
  std::memcpy(none->texels.data(), texel.data(), sizeof(texel));
  p = layers_of(d, {none}).parameters;
  EXPECT_EQ(p.anisotropy, .25f);
  EXPECT_NEAR(p.anisotropy_direction.x, 0, 1e-6);
  EXPECT_NEAR(p.anisotropy_direction.y, 1, 1e-6);
}

TEST(MaterialLayers, WhatHasNoEffectIsNotKept) {
  MaterialDescription d;
  for (TextureRef* slot :
       {&d.anisotropy_texture, &d.iridescence_texture, &d.iridescence_thickness_texture,
        &d.diffuse_transmission_texture, &d.diffuse_transmission_color_texture,
        &d.sheen_color_texture, &d.sheen_roughness_texture, &d.clearcoat_texture,
        &d.clearcoat_roughness_texture, &d.clearcoat_normal_texture}) {
    slot->image = 0;
  }
  const auto compiled = [](const MaterialDescription& material, const auto& look) {
    SceneDescription scene;
    scene.images = {byte_image(1, 1, 4, {9, 9, 9, 9})};
    scene.materials = {material};
    look(MaterialSet(scene));
  };
  const auto expect_nothing = [](const MaterialSet& set) {
    EXPECT_FALSE(set[0].has_layers() || set[0].needs_uv() || set[0].needs_tangents());
    EXPECT_TRUE(set.features().empty());
  };
  compiled(d, expect_nothing);
  MaterialDescription metal = d;  // lets nothing through
  metal.diffuse_transmission = 1;
  compiled(metal, expect_nothing);
  MaterialDescription thin = d;  // a film of no thickness
  thin.iridescence = 1;
  thin.iridescence_thickness_minimum = thin.iridescence_thickness_maximum = 0;
  compiled(thin, expect_nothing);
  MaterialDescription unlit = layered();
  unlit.unlit = true;
  compiled(unlit, [](const MaterialSet& set) { EXPECT_FALSE(set[0].has_layers()); });

  MaterialDescription coat = d;
  coat.clearcoat = 1;
  coat.clearcoat_normal_scale = 0;
  compiled(coat, [](const MaterialSet& set) {
    EXPECT_TRUE(set[0].has_layers() && set[0].needs_uv());
    EXPECT_FALSE(set[0].needs_tangents());
    EXPECT_EQ(set.features(), (std::vector<std::string>{"textures (1 image)", "clear coat"}));
  });
}

TEST(MaterialLayers, AreNamed) {
  SceneDescription scene;
  scene.materials = {layered()};
  EXPECT_EQ(MaterialSet(scene).features(),
            (std::vector<std::string>{"diffuse transmission", "anisotropy", "iridescence", "sheen",
                                      "clear coat"}));
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

TEST(Material, GlossinessIsWhatIsNotRoughness) {
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
  MaterialPoint p;
  set[0].evaluate(at(.5f, .5f), .5f, p);
  EXPECT_NEAR(p.bsdf.roughness, 1 - .75f * .2f, 1e-6);
  const float srgb_188 = std::pow((188 / 255.f + .055f) / 1.055f, 2.4f);
  EXPECT_NEAR((p.bsdf.specular_color - Rgb(.5f * srgb_188, .25f, 0)).length(), 0, 1e-6);
  EXPECT_EQ(p.bsdf.ior, 0);
  set[1].evaluate(at(.5f, .5f), .5f, p);
  EXPECT_EQ(p.bsdf.roughness, 1);
}

TEST(Material, DispersionIsOfWhatBends) {
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
  // Light that is let through diffusely is absorbed within all the same.
  EXPECT_TRUE(set[4].passes_light() && set[4].has_diffuse_transmission());
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
      MaterialPoint p;
      set[i].evaluate(a, .5f, p);
      for (const float v : {p.bsdf.base_color.x, p.bsdf.metallic, p.bsdf.roughness, p.bsdf.specular,
                            1 / (p.bsdf.ior + 1), set[i].coverage(a, .5f)})
        EXPECT_TRUE(v >= 0 && v <= 1) << i << " " << c;
      EXPECT_TRUE(is_finite(p.emission) && is_finite(set[i].attenuation()));
      EXPECT_TRUE(p.bsdf.transmission >= 0 && p.bsdf.transmission <= 1);
      EXPECT_TRUE(is_finite(p.bsdf.specular_color) && std::isfinite(set[i].dispersion()));
      MaterialLayers layers;
      set[i].evaluate_layers(a, .5f, layers);
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
