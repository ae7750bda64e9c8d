// A scene that is posed for another time renders the same bits as a scene that is loaded and built
// at that time, whatever poses and edits came before. It keeps everything that does not move.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

#include "renderer/core/errors.h"
#include "renderer/engine/frame_scene.h"
#include "renderer/engine/open_scene.h"
#include "support/animated_stage.h"
#include "support/load_scene.h"
#include "support/render.h"
#include "tests/support/animated_gltf.h"

namespace emberline {
namespace {

using namespace test;

struct When {
  double time = 0.0;
  bool shutter = false;
};

class Repose : public testing::TestWithParam<const char*> {
 protected:
  Repose() : file_(stage_.gltf.write_glb(folder_ / "stage.glb")) {}

  static FrameSettings settings(const std::string& file, const std::string& animation,
                                const When& when) {
    FrameSettings s;
    s.scene = file;
    s.animation = animation;
    s.time = when.time;
    s.fps = 4;
    if (when.shutter) s.shutter = Shutter{0.0, 0.8};
    return s;
  }
  FrameSettings at(const std::string& animation, const When& when) const {
    return settings(file_, animation, when);
  }

  static RenderedImage picture(const Scene& scene, const CameraDescription& camera) {
    RenderSettings s;
    s.width = 37;
    s.height = 29;
    s.spp = 4;
    s.max_depth = 4;
    s.aovs = "albedo,N,Z,id";
    return render(scene, camera, s);
  }

  static RenderedImage render_new(const FrameSettings& settings, const SceneEdits& edits = {}) {
    SceneDescription description = load_scene(settings);
    apply(edits, description);
    const CameraDescription camera = description.cameras.at(0);
    return picture(*build_scene(std::move(description), {}), camera);
  }
  RenderedImage render_new(const std::string& animation, const When& when,
                           const SceneEdits& edits = {}) const {
    return render_new(at(animation, when), edits);
  }

  const AnimatedStage stage_;
  const TempFolder folder_;
  const std::string file_;
};

// An open scene, like that of a session.
class PosedScene {
 public:
  explicit PosedScene(const FrameSettings& s, LoadProgress& progress = LoadProgress::none())
      : progress_(progress) {
    ReadScene read(s, {}, {.edits = true, .poses = true}, progress);
    camera_ = read.description().cameras.at(0);
    scene_ = std::move(read).build(progress);
  }

  void pose(const FrameSettings& s, const SceneEdits& edits = {}) {
    ReadScene read = this->read(s, edits);
    const CameraDescription camera = read.description().cameras.at(0);
    pose(std::move(read));
    camera_ = camera;
  }
  ReadScene read(const FrameSettings& s, const SceneEdits& edits = {}) {
    return scene_->read(s, edits, progress_);
  }
  void pose(ReadScene read) { is_reposed_ = scene_->pose(std::move(read), progress_); }
  EditableScene& edited() { return scene_->editable(); }
  const Scene& scene() const { return scene_->scene(); }
  const CameraDescription& camera() const { return camera_; }
  bool reposed() const { return is_reposed_; }

