// Tests the parameters of a material's layers at a point.
#include <gtest/gtest.h>

#include "renderer/core/constants.h"
#include "renderer/shading/material.h"
#include "support/material_values.h"

namespace emberline {
namespace {

using namespace test;

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
  return evaluated_layers(set[0], at(u, v), .5f);
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

TEST(MaterialLayers, UsesFactorsWithoutATexture) {
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

// Every slot has its own image, so that the test notices a swapped channel or slot.
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
  // The image is black on the left and white on the right, without interpolation between them.
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
    layers = evaluated_layers(set[0], a, .5f);
    EXPECT_EQ(layers.parameters.clearcoat, u < .5f ? 0 : 1);
    EXPECT_EQ(layers.parameters.sheen_color, Rgb(1));  // shifted by half the image
  }
}

TEST(MaterialLayers, DirectionsAreTurnedCounterClockwise) {
  MaterialDescription d;
  d.anisotropy = 1;
  d.anisotropy_texture.image = 0;
  d.anisotropy_rotation = kPi / 2;
  // The texture's direction is up, and the rotation makes it left.
  LayerParameters p = layers_of(d, {byte_image(1, 1, 3, {128, 255, 255})}).parameters;
  EXPECT_NEAR(p.anisotropy_direction.x, -1, 1e-4);
  EXPECT_NEAR(p.anisotropy_direction.y, 0, 5e-3);
  // A zero direction falls back to the rotated tangent.
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

TEST(MaterialLayers, LayersWithoutEffectAreDropped) {
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
  MaterialDescription metal = d;  // transmits nothing
  metal.diffuse_transmission = 1;
  compiled(metal, expect_nothing);
  MaterialDescription thin = d;  // a film of zero thickness
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

}  // namespace
}  // namespace emberline
