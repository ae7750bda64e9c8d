// Tests the edits of a session: their effects, their rejection as a whole, and saved edits that
// give `render` the same picture.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "renderer/film/filter.h"
#include "support/gltf_builder.h"
#include "unit/session_fixture.h"

namespace emberline {
namespace {

using test::SessionOwner;

class SessionEditsTest : public SessionFixture {};

TEST_F(SessionEditsTest, SavedEditsGiveTheCommandTheSameBits) {
  SessionOwner owner(settings("bisection", 8));
  owner.open(scene("cornell_box"));
  owner.session.set_edits(some_edits());
  ASSERT_TRUE(finishes(owner));
  owner.session.save_edits(path("look.json")).get();
  RenderOptions options = owner.session.settings().render;
  options.scene = scene("cornell_box");
  options.driver = "bucket";
  const std::vector<float> without = rendered(options);
  options.edits = path("look.json");
  const std::vector<float> with = rendered(options);
  expect_same_bits(owner.session.picture()->rgba, with, "saved edits");
  EXPECT_NE(with, without);
  // A session that opens the saved edits shows the same picture.
  SessionOwner other(settings("bisection", 8));
  other.open(scene("cornell_box"), path("look.json"));
  EXPECT_EQ(other.session.edits(), owner.session.edits());
  ASSERT_TRUE(finishes(other));
  expect_same_bits(other.session.picture()->rgba, with, "opened edits");
}

// Both views are mirrored, and the second is also orthographic.
TEST_F(SessionEditsTest, SavedEditsKeepTheKindOfView) {
  SessionOwner owner(settings("bisection", 4));
  owner.open(scene("cornell_box"));
  std::vector<float> before;
  for (const bool orthographic : {false, true}) {
    SceneEdits edits = some_edits();
    edits.camera.mirrored = true;
    if (orthographic) {
      edits.camera.fov_y_degrees.reset();
      edits.camera.orthographic_height = 600.0 / 7.0;
    }
    owner.session.set_edits(edits);
    ASSERT_TRUE(finishes(owner));
    owner.session.save_edits(path("look.json")).get();
    RenderOptions options = settings("bucket", 4).render;
    options.scene = scene("cornell_box");
    options.edits = path("look.json");
    const std::vector<float> seen = owner.session.picture()->rgba;
    expect_same_bits(seen, rendered(options), orthographic ? "orthographic" : "mirrored");
    EXPECT_NE(seen, before);
    before = seen;
  }
}

// A view chosen on the command line is not an edit, but saved edits contain it.
TEST_F(SessionEditsTest, SavedEditsStateTheViewOfTheOptions) {
  ViewSettings view = settings("bisection", 4);
  view.render.look_from = Vec3d(300, 250, -700);
  view.render.look_at = Vec3d(278, 273, 200);
  view.render.fov_y = 35.0;
  SessionOwner owner(view);
  owner.open(scene("cornell_box"));
  ASSERT_TRUE(finishes(owner));
  owner.session.save_edits(path("look.json")).get();
  RenderOptions options = settings("bucket", 4).render;
  options.scene = scene("cornell_box");
  options.edits = path("look.json");
  expect_same_bits(owner.session.picture()->rgba, rendered(options), "the view");
}

// Saved edits contain the selected camera, even if several cameras have the same name.
TEST_F(SessionEditsTest, SavedEditsStateTheCameraOfTheOptions) {
  test::GltfBuilder gltf;
  gltf.add_triangle();
  gltf.push("cameras", {{"name", "Camera"},
                        {"type", "perspective"},
                        {"perspective", {{"yfov", 0.8}, {"znear", 0.1}}}});
  for (const char* name : {"Wide", "Tele"}) {
    gltf.add_to_scene(gltf.push(
        "nodes",
        {{"camera", 0}, {"name", name}, {"translation", {0.3, 0.3, name[0] == 'W' ? 3 : 2}}}));
  }
  gltf.write_glb(path("cameras.glb"));
  for (const char* camera : {"1", "Tele"}) {
    ViewSettings view = settings("bisection", 4);
    view.render.camera = camera;
    SessionOwner owner(view);
    owner.open(path("cameras.glb"));
    ASSERT_TRUE(finishes(owner));
    owner.session.save_edits(path("look.json")).get();
    RenderOptions options = settings("bucket", 4).render;
    options.scene = path("cameras.glb");
    const std::vector<float> first = rendered(options);
    options.edits = path("look.json");
    expect_same_bits(owner.session.picture()->rgba, rendered(options), camera);
    EXPECT_NE(rendered(options), first);
  }
}

// Saved edits also contain the lens, which keeps its f-number when the angle of view changes.
TEST_F(SessionEditsTest, SavedEditsStateTheLensOfTheOptions) {
  ViewSettings view = settings("bisection", 4);
  view.render.look_from = Vec3d(300, 250, -700);
  view.render.look_at = Vec3d(278, 273, 200);
  view.render.f_stop = 0.001;  // the box is half a kilometre wide
  view.render.focus_distance = 800.0;
  SessionOwner owner(view);
  owner.open(scene("cornell_box"));
  ASSERT_TRUE(finishes(owner));
  RenderOptions options = view.render;
  options.driver = "bucket";
  options.scene = scene("cornell_box");
  expect_same_bits(owner.session.picture()->rgba, rendered(options), "as opened");
  SceneEdits edits = owner.session.edits();
  edits.camera.fov_y_degrees = 25.0;
  owner.session.set_edits(edits);
  ASSERT_TRUE(finishes(owner));
  owner.session.save_edits(path("look.json")).get();
  options.fov_y = 25.0;
  const std::vector<float> expected = rendered(options);
  expect_same_bits(owner.session.picture()->rgba, expected, "another angle");
  options = settings("bucket", 4).render;
  options.scene = scene("cornell_box");
  options.edits = path("look.json");
  expect_same_bits(rendered(options), expected, "saved");
  options.f_stop = 1e6;
  EXPECT_NE(rendered(options), expected) << "too small a lens to be seen";
}

TEST_F(SessionEditsTest, RefusedEditsLeaveAllAsItWas) {
  SessionOwner owner(settings("bisection", 2));
  owner.open(scene("cornell_box"));
  owner.session.set_edits(some_edits());
  const uint64_t edit = owner.session.edit();
  SceneEdits wrong;
  test::material(wrong, 999);
  EXPECT_THROW(owner.session.set_edits(wrong), InputError);
  SceneEdits nowhere;
  nowhere.camera.look_from = nowhere.camera.look_at = Vec3d(1.0);
  EXPECT_THROW(owner.session.set_edits(nowhere), InputError);
  LightEdit solo;
  solo.target.index = 99;
  EXPECT_THROW(owner.session.set_edits({}, solo), InputError);
  EXPECT_EQ(owner.session.edits(), some_edits());
  EXPECT_EQ(owner.session.edit(), edit);
  ASSERT_TRUE(finishes(owner));
}

TEST_F(SessionEditsTest, SoloIsTheEditsWithEveryOtherLightOff) {
  SessionOwner owner(settings("bisection", 4));
  owner.open(scene("mis_plates"));
  RenderSession& session = owner.session;
  // These are two of the scene's lamps, each with a material of its own.
  std::vector<int> lamps;
  const auto& materials = session.scene()->outline.materials;
  for (size_t i = 0; i < materials.size(); ++i) {
    if (!is_black(materials[i].emission)) lamps.push_back(int(i));
  }
  ASSERT_GE(lamps.size(), 2u);
  SceneEdits dimmed;
  LightEdit& edit = test::light(dimmed, EditedLight::kMaterial, lamps[1]);
  edit.intensity = 0.5f;
  edit.on = false;  // solo overrides it
  LightEdit solo;
  solo.kind = EditedLight::kMaterial;
  solo.target.index = lamps[1];
  session.set_edits(dimmed, solo);
  EXPECT_EQ(session.edits(), dimmed);
  ASSERT_TRUE(finishes(owner));
  const std::vector<float> alone = session.picture()->rgba;
  SceneEdits explicitly;
  for (const int lamp : lamps) {
    LightEdit& other = test::light(explicitly, EditedLight::kMaterial, lamp);
    other.on = lamp == lamps[1];
    other.intensity = lamp == lamps[1] ? 0.5f : 1.0f;
  }
  if (session.scene()->outline.environment) {
    test::light(explicitly, EditedLight::kEnvironment, -1).on = false;
  }
  session.set_edits(explicitly);
  ASSERT_TRUE(finishes(owner));
  expect_same_bits(session.picture()->rgba, alone, "solo");
}

TEST_F(SessionEditsTest, ReadsAnEnvironmentThatAnEditNames) {
  // A rendered picture serves as the environment, since any latitude-longitude map will do.
  RenderOptions options = settings("bucket", 1).render;
  options.scene = scene("cornell_box");
  options.outputs = {path("sky.exr")};
  ASSERT_EQ(run_render(options), 0);
  SessionOwner owner(settings("bisection", 2));
  owner.open(scene("cornell_box"));
  ASSERT_TRUE(finishes(owner));
  const std::vector<float> before = owner.session.picture()->rgba;
  SceneEdits edits;
  edits.environment.file = path("sky.exr");
  owner.session.set_edits(edits);
  ASSERT_TRUE(finishes(owner)) << owner.session.problem();
  EXPECT_NE(owner.session.picture()->rgba, before);
  edits.environment.file = path("none.exr");
  owner.session.set_edits(edits);
  ASSERT_TRUE(owner.wait(30, [&] { return !owner.session.problem().empty(); }));
  EXPECT_NE(owner.session.problem().find("none.exr"), std::string::npos);
}

}  // namespace
}  // namespace emberline
