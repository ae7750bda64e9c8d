// An edited scene renders the same bits as a scene that was built with the same edits. Editing does
// not rebuild the geometry's BVH.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "renderer/scene/editable_scene.h"
#include "support/edited_scene.h"
#include "support/edits.h"
#include "support/render.h"

namespace emberline {
namespace {

using namespace test;

struct NamedEdit {
  const char* name;
  void (*make)(SceneEdits& edits);
};

void PrintTo(const NamedEdit& edit, std::ostream* out) { *out << edit.name; }

void choose(SceneEdits& edits, EditedVariant variant) {
  edits.variant = EditTarget{"", variant, ""};
}

const NamedEdit kEdits[] = {
    {"punctual_intensity",
     [](SceneEdits& e) { light(e, EditedLight::kPunctual, 1).intensity = 3.0f; }},
    {"punctual_color",
     [](SceneEdits& e) {
       light(e, EditedLight::kPunctual, 0).color = {1, 0.2f, 0};
     }},
    {"punctual_off", [](SceneEdits& e) { light(e, EditedLight::kPunctual, 0).on = false; }},
    {"lamp_intensity",
     [](SceneEdits& e) { light(e, EditedLight::kMaterial, kLampMaterial).intensity = 0.3f; }},
    {"lamp_off", [](SceneEdits& e) { light(e, EditedLight::kMaterial, kLampMaterial).on = false; }},
    {"environment_light",
     [](SceneEdits& e) {
       light(e, EditedLight::kEnvironment, -1).color = {0.2f, 0.5f, 2.0f};
       e.lights.back().intensity = 1.7f;
     }},
    {"environment_off", [](SceneEdits& e) { light(e, EditedLight::kEnvironment, -1).on = false; }},
    {"environment_turned", [](SceneEdits& e) { e.environment.rotation_degrees = 77.0f; }},
    {"environment_strength", [](SceneEdits& e) { e.environment.strength = 0.37f; }},
    {"environment_file",
     [](SceneEdits& e) {
       e.environment.file = "other.hdr";
       e.environment.image = patterned_sky(5.0f);
     }},
    {"all_lights_off",
     [](SceneEdits& e) {
       light(e, EditedLight::kPunctual, 0).on = false;
       light(e, EditedLight::kPunctual, 1).on = false;
       light(e, EditedLight::kMaterial, kLampMaterial).on = false;
       light(e, EditedLight::kEnvironment, -1).on = false;
     }},
    {"base_color",
     [](SceneEdits& e) {
       material(e, kBallMaterial).base_color = {0.1f, 0.9f, 0.2f};
     }},
    {"roughness", [](SceneEdits& e) { material(e, kFloorMaterial).roughness = 0.9f; }},
    {"metallic", [](SceneEdits& e) { material(e, kShellMaterial).metallic = 1.0f; }},
    // Needs tangents and texture coordinates that nothing used before.
    {"normal_map_on", [](SceneEdits& e) { material(e, kFloorMaterial).normal_scale = 1.0f; }},
    // Makes triangles emissive that did not emit before, with a texture that nothing used before.
    {"emission_on",
     [](SceneEdits& e) {
       material(e, kNeonMaterial).emission = {4, 2, 8};
     }},
    {"emission_off", [](SceneEdits& e) { material(e, kLampMaterial).emission = Rgb(0.0f); }},
    {"emission_scaled",
     [](SceneEdits& e) {
       material(e, kNeonMaterial).emission = {4, 2, 8};
       light(e, EditedLight::kMaterial, kNeonMaterial).intensity = 0.5f;
     }},
    // Another surface becomes the emitter, so flush emitters are searched for again.
    {"emitters_change_places",
     [](SceneEdits& e) {
       material(e, kLampMaterial).emission = Rgb(0.0f);
       material(e, kPanelMaterial).emission = Rgb(1.0f);
     }},
    // The number of emitters stays the same, but none lies flush in another surface.
    {"emitters_leave_the_panel",
     [](SceneEdits& e) {
       material(e, kLampMaterial).emission = Rgb(0.0f);
       material(e, kNeonMaterial).emission = {4, 2, 8};
     }},
    // Back faces are visible through transmissive surfaces only.
    {"transmission_on", [](SceneEdits& e) { material(e, kShellMaterial).transmission = 0.8f; }},
    {"transmission_off", [](SceneEdits& e) { material(e, kGlassMaterial).transmission = 0.0f; }},
    {"diffuse_transmission_on",
     [](SceneEdits& e) { material(e, kShellMaterial).diffuse_transmission = 0.8f; }},
    {"index_and_colour_of_reflection",
     [](SceneEdits& e) {
       MaterialEdit& floor = material(e, kFloorMaterial);
       floor.ior = 2.0f;
       floor.specular_color = {2.0f, 1.0f, 0.5f};
     }},
    {"clear_coat_on",
     [](SceneEdits& e) {
       MaterialEdit& floor = material(e, kFloorMaterial);
       floor.clearcoat = 1.0f;
       floor.clearcoat_roughness = 0.1f;
     }},
    {"sheen_and_film_on",
     [](SceneEdits& e) {
       material(e, kShellMaterial).sheen_color = {0.5f, 0.2f, 0.1f};
       material(e, kFloorMaterial).iridescence = 1.0f;
     }},
    // Needs tangents that nothing used before.
    {"anisotropy_on", [](SceneEdits& e) { material(e, kFloorMaterial).anisotropy = 0.7f; }},
    {"veil",
     [](SceneEdits& e) {
       material(e, kVeilMaterial).base_color = {1, 0, 0};
     }},
    {"variant_of_a_material", [](SceneEdits& e) { choose(e, kGoldenFloor); }},
    {"variant_brings_coverage", [](SceneEdits& e) { choose(e, kVeiledBall); }},
    {"variant_takes_coverage", [](SceneEdits& e) { choose(e, kSolidVeil); }},
    {"variant_moves_the_lamps", [](SceneEdits& e) { choose(e, kSwappedLamps); }},
    {"variant_is_clear", [](SceneEdits& e) { choose(e, kClearShell); }},
    {"variant_with_edits",
     [](SceneEdits& e) {
       choose(e, kSwappedLamps);
       material(e, kPanelMaterial).base_color = {0.9f, 0.1f, 0.1f};
       light(e, EditedLight::kMaterial, kLampMaterial).intensity = 0.5f;
     }},
    {"many",
     [](SceneEdits& e) {
       material(e, kShellMaterial).transmission = 1.0f;
       material(e, kNeonMaterial).emission = {1, 2, 3};
       material(e, kFloorMaterial).normal_scale = 0.5f;
       light(e, EditedLight::kPunctual, 1).on = false;
       e.environment.rotation_degrees = -120.0f;
     }},
};

SceneDescription varied_scene() {
  SceneDescription scene = edited_scene();
  add_variants(scene);
  return scene;
}

SceneEdits made(const NamedEdit& edit) {
  SceneEdits edits;
  edit.make(edits);
  return edits;
}

RenderedImage picture(const Scene& scene, int threads) {
  RenderSettings s;
  s.width = 41;
  s.height = 31;
  s.spp = 4;
  s.max_depth = 5;
  s.threads = threads;
  s.aovs = "albedo,N,Z,id";
  return render(scene, edited_view(), s);
}

std::unique_ptr<Scene> built(const SceneEdits& edits) {
  SceneDescription description = varied_scene();
  apply(edits, description);
  return build_scene(std::move(description), {});
}

// Returns the scene's features except the last, which describes the BVH. The BVH's size changes
// when every single-sided mesh has a filter.
std::vector<std::string> features(const Scene& scene) {
  std::vector<std::string> list = scene.features();
  list.pop_back();
  return list;
}

bool differ(const RenderedImage& a, const RenderedImage& b) { return a.values != b.values; }

class Edits : public testing::TestWithParam<NamedEdit> {};

TEST_P(Edits, GiveTheBitsOfASceneBuiltWithThem) {
  const SceneEdits edits = made(GetParam());
  const RenderedImage unedited = picture(*build_scene(varied_scene(), {}), 2);
  const std::unique_ptr<Scene> fresh = built(edits);
  const RenderedImage expected = picture(*fresh, 2);
  EXPECT_TRUE(differ(expected, unedited)) << "the edit is not seen";

  EditableScene scene(varied_scene());
  const uint32_t builds = scene.scene().bvh_builds();
  scene.set(edits);
  for (const int threads : {1, 2, 7}) {
    expect_same_bits(picture(scene.scene(), threads), expected,
                     std::to_string(threads) + " threads");
  }
  EXPECT_EQ(features(scene.scene()), features(*fresh));
  EXPECT_EQ(scene.scene().lights().describe(), fresh->lights().describe());

  scene.set({});
  expect_same_bits(picture(scene.scene(), 2), unedited, "undone");
  scene.set(edits);
  expect_same_bits(picture(scene.scene(), 2), expected, "done again");
  EXPECT_EQ(scene.scene().bvh_builds(), builds);
}

INSTANTIATE_TEST_SUITE_P(Each, Edits, testing::ValuesIn(kEdits),
                         [](const auto& edit) { return std::string(edit.param.name); });

TEST(EditsTest, OneBvhPerInstancedMeshAndOneOverAll) {
  EXPECT_EQ(EditableScene(varied_scene()).scene().bvh_builds(), 2u);
  EXPECT_EQ(built({})->bvh_builds(), 2u);
}

TEST(EditsTest, EditableSceneRendersLikeAnyOther) {
  const std::vector<std::string> list = features(*build_scene(varied_scene(), {}));
  EXPECT_TRUE(std::ranges::any_of(list, [](const std::string& feature) {
    return feature.starts_with("flush emitters");
  })) << "the lamp is not in the panel: the tests above say less than they should";
  for (const int threads : {1, 3}) {
    expect_same_bits(picture(EditableScene(varied_scene()).scene(), threads),
                     picture(*build_scene(varied_scene(), {}), threads), "unedited");
  }
}

// After hundreds of edits in a row, only the last one counts. The edits are chosen by std::mt19937
// with seed 1.
TEST(EditsTest, AStormOfEdits) {
  EditableScene scene(varied_scene());
  const uint32_t builds = scene.scene().bvh_builds();
  std::mt19937 random(1);
  SceneEdits edits;
  for (int i = 0; i < 300; ++i) {
    edits = made(kEdits[random() % std::size(kEdits)]);
    scene.set(edits);
    if (i % 60 != 59) continue;
    expect_same_bits(picture(scene.scene(), 2), picture(*built(edits), 2),
                     "after edit " + std::to_string(i));
  }
  scene.set({});
  expect_same_bits(picture(scene.scene(), 2), picture(*built({}), 2), "all undone");
  EXPECT_EQ(scene.scene().bvh_builds(), builds);
}

// A camera edit does not touch the scene.
TEST(EditsTest, ACameraEditLeavesTheScene) {
  EditableScene scene(varied_scene());
  const LightSampler* lights = &scene.scene().lights();
  const Material* material = &scene.scene().material_of(0);
  SceneEdits edits;
  edits.camera.fov_y_degrees = 20.0;
  scene.set(edits);
  EXPECT_EQ(&scene.scene().lights(), lights);
  EXPECT_EQ(&scene.scene().material_of(0), material);
}

// Turning off the only lamp leaves darkness, not the white sky of scenes without light.
TEST(EditsTest, TheLastLightTurnedOffIsDarkness) {
  SceneDescription lamp = varied_scene();
  lamp.environment.reset();
  lamp.lights.clear();
  SceneEdits off;
  light(off, EditedLight::kMaterial, kLampMaterial).on = false;
  EditableScene scene(lamp);
  scene.set(off);
  EXPECT_EQ(picture(scene.scene(), 2).rgb(20, 20), Rgb(0.0f));
  for (uint32_t i = 0; i < scene.scene().instance_count(); ++i) {
    EXPECT_EQ(scene.scene().emitter_index(i, 0), Scene::kNoEmitter);
  }
  apply(off, lamp);
  expect_same_bits(picture(*build_scene(lamp, {}), 2), picture(scene.scene(), 2), "built dark");
}

// The default sky and the default material can be edited.
TEST(EditsTest, DefaultSkyAndMaterialAreEditable) {
  SceneBuilderForTests b;
  b.add_floor(3, 0, -1);
  EditableScene scene(b.description);
  const RenderedImage white = picture(scene.scene(), 2);
  expect_same_bits(white, picture(*b.build(), 2), "unedited");
  SceneEdits edits;
  MaterialEdit& floor = edits.materials.emplace_back();
  floor.target.name = kDefaultMaterialName;
  floor.base_color = Rgb(0.1f, 0.2f, 0.3f);
  light(edits, EditedLight::kEnvironment, -1).intensity = 2.0f;
  scene.set(edits);
  SceneDescription description = b.description;
  apply(edits, description);
  const RenderedImage edited = picture(scene.scene(), 2);
  expect_same_bits(edited, picture(*build_scene(description, {}), 2), "edited");
  EXPECT_TRUE(differ(edited, white));
}

// A rejected edit changes nothing.
TEST(EditsTest, RefusedEditKeepsTheScene) {
  EditableScene scene(varied_scene());
  const SceneEdits before = made(kEdits[0]);
  scene.set(before);
  const RenderedImage seen = picture(scene.scene(), 2);
  SceneEdits refused = before;
  material(refused, 99).roughness = 0.5f;
  EXPECT_THROW(scene.set(refused), std::exception);
  EXPECT_EQ(scene.edits(), before);
  expect_same_bits(picture(scene.scene(), 2), seen, "after the refusal");
}

}  // namespace
}  // namespace emberline
