#include "renderer/window/panels/edit_entries.h"

#include <gtest/gtest.h>

namespace emberline {
namespace {

// The lights are "Key", "", "Twin" and "Twin". The materials are "wood", the emissive "neon" and
// "wood".
SceneDescription scene() {
  SceneDescription description;
  for (const char* name : {"Key", "", "Twin", "Twin"}) {
    description.lights.emplace_back().name = name;
  }
  for (const char* name : {"wood", "neon", "wood"}) {
    description.materials.emplace_back().name = name;
  }
  description.materials[1].emission = Rgb(2.0f);
  return description;
}

TEST(EditEntries, ListsLightsMaterialsThatShineAndTheEnvironment) {
  SceneDescription description = scene();
  description.environment = EnvironmentDescription{};
  const std::vector<ListedLight> lights = list_lights(description, {});
  ASSERT_EQ(lights.size(), 6u);
  EXPECT_EQ(lights[0].name, "Key");
  EXPECT_EQ(lights[1].name, "Light 1");
  EXPECT_EQ(lights[4].name, "neon");
  EXPECT_EQ(lights[4].kind, EditedLight::kMaterial);
  EXPECT_EQ(lights[4].index, 1);
  EXPECT_EQ(lights[5].kind, EditedLight::kEnvironment);
}

TEST(EditEntries, EditsMakeAMaterialALightOrNone) {
  const SceneDescription description = scene();
  SceneEdits edits;
  MaterialEdit wood = material_edit(edits, description, 0);
  wood.emission = Rgb(1.0f);
  store_entry(edits, description, wood);
  MaterialEdit neon = material_edit(edits, description, 1);
  neon.emission = Rgb(0.0f);
  store_entry(edits, description, neon);
  const std::vector<ListedLight> lights = list_lights(description, edits);
  ASSERT_EQ(lights.size(), 5u);
  EXPECT_EQ(lights[4].name, "wood");
}

TEST(EditEntries, AnEntryIsFoundAgainAndReplaced) {
  const SceneDescription description = scene();
  SceneEdits edits;
  for (int i = 0; i < 4; ++i) {
    LightEdit edit = light_edit(edits, description, EditedLight::kPunctual, i);
    edit.intensity = float(i + 2);
    store_entry(edits, description, edit);
  }
  ASSERT_EQ(edits.lights.size(), 4u);
  for (int i = 0; i < 4; ++i) {
    LightEdit edit = light_edit(edits, description, EditedLight::kPunctual, i);
    EXPECT_EQ(edit.intensity, float(i + 2)) << i;
    edit.on = false;
    store_entry(edits, description, edit);
  }
  EXPECT_EQ(edits.lights.size(), 4u);
  EXPECT_EQ(edits.lights[2].intensity, 4.0f);
  EXPECT_FALSE(edits.lights[2].on);
}

TEST(EditEntries, ANameAloneMeansTheOnlyOneThatHasIt) {
  const SceneDescription description = scene();
  SceneEdits edits;
  edits.lights.push_back({EditedLight::kPunctual, {"Key", -1, ""}, 7.0f, Rgb(1.0f), true});
  EXPECT_EQ(light_edit(edits, description, EditedLight::kPunctual, 0).intensity, 7.0f);
  EXPECT_EQ(light_edit(edits, description, EditedLight::kPunctual, 0).target.index, 0);
  EXPECT_EQ(light_edit(edits, description, EditedLight::kPunctual, 1).intensity, 1.0f);
  // If the index now belongs to another name, the name decides.
  edits.lights[0].target.index = 1;
  EXPECT_EQ(light_edit(edits, description, EditedLight::kPunctual, 0).intensity, 7.0f);
  EXPECT_EQ(light_edit(edits, description, EditedLight::kPunctual, 1).intensity, 1.0f);
}

TEST(EditEntries, EqualNamesAreDistinguishedByTheIndex) {
  const SceneDescription description = scene();
  SceneEdits edits;
  MaterialEdit edit = material_edit(edits, description, 2);
  edit.roughness = 0.3f;
  store_entry(edits, description, edit);
  EXPECT_FALSE(material_edit(edits, description, 0).roughness);
  EXPECT_EQ(material_edit(edits, description, 2).roughness, 0.3f);
}

TEST(EditEntries, EntriesWithoutEffectAreOmitted) {
  const SceneDescription description = scene();
  SceneEdits edits;
  LightEdit light = light_edit(edits, description, EditedLight::kMaterial, 1);
  store_entry(edits, description, light);
  EXPECT_EQ(edits, SceneEdits());
  light.color = Rgb(1.0f, 0.5f, 0.5f);
  store_entry(edits, description, light);
  EXPECT_EQ(edits.lights.size(), 1u);
  light.color = Rgb(1.0f);
  store_entry(edits, description, light);
  MaterialEdit material = material_edit(edits, description, 0);
  material.metallic = 0.5f;
  store_entry(edits, description, material);
  material.metallic.reset();
  store_entry(edits, description, material);
  EXPECT_EQ(edits, SceneEdits());
}

TEST(EditEntries, KindsOfEqualNumberAreApart) {
  SceneDescription description = scene();
  description.environment = EnvironmentDescription{};
  SceneEdits edits;
  LightEdit edit = light_edit(edits, description, EditedLight::kPunctual, 1);
  edit.intensity = 3.0f;
  store_entry(edits, description, edit);
  EXPECT_EQ(light_edit(edits, description, EditedLight::kMaterial, 1).intensity, 1.0f);
  EXPECT_EQ(light_edit(edits, description, EditedLight::kEnvironment, 0).intensity, 1.0f);
}

}  // namespace
}  // namespace emberline