 private:
  LoadProgress& progress_;
  CameraDescription camera_;
  std::unique_ptr<OpenScene> scene_;
  bool is_reposed_ = false;
};

TEST_P(Repose, GivesTheBitsOfAFreshLoad) {
  const std::string animation = GetParam();
  // A box appears at 0.5 s and disappears at 1.5 s, also while the shutter is open.
  const When times[] = {{0.0}, {0.7},        {1.6},       {0.7, true}, {0.45, true}, {1.0},
                        {0.2}, {1.45, true}, {1.3, true}, {0.4, true}, {0.0}};
  PosedScene posed(at(animation, {1.0}));
  for (const When& when : times) {
    posed.pose(at(animation, when));
    EXPECT_TRUE(posed.reposed());
    expect_same_bits(
        picture(posed.scene(), posed.camera()), render_new(animation, when),
        animation + " at " + std::to_string(when.time) + (when.shutter ? " open" : ""));
  }
}

INSTANTIATE_TEST_SUITE_P(Each, Repose,
                         testing::Values("all that moves", "camera", "light", "box", "vanishing"),
                         [](const auto& animation) {
                           std::string name = animation.param;
                           std::ranges::replace(name, ' ', '_');
                           return name;
                         });

TEST_F(Repose, TheAnimationIsSeen) {
  for (const char* animation : {"all that moves", "camera", "light", "box", "vanishing"}) {
    EXPECT_NE(render_new(animation, {0.2}).values, render_new(animation, {1.3}).values)
        << animation;
    if (std::string(animation) == "light") continue;
    EXPECT_NE(render_new(animation, {0.7}).values, render_new(animation, {0.7, true}).values)
        << animation;
  }
}

// Switches between animations of one file. Nodes at rest in one animation move in the next.
TEST_F(Repose, TakesAnotherAnimation) {
  PosedScene posed(at("box", {0.5}));
  for (const char* animation : {"camera", "all that moves", "vanishing", "box"}) {
    posed.pose(at(animation, {0.9}));
    expect_same_bits(picture(posed.scene(), posed.camera()), render_new(animation, {0.9}),
                     animation);
  }
}

// A kept mesh emits light, so no default environment is added.
TEST_F(Repose, KeptEmissiveMeshesCountAsLights) {
  AnimatedStage stage;
  stage.gltf.root["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"] = 0;
  const std::string file = stage.gltf.write_glb(folder_ / "lamps.glb");
  PosedScene posed(settings(file, "box", {0.0}));
  const FrameSettings later = settings(file, "box", {1.2});
  posed.pose(later);
  expect_same_bits(picture(posed.scene(), posed.camera()), render_new(later), "lit by meshes");
}

TEST_F(Repose, KeepsTheEdits) {
  SceneEdits edits;
  edits.materials.emplace_back().target.index = 2;
  edits.materials.back().emission = Rgb(0.5f, 2.0f, 0.5f);
  edits.lights.emplace_back().target.index = 0;
  edits.lights.back().intensity = 0.3f;
  PosedScene posed(at("all that moves", {0.0}));
  posed.edited().set(edits);
  posed.pose(at("all that moves", {1.1}), edits);
  expect_same_bits(picture(posed.scene(), posed.camera()),
                   render_new("all that moves", {1.1}, edits), "edited, then posed");
  posed.edited().set({});
  expect_same_bits(picture(posed.scene(), posed.camera()), render_new("all that moves", {1.1}),
                   "posed, then undone");
}

TEST_F(Repose, BuildsOnlyMovingParts) {
  const auto builds = [this](const char* animation) {
    PosedScene posed(at(animation, {0.6}));
    const uint32_t before = posed.scene().bvh_builds();
    posed.pose(at(animation, {1.2}));
    return posed.scene().bvh_builds() - before;
  };
  EXPECT_EQ(builds("camera"), 0u);
  EXPECT_EQ(builds("light"), 0u);
  EXPECT_EQ(builds("box"), 1u);  // the top-level BVH
  EXPECT_EQ(builds("all that moves"), 1u);
}

// The box's matrix has no inverse at 1 s, so the box is left out.
TEST_F(Repose, VanishedObjectsReappear) {
  PosedScene posed(at("vanishing", {0.5}));
  for (const double time : {1.0, 0.5, 1.0, 1.5}) {
    posed.pose(at("vanishing", {time}));
    expect_same_bits(picture(posed.scene(), posed.camera()), render_new("vanishing", {time}),
                     std::to_string(time));
  }
}

// At 1 s the root is so far away that the pose is rejected. At 0 s and 2 s it is not.
TEST_F(Repose, BrokenPoseKeepsTheOldOne) {
  AnimatedStage stage;
  GltfBuilder& gltf = stage.gltf;
  AnimationBuilder(gltf, "lost")
      .move(0, "translation", {0, 1, 2}, "VEC3", {0, 0, 0, 1e30f, 0, 0, 0, 1, 0});
  const std::string file = gltf.write_glb(folder_ / "lost.glb");
  const auto lost = [&](double time) { return settings(file, "lost", {time}); };
  PosedScene posed(lost(0.0));
  const RenderedImage before = picture(posed.scene(), posed.camera());
  EXPECT_THROW(posed.pose(lost(1.0)), InputError);
  expect_same_bits(picture(posed.scene(), posed.camera()), before, "after the broken pose");
  EXPECT_THROW(posed.pose(settings(file, "nothing", {0.0})), UsageError);
  posed.pose(lost(2.0));
  expect_same_bits(picture(posed.scene(), posed.camera()), render_new(lost(2.0)), "and the next");
}

// Here the load succeeds but the build fails, since a lamp moves beyond the reach of rays.
TEST_F(Repose, FailedBuildKeepsTheOldPose) {
  AnimatedStage stage;
  GltfBuilder& gltf = stage.gltf;
  size_t node = 0;
  while (!gltf.root["nodes"][node].contains("extensions") ||
         !gltf.root["nodes"][node]["extensions"].contains("KHR_lights_punctual")) {
    ++node;
  }
  AnimationBuilder(gltf, "far")
      .move(int(node), "translation", {0, 1, 2}, "VEC3", {1, 3, 2, 5e18f, 0, 0, -1, 3, 2})
      .move(2, "rotation", {0, 2}, "VEC4", {0, 0, 0, 1, 0, 1, 0, 0});
  const std::string file = gltf.write_glb(folder_ / "far.glb");
  const auto far = [&](double time) { return settings(file, "far", {time}); };
  PosedScene posed(far(0.0));
  const RenderedImage before = picture(posed.scene(), posed.camera());
  EXPECT_THROW(posed.pose(far(1.0)), InputError);
  expect_same_bits(picture(posed.scene(), posed.camera()), before, "after the failed build");
  posed.pose(far(2.0));
  expect_same_bits(picture(posed.scene(), posed.camera()), render_new(far(2.0)), "and the next");
}

// In the pose that fails, the environment is edited and lamps are switched on.
TEST_F(Repose, OutOfMemoryKeepsTheOldPose) {
  const auto s = [this](double time) {
    FrameSettings at_time = at("all that moves", {time});
    at_time.environment = std::string(EMBERLINE_SCENES) + "/dusk.hdr";
    return at_time;
  };
  SceneEdits edits;
  edits.environment.strength = 3.0f;
  edits.materials.emplace_back().target.index = 0;
  edits.materials.back().emission = Rgb(1.0f);
  LoadLimits limits;
  limits.memory = std::make_shared<MemoryBudget>(uint64_t(1) << 40);
  MemoryBudget& budget = *limits.memory;
  LoadProgress progress({}, {}, limits);
  PosedScene posed(s(0), progress);
  const RenderedImage before = picture(posed.scene(), posed.camera());
  { const ReadScene noted = posed.read(s(0.8), edits); }  // the file caches what it finds here
  const uint64_t reserved = budget.reserved();
  int failures = 0;
  for (uint64_t left = 1;; left += left / 4 + 1) {
    ReadScene pose = posed.read(s(0.8), edits);
    const MemoryReservation others(limits.memory, MemoryPart::kFilm,
                                   budget.limit() - budget.reserved() - left, "others");
    try {
      posed.pose(std::move(pose));
      EXPECT_TRUE(posed.reposed());
      break;
    } catch (const InputError&) {
      expect_same_bits(picture(posed.scene(), posed.camera()), before,
                       std::to_string(left) + " bytes left");
      EXPECT_EQ(budget.reserved() - others.bytes(), reserved) << left;
      ++failures;
    }
  }
  EXPECT_GT(failures, 10);
  EXPECT_NE(picture(posed.scene(), posed.camera()).values, before.values);
}

TEST_F(Repose, AHundredPosesTakeNoMoreMemoryThanOne) {
  LoadLimits limits;
  limits.memory = std::make_shared<MemoryBudget>(uint64_t(1) << 40);
  LoadProgress progress({}, {}, limits);
  const auto s = [this](double time, bool shutter = false) {
    return at("all that moves", {time, shutter});
  };
  std::unique_ptr<OpenScene> scene =
      ReadScene(s(0.8), {}, {.poses = true}, progress).build(progress);
  const auto pose = [&](double time, bool shutter) {
    EXPECT_TRUE(scene->pose(scene->read(s(time, shutter), {}, progress), progress));
  };
  pose(0.0, false);
  pose(0.8, false);
  const uint64_t once = limits.memory->reserved();
  for (int i = 0; i < 100; ++i) pose(0.02 * i, i % 3 == 0);
  pose(0.8, false);
  EXPECT_EQ(limits.memory->reserved(), once);
  for (int i = 0; i < 100; ++i) {
    EXPECT_THROW(scene->read(settings(file_, "nothing", {0.0}), {}, progress), UsageError);
  }
  pose(0.8, false);
  EXPECT_NEAR(double(limits.memory->reserved()), double(once), 0.01 * double(once));
  scene.reset();
  EXPECT_EQ(limits.memory->reserved(), 0u);
}

TEST_F(Repose, ReadButUnbuiltMemoryIsReleased) {
  LoadLimits limits;
  limits.memory = std::make_shared<MemoryBudget>(uint64_t(1) << 40);
  LoadProgress progress({}, {}, limits);
  FrameSettings s = at("all that moves", {0.8});
  s.environment = std::string(EMBERLINE_SCENES) + "/dusk.hdr";
  for (const bool poses : {false, true}) {
    { const ReadScene read(s, {}, {.poses = poses}, progress); }
    EXPECT_EQ(limits.memory->reserved(), 0u) << poses;
    s.catchers = "no such node";
    EXPECT_THROW(ReadScene(s, {}, {.poses = poses}, progress).build(progress), UsageError);
    EXPECT_EQ(limits.memory->reserved(), 0u) << poses;
    s.catchers.clear();
  }
}

// The scene is far from the origin, where scene space and world space differ.
TEST_F(Repose, KeepsItsSpaceFarAway) {
  AnimatedStage stage;
  nlohmann::json& scene = stage.gltf.root["scenes"][0];
  const int root =
      stage.gltf.push("nodes", {{"children", scene["nodes"]}, {"translation", {4e6, 0, -3e6}}});
  scene["nodes"] = {root};
  const std::string file = stage.gltf.write_glb(folder_ / "far_away.glb");
  PosedScene posed(settings(file, "all that moves", {0.1}));
  EXPECT_NE(posed.scene().origin(), Vec3d(0.0));
  for (const double time : {0.9, 1.7}) {
    const FrameSettings s = settings(file, "all that moves", {time});
    posed.pose(s);
    EXPECT_TRUE(posed.reposed());
    SceneDescription description = load_scene(s);
    const CameraDescription camera = description.cameras.at(0);
    expect_same_bits(picture(posed.scene(), posed.camera()),
                     picture(*build_scene(std::move(description), {}), camera),
                     std::to_string(time));
  }
}

}  // namespace
}  // namespace emberline
