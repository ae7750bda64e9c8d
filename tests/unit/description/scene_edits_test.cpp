// Tests the effects of each edit on a description, and the errors of invalid edits.
#include "renderer/description/scene_edits.h"

#include <gtest/gtest.h>

#include "renderer/core/errors.h"
#include "renderer/description/default_light.h"
#include "renderer/description/framing.h"
#include "renderer/description/material_parameters.h"
#include "renderer/scene/build_scene.h"
#include "support/edited_scene.h"

namespace emberline {
namespace {

using namespace test;

LightEdit light_edit(EditedLight kind, int index) {
  LightEdit edit;
  edit.kind = kind;
  edit.target.index = index;
  return edit;
}

MaterialEdit material_edit(int index) {
  MaterialEdit edit;
  edit.target.index = index;
  return edit;
}

SceneEdits edits_of(const LightEdit& edit) {
  SceneEdits edits;
  edits.lights.push_back(edit);
  return edits;
}

SceneEdits edits_of(const MaterialEdit& edit) {
  SceneEdits edits;
  edits.materials.push_back(edit);
  return edits;
}

SceneDescription edited_by(const SceneEdits& edits) {
  SceneDescription scene = edited_scene();
  apply(edits, scene);
  return scene;
}

std::string rejection_message(const SceneEdits& edits, SceneDescription scene = edited_scene()) {
  try {
    apply(edits, scene);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

void expect_words(const std::string& message, const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    EXPECT_NE(message.find(word), std::string::npos) << word << " is not in: " << message;
  }
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

TEST(SceneEdits, LightsAreScaledTintedAndTurnedOff) {
  LightEdit edit = light_edit(EditedLight::kPunctual, 1);
  edit.intensity = 3.0f;
  edit.color = {1.0f, 0.5f, 0.0f};
  const SceneDescription scaled = edited_by(edits_of(edit));
  EXPECT_EQ(scaled.lights[1].intensity, Rgb(6.0f, 1.5f, 0.0f));  // was (2, 1, 1)
  EXPECT_EQ(scaled.lights[0].intensity, Rgb(3.0f, 4.0f, 5.0f));
  edit.on = false;
  EXPECT_EQ(edited_by(edits_of(edit)).lights[1].intensity, Rgb(0.0f));
}

TEST(SceneEdits, AnEmissiveMaterialIsALight) {
  LightEdit edit = light_edit(EditedLight::kMaterial, kLampMaterial);
  edit.intensity = 0.5f;
  edit.color = {1.0f, 2.0f, 3.0f};
  EXPECT_EQ(edited_by(edits_of(edit)).materials[kLampMaterial].emission, Rgb(3.0f, 6.0f, 9.0f));
  // A light edit scales the result of the material's own edit. A material without emission stays
  // dark.
  SceneEdits both = edits_of(edit);
  both.materials.push_back(material_edit(kLampMaterial));
  both.materials.back().emission = Rgb(1.0f);
  both.lights.push_back(light_edit(EditedLight::kMaterial, kFloorMaterial));
  both.lights.back().intensity = 100.0f;
  const SceneDescription scene = edited_by(both);
  EXPECT_EQ(scene.materials[kLampMaterial].emission, Rgb(0.5f, 1.0f, 1.5f));
  EXPECT_EQ(scene.materials[kFloorMaterial].emission, Rgb(0.0f));
}

TEST(SceneEdits, ABrightnessStaysFinite) {
  LightEdit edit = light_edit(EditedLight::kMaterial, kLampMaterial);
  edit.intensity = 3e38f;
  EXPECT_TRUE(is_finite(edited_by(edits_of(edit)).materials[kLampMaterial].emission));
}

TEST(SceneEdits, TheEnvironmentIsALightAndHasItsOwnValues) {
  SceneEdits edits = edits_of(light_edit(EditedLight::kEnvironment, -1));
  edits.lights[0].intensity = 2.0f;
  edits.lights[0].color = {1.0f, 0.5f, 0.25f};
  edits.environment.strength = 7.0f;
  edits.environment.rotation_degrees = 45.0f;
  edits.environment.file = "other.hdr";
  edits.environment.image = patterned_sky(3.0f);
  edits.environment.repaired_texels = 4;
  const SceneDescription scene = edited_by(edits);
  EXPECT_EQ(scene.environment->tint, Rgb(2.0f, 1.0f, 0.5f));
  EXPECT_EQ(scene.environment->strength, 7.0f);
  EXPECT_EQ(scene.environment->rotation_degrees, 45.0f);
  EXPECT_EQ(scene.environment->file, "other.hdr");
  EXPECT_EQ(scene.environment->image, edits.environment.image);
  EXPECT_EQ(scene.repairs.non_finite_texels, 4u);
}

TEST(SceneEdits, MaterialFactorsAreReplaced) {
  MaterialEdit edit = material_edit(kBallMaterial);
  edit.base_color = Rgb(0.1f, 0.2f, 0.3f);
  edit.roughness = 0.4f;
  edit.metallic = 0.5f;
  edit.transmission = 0.6f;
  edit.normal_scale = -0.7f;
  edit.emission = Rgb(8.0f);
  const SceneDescription scene = edited_by(edits_of(edit));
  const MaterialDescription& m = scene.materials[kBallMaterial];
  EXPECT_EQ(m.base_color, Rgb(0.1f, 0.2f, 0.3f));
  EXPECT_EQ(m.roughness, 0.4f);
  EXPECT_EQ(m.metallic, 0.5f);
  EXPECT_EQ(m.transmission, 0.6f);
  EXPECT_EQ(m.normal_scale, -0.7f);
  EXPECT_EQ(m.emission, Rgb(8.0f));
  // Parameters without an edit stay the same.
  const MaterialDescription untouched =
      edited_by(edits_of(material_edit(kBallMaterial))).materials[kBallMaterial];
  EXPECT_EQ(untouched.roughness, 0.4f);
  EXPECT_EQ(untouched.base_color, Rgb(0.9f, 0.6f, 0.3f));
}

TEST(SceneEdits, EachMaterialParameterIsReplacedIndependently) {
  const MaterialDescription own = edited_by({}).materials[kBallMaterial];
  for (const MaterialParameter& edited : material_parameters()) {
    MaterialEdit edit = material_edit(kBallMaterial);
    if (edited.color) {
      edit.*edited.edited_color = Rgb(0.125f, 0.25f, 0.5f);
    } else {
      edit.*edited.edited_number = 1.25f;
    }
    SceneDescription scene = edited_scene();
    scene.tangents_read = true;
    apply(edits_of(edit), scene);
    const MaterialDescription& m = scene.materials[kBallMaterial];
    for (const MaterialParameter& p : material_parameters()) {
      const bool is_it = p.name == edited.name;
      if (p.color) {
        EXPECT_EQ(m.*p.color, is_it ? Rgb(0.125f, 0.25f, 0.5f) : own.*p.color) << p.name;
      } else {
        EXPECT_EQ(m.*p.number, is_it ? p.unit * 1.25f : own.*p.number) << p.name;
      }
    }
  }
  EXPECT_NEAR(material_parameter("anisotropy_rotation").unit, M_PI / 180, 1e-9);
}

TEST(SceneEdits, AnisotropyNeedsTangents) {
  MaterialEdit edit = material_edit(kBallMaterial);
  edit.target.place = "shot.json#/materials/0";
  edit.anisotropy = 0.5f;
  EXPECT_TRUE(need_tangents(edits_of(edit)));
  expect_words(rejection_message(edits_of(edit)),
               {"shot.json#/materials/0: ", "tangents", "\"anisotropy\"", "'ball'"});
  edit.target.index = kFloorMaterial;  // this material has a normal map
  EXPECT_EQ(rejection_message(edits_of(edit)), "");
  edit.target.index = kBallMaterial;
  edit.anisotropy = 0.0f;
  EXPECT_EQ(rejection_message(edits_of(edit)), "");
  EXPECT_FALSE(need_tangents(edits_of(edit)));
}

TEST(SceneEdits, FullyReflectingMaterialsHaveNoIndexOfRefraction) {
  SceneDescription scene = edited_scene();
  scene.materials[kBallMaterial].ior = 0.0f;
  MaterialEdit edit = material_edit(kBallMaterial);
  edit.target.place = "shot.json#/materials/0";
  edit.ior = 1.5f;
  expect_words(rejection_message(edits_of(edit), scene),
               {"shot.json#/materials/0: ", "\"ior\"", "'ball'"});
  EXPECT_EQ(rejection_message(edits_of(edit)), "");
}

TEST(SceneEdits, UniqueNamesAreFoundAtAnyIndex) {
  MaterialEdit edit = material_edit(0);  // the index before the file was exported again
  edit.target.name = "glass";
  edit.roughness = 0.9f;
  EXPECT_EQ(edited_by(edits_of(edit)).materials[kGlassMaterial].roughness, 0.9f);
  edit.target.index = -1;
  EXPECT_EQ(edited_by(edits_of(edit)).materials[kGlassMaterial].roughness, 0.9f);
  // The index selects among equal names.
  edit.target.name = "lamp";
  edit.target.index = kPanelMaterial;
  const SceneDescription scene = edited_by(edits_of(edit));
  EXPECT_EQ(scene.materials[kPanelMaterial].roughness, 0.9f);
  EXPECT_EQ(scene.materials[kLampMaterial].roughness, 1.0f);
}

TEST(SceneEdits, UnknownNamesListTheValidOnes) {
  MaterialEdit edit = material_edit(-1);
  edit.target = {"glas", -1, "shot.json#/materials/0"};
  expect_words(rejection_message(edits_of(edit)),
               {"shot.json#/materials/0: ", "'glas'", "2 'glass'"});
  edit.target = {"", 8, "shot.json#/materials/0"};
  expect_words(rejection_message(edits_of(edit)), {"no material 8", "7 'veil'"});
  edit.target = {"lamp", 0, "shot.json#/materials/0"};
  expect_words(rejection_message(edits_of(edit)),
               {"2 materials", "'lamp'", "5 'lamp'", "6 'lamp'"});

  SceneEdits twice = edits_of(material_edit(kGlassMaterial));
  twice.materials.push_back(material_edit(-1));
  twice.materials.back().target = {"glass", -1, "shot.json#/materials/1"};
  expect_words(rejection_message(twice),
               {"shot.json#/materials/1: ", "has more than one entry", "2 'glass'"});

  LightEdit light = light_edit(EditedLight::kPunctual, 2);
  expect_words(rejection_message(edits_of(light)), {"no light 2", "1 'spot'"});
  SceneDescription lampless = edited_scene();
  lampless.lights.clear();
  expect_words(rejection_message(edits_of(light), lampless), {"no light 2", "has no lights"});
  SceneEdits sky = edits_of(light_edit(EditedLight::kEnvironment, -1));
  sky.lights.push_back(sky.lights[0]);
  expect_words(rejection_message(sky), {"has more than one entry", "environment"});

  SceneDescription skyless = edited_scene();
  skyless.environment.reset();
  sky.lights.pop_back();
  expect_words(rejection_message(sky, skyless), {"no environment", "file"});
  SceneEdits turned;
  turned.environment.rotation_degrees = 10.0f;
  expect_words(rejection_message(turned, skyless), {"no environment", "file"});
}

TEST(SceneEdits, VariantAssignsItsMaterials) {
  SceneDescription scene = edited_scene();
  add_variants(scene);
  SceneEdits edits;
  edits.variant = EditTarget{"", kVeiledBall, ""};
  edits.materials.push_back(material_edit(kVeilMaterial));
  edits.materials.back().roughness = 0.25f;
  apply(edits, scene);
  EXPECT_EQ(scene.meshes[1].material, kVeilMaterial);
  EXPECT_EQ(scene.meshes[0].material, kFloorMaterial);
  EXPECT_EQ(scene.materials[kVeilMaterial].roughness, 0.25f);

  edits.variant = EditTarget{"beach", -1, "shot.json#/variant"};
  expect_words(rejection_message(edits),
               {"shot.json#/variant: ", "no variant 'beach'", "has no variants"});
  scene = edited_scene();
  add_variants(scene);
  expect_words(rejection_message(edits, scene), {"no variant 'beach'", "1 'veiled ball'"});
}

TEST(SceneEdits, ARefusalLeavesTheDescriptionAsItWas) {
  SceneEdits edits = edits_of(light_edit(EditedLight::kPunctual, 0));
  edits.lights[0].intensity = 5.0f;
  edits.lights.push_back(light_edit(EditedLight::kPunctual, 9));
  SceneDescription scene = edited_scene();
  EXPECT_THROW(apply(edits, scene), InputError);
  EXPECT_EQ(scene.lights[0].intensity, edited_scene().lights[0].intensity);
}

TEST(SceneEdits, EqualityIgnoresThePlaceInTheFile) {
  SceneEdits a;
  a.camera.fov_y_degrees = 30.0;
  a.materials.push_back(material_edit(0));
  SceneEdits b = a;
  a.materials[0].target.place = "shot.json#/materials/0";
  a.camera.place = "shot.json#/camera";
  EXPECT_EQ(a, b);
  b.variant = EditTarget{"", kSwappedLamps, ""};
  EXPECT_NE(a, b);
}

TEST(SceneEdits, ViewReplacesOnlyItsMembers) {
  SceneDescription scene = edited_scene();
  scene.cameras = {perspective({0, 0, 5}, {0, 0, 0}, 40), orthographic({0, 9, 0}, {0, 0, 0}, 2)};
  scene.cameras[1].name = "plan";
  const CameraDescription base = edited_view();
  SceneEdits edits;
  EXPECT_EQ(edited_camera(edits, scene, base).to_world, base.to_world);
  edits.camera.fov_y_degrees = 60.0;
  EXPECT_DOUBLE_EQ(edited_camera(edits, scene, base).fov_y, kPiD / 3);
  edits.camera.camera = EditTarget{"plan", -1, "shot.json#/camera/file_camera"};
  edits.camera.place = "shot.json#/camera";
  EXPECT_THROW(edited_camera(edits, scene, base), InputError) << "orthographic";
  edits.camera.look_from = Vec3d(1, 2, 3);
  edits.camera.look_at = Vec3d(1, 2, 0);
  edits.camera.up = Vec3d(1, 0, 0);
  const CameraDescription rolled = edited_camera(edits, scene, base);
  EXPECT_FALSE(rolled.orthographic);
  EXPECT_EQ(Vec3d(rolled.to_world[1][0], rolled.to_world[1][1], rolled.to_world[1][2]),
            Vec3d(1, 0, 0));
  edits.camera.look_at = edits.camera.look_from;
  EXPECT_THROW(edited_camera(edits, scene, base), InputError);
  edits.camera.camera->name = "section";
  try {
    edited_camera(edits, scene, base);
    ADD_FAILURE() << "no camera of that name";
  } catch (const InputError& error) {
    expect_words(error.what(), {"file_camera", "'section'", "1 'plan'"});
  }
}

TEST(SceneEdits, AViewIsOrthographicAndMirroredWhereItSaysSo) {
  const SceneDescription scene = edited_scene();
  const CameraDescription plan = orthographic({0, 9, 0}, {0, 0, 0}, 2);
  SceneEdits edits;
  edits.camera.orthographic_height = 3.0;
  CameraDescription camera = edited_camera(edits, scene, plan);
  EXPECT_EQ(camera.y_mag, 1.5);
  EXPECT_EQ(camera.to_world, plan.to_world);
  EXPECT_TRUE(edited_camera(edits, scene, edited_view()).orthographic);
  edits.camera.look_from = Vec3d(1, 2, 3);
  edits.camera.look_at = Vec3d(1, 2, 0);
  edits.camera.mirrored = true;
  CameraDescription lens = edited_view();
  lens.lens_radius = 0.1;
  camera = edited_camera(edits, scene, lens);
  EXPECT_TRUE(camera.orthographic);
  EXPECT_EQ(camera.y_mag, 1.5);
  EXPECT_EQ(camera.lens_radius, 0.0);
  EXPECT_LT(camera.to_world.determinant(), 0.0);
  EXPECT_EQ(camera.to_world[0][0], -1.0);
  EXPECT_EQ(camera.to_world[2][2], 1.0);
  edits.camera.fov_y_degrees = 30.0;
  EXPECT_THROW(edited_camera(edits, scene, plan), InputError);
  edits.camera.fov_y_degrees.reset();
  edits.camera.f_stop = 2.0;
  EXPECT_THROW(edited_camera(edits, scene, plan), InputError);
}

TEST(SceneEdits, ALensIsOfTheEditedView) {
  const SceneDescription scene = edited_scene();
  SceneEdits edits;
  edits.camera.f_stop = 2.0;
  EXPECT_THROW(edited_camera(edits, scene, edited_view()), InputError) << "focused nowhere";
  EXPECT_THROW(edited_camera(edits, scene, orthographic({0, 9, 0}, {0, 0, 0}, 2)), InputError);
  edits.camera.focus_distance = 3.0;
  edits.camera.fov_y_degrees = 60.0;
  CameraDescription camera = edited_camera(edits, scene, edited_view());
  EXPECT_EQ(camera.focus_distance, 3.0);
  EXPECT_DOUBLE_EQ(camera.lens_radius, lens_radius(2.0, kPiD / 3));
  edits.camera.focus_distance.reset();
  edits.camera.look_from = Vec3d(1, 2, 3);
  edits.camera.look_at = Vec3d(1, 2, 0.5);
  camera = edited_camera(edits, scene, edited_view());
  EXPECT_EQ(camera.focus_distance, 2.5);
  edits.camera.f_stop.reset();
  EXPECT_EQ(edited_camera(edits, scene, edited_view()).lens_radius, 0.0);
}

TEST(SceneEdits, AnyDirectionCanBeUp) {
  for (const Vec3d& up : {Vec3d(0, 1, 0), Vec3d(1, 0, 0), Vec3d(0, -3, 4)}) {
    for (const Vec3d& back : {Vec3d(0, 1, 0), Vec3d(1, 0, 0), Vec3d(0, -0.6, 0.8)}) {
      const Mat44d m = look_at_matrix(back, Vec3d(0.0), up);
      EXPECT_NEAR(m.determinant(), 1.0, 1e-12);
      EXPECT_NEAR(m[2][0] * back.x + m[2][1] * back.y + m[2][2] * back.z, 1.0, 1e-12);
    }
  }
}

TEST(SceneEdits, AnOutlineHasAllButTheVertices) {
  const SceneDescription scene = edited_scene(), kept = copy_without_geometry(scene);
  ASSERT_EQ(kept.meshes.size(), scene.meshes.size());
  for (size_t i = 0; i < kept.meshes.size(); ++i) {
    EXPECT_EQ(kept.meshes[i].material, scene.meshes[i].material);
    EXPECT_TRUE(kept.meshes[i].positions.empty() && kept.meshes[i].triangles.empty());
  }
  EXPECT_EQ(kept.materials.size(), scene.materials.size());
  EXPECT_EQ(kept.instances.size(), scene.instances.size());
  EXPECT_EQ(kept.lights.size(), scene.lights.size());
  EXPECT_EQ(kept.environment->image, scene.environment->image);
  EXPECT_EQ(kept.images, scene.images);
}

// The default light is added only once. If lights are turned off later, the scene stays dark.
TEST(SceneEdits, OnlyAFileWithoutLightIsGivenOne) {
  SceneBuilderForTests b;
  b.add_floor(1, 0, -1);
  SceneDescription scene = b.description;
  add_default_light(scene);
  ASSERT_TRUE(scene.environment);
  scene.environment.reset();
  add_default_light(scene);
  EXPECT_FALSE(scene.environment);
  SceneDescription lit = edited_scene();
  lit.environment.reset();
  lit.lights.clear();
  add_default_light(lit);
  EXPECT_FALSE(lit.environment) << "a lamp is light";
}

}  // namespace
}  // namespace emberline
