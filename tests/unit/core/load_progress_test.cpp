// Tests the progress reports while a scene loads, and cancelling at any moment.
#include "renderer/core/load_progress.h"

#include <gtest/gtest.h>

#include <tbb/global_control.h>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>

#include "renderer/core/errors.h"
#include "renderer/engine/frame_scene.h"
#include "renderer/scene/editable_scene.h"
#include "support/embedded_images.h"
#include "support/encoded_images.h"
#include "support/load_scene.h"
#include "support/processor_time.h"
#include "support/render.h"
#include "support/scenes.h"

namespace emberline::test {
namespace {

constexpr int kImages = 5;

// The scene has five textured squares. The second is a lamp that lies flush in the first, and the
// last three are placed twice each.
class LoadProgressTest : public testing::Test {
 protected:
  void SetUp() override {
    OIIO::ImageSpec sky(16, 8, 3, OIIO::TypeDesc::FLOAT);
    std::vector<float> texels(16 * 8 * 3, 0.5f);
    texels[30] = 20.0f;
    write_image(folder_ / "sky.hdr", sky, texels);
    settings_.environment = folder_ / "sky.hdr";
    settings_.scene = scene_file(small_png());
  }

  // Writes the scene. `last_image` holds the bytes of the last square's image.
  std::string scene_file(const std::vector<uint8_t>& last_image) const {
    GltfBuilder gltf;
    const int uv = gltf.add_accessor<float>("VEC2", {0, 0, 1, 0, 1, 1, 0, 1});
    const int indices = gltf.add_accessor<uint16_t>("SCALAR", {0, 1, 2, 0, 2, 3});
    const auto square = [&](float size, int material) {
      const int positions = gltf.add_accessor<float>(
          "VEC3", {-size, 0, size, size, 0, size, size, 0, -size, -size, 0, -size});
      return gltf.add_mesh({{"attributes", {{"POSITION", positions}, {"TEXCOORD_0", uv}}},
                            {"indices", indices},
                            {"material", material}});
    };
    for (int m = 0; m < kImages; ++m) {
      add_texture(gltf, m + 1 < kImages ? small_png() : last_image);
      gltf.push("materials", {{"doubleSided", true},
                              {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", m}}}}}});
    }
    gltf.root["materials"][1]["emissiveFactor"] = {1, 0.5, 0.25};
    gltf.add_mesh_node(square(1.0f, 0));
    gltf.add_mesh_node(square(0.25f, 1));
    for (int m = 2; m < kImages; ++m) {
      const int mesh = square(0.5f, m);
      for (int copy = 0; copy < 2; ++copy) {
        const int node = gltf.add_mesh_node(mesh);
        gltf.root["nodes"][size_t(node)]["translation"] = {m, 1 + copy, 0};
      }
    }
    return gltf.write_glb(folder_ / ("scene" + std::to_string(last_image.size()) + ".glb"));
  }

  std::unique_ptr<EditableScene> load(LoadProgress& progress) const {
    SceneDescription description = test::load_scene(settings_, progress);
    return std::make_unique<EditableScene>(std::move(description), SceneBuildOptions{}, progress);
  }

  TempFolder folder_;
  FrameSettings settings_;
};

struct Entry {
  std::string stage;
  double fraction;
};

TEST_F(LoadProgressTest, FractionsGrowToOneThroughAllStages) {
  std::vector<Entry> reports;
  LoadProgress progress([&](const std::string& stage, double fraction) {
    reports.push_back({stage, fraction});
  });
  load(progress);
  ASSERT_FALSE(reports.empty());
  EXPECT_EQ(reports.front().stage, "reading");
  EXPECT_EQ(reports.front().fraction, 0.0);
  EXPECT_EQ(reports.back().fraction, 1.0);
  EXPECT_LT(reports.size(), 600u);
  for (size_t i = 1; i < reports.size(); ++i) {
    EXPECT_GE(reports[i].fraction, reports[i - 1].fraction) << i << " " << reports[i].stage;
  }
  std::string stages;
  for (const Entry& entry : reports) {
    const std::string name = entry.stage.substr(0, entry.stage.find(' '));
    if (!stages.ends_with(name)) stages += " " + name;
  }
  EXPECT_EQ(stages, " reading meshes images environment BVH lights");
  EXPECT_TRUE(std::ranges::any_of(
      reports, [](const Entry& entry) { return entry.stage == "images 4 of 5"; }));
}

// Cancels at the n-th report, for every n, so that every stage is interrupted.
TEST_F(LoadProgressTest, IsCalledOffAtEveryReport) {
  for (const int threads : {1, 3}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(threads));
    bool ended = false;
    for (int n = 0; !ended; ++n) {
      ASSERT_LT(n, 600);
      std::stop_source stop;
      int seen = 0, after = 0;
      double last = 0.0;
      std::string where;
      LoadProgress progress(
          [&](const std::string& stage, double fraction) {
            if (stop.stop_requested()) ++after;
            last = fraction;
            if (seen++ != n) return;
            where = stage;
            stop.request_stop();
          },
          stop.get_token());
      try {
        load(progress);
        ended = true;
        EXPECT_EQ(last, 1.0) << "not called off in \"" << where << "\"";
      } catch (const Cancelled&) {
        EXPECT_LE(after, threads) << "goes on after \"" << where << "\"";
      }
    }
  }
}

TEST_F(LoadProgressTest, ObserversDoNotChangeTheScene) {
  std::stop_source stop;
  LoadProgress watched([](const std::string&, double) {}, stop.get_token());
  const CameraDescription view = perspective({2, 3, 6}, {2, 1, 0}, 45);
  RenderSettings settings;
  settings.spp = 4;
  const RenderedImage a = render(load(watched)->scene(), view, settings);
  const RenderedImage b = render(load(LoadProgress::none())->scene(), view, settings);
  EXPECT_GT(a.mean, 0.0);
  expect_same_bits(a, b, "watched against unwatched");
}

// A cancelled load reports the cancellation, not errors in the file.
TEST_F(LoadProgressTest, CallingOffComesBeforeTheFilesErrors) {
  settings_.scene = scene_file({'n', 'o', 'n', 'e'});
  EXPECT_THROW(load(LoadProgress::none()), InputError);
  for (const bool lenient : {false, true}) {
    settings_.lenient = lenient;
    std::stop_source stop;
    LoadProgress progress(
        [&](const std::string& stage, double) {
          if (stage.starts_with("images 5")) stop.request_stop();
        },
        stop.get_token());
    EXPECT_THROW(load(progress), Cancelled);
  }
}

TEST_F(LoadProgressTest, BeforeItBegins) {
  std::stop_source stop;
  stop.request_stop();
  LoadProgress progress({}, stop.get_token());
  EXPECT_THROW(load(progress), Cancelled);
}

// A wavy square of 2 n^2 triangles, which is placed `instances` times in a row.
SceneDescription large_scene(uint32_t n, int instances) {
  MeshDescription mesh;
  for (uint32_t y = 0; y <= n; ++y) {
    for (uint32_t x = 0; x <= n; ++x) {
      const float u = float(x) / float(n), v = float(y) / float(n);
      mesh.positions.emplace_back(u, 0.05f * std::sin(40 * u) * std::cos(37 * v), v);
    }
  }
  for (uint32_t y = 0; y < n; ++y) {
    for (uint32_t x = 0; x < n; ++x) {
      const uint32_t a = y * (n + 1) + x, b = a + n + 1;
      mesh.triangles.push_back({a, b, a + 1});
      mesh.triangles.push_back({a + 1, b, b + 1});
    }
  }
  SceneBuilderForTests scene;
  scene.add_mesh(std::move(mesh));
  for (int i = 0; i < instances; ++i) scene.place(0, translation(2.0 * i, 0, 0));
  return scene.description;
}

// Embree reports its progress during a build and can be cancelled.
TEST(LoadProgressOfEmbree, ABuildIsToldOfAndCalledOffWithin) {
  for (const int instances : {1, 2}) {
    const SceneDescription description = large_scene(300, instances);
    std::vector<double> fractions;
    LoadProgress whole([&](const std::string& stage, double fraction) {
      if (stage == "BVH") fractions.push_back(fraction);
    });
    build_scene(description, {}, whole);
    ASSERT_GE(fractions.size(), 5u);

    std::stop_source stop;
    size_t reports = 0;
    double last = 0.0;
    LoadProgress progress(
        [&](const std::string&, double fraction) {
          last = fraction;
          if (++reports == 3) stop.request_stop();
        },
        stop.get_token());
    EXPECT_THROW(build_scene(description, {}, progress), Cancelled);
    EXPECT_LT(last, fractions.back());
  }
}

// Cancels from another thread at moments spread over the whole build. The header promises at most
// 250 ms. The limit of the test is 1 s.
TEST_F(LoadProgressTest, IsCalledOffAtOnce) {
  const SceneDescription description = large_scene(500, 1);
  const double start = processor_seconds();
  build_scene(description, {});
  const double whole = processor_seconds() - start;
  double slowest = 0.0;
  for (int i = 0; i < 8; ++i) {
    std::stop_source stop;
    LoadProgress progress({}, stop.get_token());
    double asked = 0;
    const std::jthread stopper([&, ended = stop.get_token()] {
      for (const double end = processor_seconds() + whole * i / 8;
           processor_seconds() < end && !ended.stop_requested();) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      asked = processor_seconds();
      stop.request_stop();
    });
    SceneDescription copy = description;
    try {
      build_scene(std::move(copy), {}, progress);
      stop.request_stop();
    } catch (const Cancelled&) {
      slowest = std::max(slowest, processor_seconds() - asked);
    }
  }
  RecordProperty("slowest_ms", int(slowest * 1000));
  EXPECT_LT(slowest, 1.0);
}

}  // namespace
}  // namespace emberline::test
