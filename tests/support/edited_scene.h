// A scene that has everything that edits can change.
#pragma once

#include "renderer/description/scene_edits.h"
#include "support/float_map.h"
#include "support/scenes.h"

namespace emberline::test {

// Returns a pattern in which neighbouring texels differ in every channel.
inline std::shared_ptr<const Image> patterned_image(int size, int channels, int low = 0) {
  auto image = std::make_shared<Image>();
  image->name = "pattern";
  image->width = image->height = size;
  image->channels = channels;
  for (int i = 0; i < size * size * channels; ++i) {
    image->texels.push_back(std::byte(low + i * 37 % (256 - low)));
  }
  return image;
}

// Returns a sky of floats. Its left half is bright.
inline std::shared_ptr<const Image> patterned_sky(float bright) {
  constexpr int kWidth = 16;
  return float_map(kWidth, 8, [&](int column, int) {
    return Rgb(1.0f, 0.5f, 0.25f) * (column < kWidth / 2 ? bright : 0.1f);
  });
}

// The materials of the scene, by index. Edits refer to them by these indices.
enum EditedMaterial {
  kFloorMaterial,  // has a clear coat, and a normal map with strength 0
  kBallMaterial,   // is a rough metal; its mesh has two instances, one of them mirrored
  kGlassMaterial,  // is clear and single-sided, so it is visible from behind while it transmits
  kShellMaterial,  // is opaque and single-sided, so its open mesh is invisible from behind
  kNeonMaterial,   // has an emissive texture, which is switched off
  kLampMaterial,   // is emissive, and its mesh is flush with the panel
  kPanelMaterial,
  kVeilMaterial,  // is alpha blended
};

inline SceneDescription edited_scene() {
  SceneBuilderForTests b;
  b.description.file = "edited.glb";
  b.description.images = {patterned_image(8, 3), patterned_image(8, 3, 96)};
  const auto add = [&](const char* name, MaterialDescription m) {
    m.name = name;
    return b.add_material(m);
  };
  MaterialDescription coat = lambert({0.7f, 0.5f, 0.3f});
  coat.roughness = 0.3f;
  coat.specular = 1.0f;
  coat.normal_texture.image = 1;
  coat.normal_scale = 0.0f;
  add("floor", coat);
  add("ball", metal({0.9f, 0.6f, 0.3f}, 0.4f));
  MaterialDescription glass = lambert(Rgb(0.9f));
  glass.specular = 1.0f;
  glass.roughness = 0.2f;
  glass.transmission = 1.0f;
  add("glass", glass);
  add("shell", lambert({0.3f, 0.6f, 0.8f}));
  MaterialDescription neon = lambert(Rgb(0.2f));
  neon.emission_texture.image = 0;
  add("neon", neon);
  add("lamp", emitter(Rgb(6.0f)));
  add("lamp", lambert(Rgb(0.5f)));  // the panel, which has the same name as the lamp
  MaterialDescription veil = lambert({0.2f, 0.7f, 0.3f});
  veil.alpha = 0.4f;
  veil.alpha_mode = AlphaMode::kBlend;
  veil.double_sided = true;
  add("veil", veil);

  b.add_floor(4, 0, kFloorMaterial);
  MeshDescription& floor = b.description.meshes.back();
  floor.normals.assign(4, Vec3f(0, 1, 0));
  floor.tangents.assign(4, Vec4f(1, 0, 0, 1));
  const int ball = b.add_mesh(SceneBuilderForTests::sphere(0.4f, 8, kBallMaterial));
  b.place(ball, translation(-1.2, 0.4, 0.6));
  Mat44d mirrored = translation(1.2, 0.4, 0.6);
  mirrored[0][0] = -1;
  b.place(ball, mirrored);
  b.place(b.add_mesh(SceneBuilderForTests::sphere(0.45f, 8, kGlassMaterial, false, true)),
          translation(0.1, 0.45, 1.2));
  b.add_quad({0.4f, 0, -0.6f}, {-0.4f, 0, -0.6f}, {-0.4f, 1, -0.6f}, {0.4f, 1, -0.6f},
             kShellMaterial);  // this quad faces away from the camera
  b.add_quad({-2, 0, -1}, {-1, 0, -1}, {-1, 1, -1}, {-2, 1, -1}, kNeonMaterial);
  b.add_floor(0.3f, 2.5f, kLampMaterial, false);
  b.add_floor(1.5f, 2.5f, kPanelMaterial, false);
  b.add_quad({1, 0, -1}, {2, 0, -1}, {2, 1.2f, -1}, {1, 1.2f, -1}, kVeilMaterial);
  b.add_point_light({2, 3, 1}, {3, 4, 5});
  b.add_point_light({-2, 2, 2}, {2, 1, 1});
  b.description.lights[0].name = b.description.lights[1].name = "spot";
  b.set_environment(patterned_sky(1.5f));
  return b.description;
}

// The material variants of the scene, by index. Most of them change which hits the BVH's filter
// accepts, or which surfaces are lights.
enum EditedVariant {
  kGoldenFloor,
  kVeiledBall,    // the ball, an instanced mesh, gets alpha coverage
  kSolidVeil,     // the veil loses its alpha coverage, and its back becomes invisible
  kSwappedLamps,  // the panel and the ball emit light, and the lamp does not
  kClearShell,    // the shell becomes visible from behind
};

inline void add_variants(SceneDescription& scene) {
  scene.variants = {
      {"golden floor"}, {"veiled ball"}, {"solid veil"}, {"swapped lamps"}, {"clear shell"}};
  scene.variants_read = true;
  // Meshes have the same order as their materials.
  scene.meshes[kFloorMaterial].variant_materials = {{kGoldenFloor, kBallMaterial}};
  scene.meshes[kBallMaterial].variant_materials = {{kVeiledBall, kVeilMaterial},
                                                   {kSwappedLamps, kLampMaterial}};
  scene.meshes[kVeilMaterial].variant_materials = {{kSolidVeil, kFloorMaterial}};
  scene.meshes[kLampMaterial].variant_materials = {{kSwappedLamps, kPanelMaterial}};
  scene.meshes[kPanelMaterial].variant_materials = {{kSwappedLamps, kLampMaterial}};
  scene.meshes[kShellMaterial].variant_materials = {{kClearShell, kGlassMaterial}};
}

// The camera sees all objects, including the lamp in its panel.
inline CameraDescription edited_view() { return perspective({0.3, 1.3, 4.5}, {0, 1, 0}, 45); }

}  // namespace emberline::test
