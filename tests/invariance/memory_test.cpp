// Compares the figures under "memory" in report.json with the growth of the process.
//
// Each figure must be true to 5 %. Every case makes its subject 50 to 300 MB large, so that other
// changes (the allocator's free lists, thread stacks, library pages touched for the first time:
// about 1 MB after a warm-up) stay below 2 %. Under ctest each TEST runs in its own process.
#include <gtest/gtest.h>

#include <tbb/task_arena.h>
#include <algorithm>
#include <cmath>

#include "renderer/drivers/driver_table.h"
#include "renderer/engine/render_job.h"
#include "renderer/film/film.h"
#include "renderer/output/outputs.h"
#include "support/process_memory.h"
#include "support/render.h"
#include "support/scenes.h"
#include "unit/output_folder.h"

namespace emberline::test {
namespace {

constexpr double kRelativeTolerance = 0.05;

// A wavy square of 2 n^2 triangles.
MeshDescription sheet(uint32_t n, int material, bool attributes) {
  MeshDescription mesh;
  mesh.material = material;
  const size_t vertices = size_t(n + 1) * (n + 1);
  mesh.positions.reserve(vertices);
  for (uint32_t y = 0; y <= n; ++y) {
    for (uint32_t x = 0; x <= n; ++x) {
      const float u = float(x) / float(n), v = float(y) / float(n);
      mesh.positions.emplace_back(u, 0.05f * std::sin(40 * u) * std::cos(37 * v), v);
    }
  }
  if (attributes) {
    mesh.normals.assign(vertices, Vec3f(0, 1, 0));
    mesh.tangents.assign(vertices, Vec4f(1, 0, 0, 1));
    mesh.colors.assign(vertices, Vec4f(1, 1, 1, 1));
    mesh.uv_sets.emplace_back(vertices, Vec2f(0.5f, 0.5f));
  }
  mesh.triangles.reserve(size_t(2) * n * n);
  for (uint32_t y = 0; y < n; ++y) {
    for (uint32_t x = 0; x < n; ++x) {
      const uint32_t a = y * (n + 1) + x, b = a + n + 1;
      mesh.triangles.push_back({a, b, a + 1});
      mesh.triangles.push_back({a + 1, b, b + 1});
    }
  }
  return mesh;
}

std::shared_ptr<const Image> image(int width, int height, int channels, TexelType type) {
  auto made = std::make_shared<Image>();
  made->name = "test";
  made->width = width;
  made->height = height;
  made->channels = channels;
  made->type = type;
  constexpr size_t kBytes[] = {1, 2, 2, 4};
  // 0x3c3c3c3c is 0.0115 as a float, and 0x3c3c is 1.06 as a half.
  made->texels.assign(size_t(width) * size_t(height) * size_t(channels) * kBytes[size_t(type)],
                      std::byte{0x3c});
  return made;
}

std::unique_ptr<Scene> build(SceneBuilderForTests& b) {
  return build_scene(std::move(b.description), {});
}

class Memory : public OutputFolder {
 protected:
  void SetUp() override {
    OutputFolder::SetUp();
    // Makes free() return large blocks to the kernel. By default glibc raises this threshold to the
    // size of the largest block freed so far, and each thread keeps smaller blocks.
    mallopt(M_MMAP_THRESHOLD, 1 << 18);
    // Starts the threads and Embree before anything is measured.
    SceneBuilderForTests b;
    b.place(b.add_mesh(sheet(64, b.add_material(lambert(Rgb(0.5f))), false)));
    b.set_environment(Rgb(1.0f));
    RenderSettings settings;
    settings.threads = 2;
    render(*b.build(), perspective({0, 2, 2}, {0, 0, 0}, 40), settings);
    before_ = ProcessMemory::now();
  }
  // Returns the bytes by which the process has grown since SetUp().
  double memory_growth() const { return (ProcessMemory::now() - before_).resident; }

  static void expect_true(double figure, double measured, const char* what) {
    EXPECT_GT(measured, 30e6) << what << ": too little to tell";
    EXPECT_NEAR(figure, measured, kRelativeTolerance * measured) << what;
  }
  ProcessMemory before_;
};

TEST_F(Memory, GeometryAndBvhOfTwoMillionTriangles) {
  SceneBuilderForTests b;
  MaterialDescription mapped = lambert(Rgb(0.5f));
  mapped.normal_texture.image = 0;  // uses UV and tangents, since unused attributes are not kept
  const int material = b.add_material(mapped);
  b.description.images = {image(1, 1, 3, TexelType::kUint8)};
  b.set_environment(Rgb(1.0f));
  b.place(b.add_mesh(sheet(1024, material, true)));
  const double described = memory_growth();
  const auto scene = build(b);
  const double built = memory_growth();
  ASSERT_EQ(scene->triangle_count(), 2u << 20);
  const SceneMemory& memory = scene->memory();
  // The scene takes over the description's arrays, so only the BVH is new.
  expect_true(double(memory.geometry_bytes), described, "geometry");
  expect_true(double(memory.bvh_bytes), built - described, "BVH");
  expect_true(double(memory.geometry_bytes + memory.bvh_bytes), built, "both");
}

// Emitters and their light BVH count as geometry. There are 700,000 emitters, far from a power of
// two, so a vector that grows by doubling would take half as much memory again.
TEST_F(Memory, Emitters) {
  SceneBuilderForTests b;
  b.place(b.add_mesh(sheet(592, b.add_material(emitter(Rgb(1.0f))), false)));
  const auto scene = build(b);
  const SceneMemory& memory = scene->memory();
  expect_true(double(memory.geometry_bytes + memory.bvh_bytes), memory_growth(),
              "geometry and BVH");
  EXPECT_GT(memory.geometry_bytes, 2 * memory.bvh_bytes) << "the emitters are the larger part";
}

// With small meshes, Embree's objects for instances and meshes outweigh the BVHs. Embree's memory
// monitor does not report these objects.
TEST_F(Memory, ManyInstances) {
  SceneBuilderForTests b;
  b.set_environment(Rgb(1.0f));
  const int mesh = b.add_mesh(sheet(2, b.add_material(lambert(Rgb(0.5f))), false));
  for (int i = 0; i < 300'000; ++i) b.place(mesh, translation(i % 600, i / 600, 0));
  const auto scene = build(b);
  const SceneMemory& memory = scene->memory();
  expect_true(double(memory.geometry_bytes + memory.bvh_bytes), memory_growth(),
              "geometry and BVH");
}

TEST_F(Memory, ManyMeshes) {
  SceneBuilderForTests b;
  b.set_environment(Rgb(1.0f));
  const int material = b.add_material(lambert(Rgb(0.5f)));
  for (int i = 0; i < 50'000; ++i) {
    b.place(b.add_mesh(sheet(2, material, false)), translation(i % 300, i / 300, 0));
  }
  const auto scene = build(b);
  const SceneMemory& memory = scene->memory();
  expect_true(double(memory.geometry_bytes + memory.bvh_bytes), memory_growth(),
              "geometry and BVH");
}

TEST_F(Memory, TexturesAndEnvironment) {
  SceneBuilderForTests b;
  MaterialDescription worn = lambert(Rgb(0.5f));
  worn.base_color_texture.image = 0;
  worn.normal_texture.image = 1;
  worn.metallic_roughness_texture.image = 0;  // the same image again, which is stored once
  MaterialDescription unworn = worn;
  unworn.base_color_texture.image = 2;
  const int material = b.add_material(worn);
  b.add_material(unworn);
  b.description.images = {image(4096, 4096, 4, TexelType::kUint8),
                          image(2048, 2048, 3, TexelType::kUint16),
                          image(4096, 4096, 4, TexelType::kUint8)};
  b.add_floor(1, 0, material);
  b.set_environment(image(4096, 2048, 3, TexelType::kHalf));
  const auto scene = build(b);
  // Counts the texels of the two used images and of the environment, and the environment's table,
  // which has at least one word per texel. The third image is not loaded.
  const double least = 4096. * 4096 * 4 + 2048. * 2048 * 6 + 4096. * 2048 * (6 + 4);
  EXPECT_GE(double(scene->memory().texture_bytes), least);
  EXPECT_LT(double(scene->memory().texture_bytes), least + 4096. * 4096 * 4);
  expect_true(double(scene->memory().texture_bytes), memory_growth(), "textures");
}

// Forwards to FrameOutputs and measures the process after each tile. The lock admits one tile at a
// time, because the buffers that compress another tile do not belong to the film.
class MeasuredOutputs final : public RenderSink {
 public:
  explicit MeasuredOutputs(FrameOutputs& outputs) : outputs_(outputs) {}
  void tile_finished(const FilmTile& tile) override {
    const std::lock_guard lock(mutex_);
    outputs_.tile_finished(tile);
    peak_ = std::max(peak_, ProcessMemory::now().resident);
  }
  double peak_resident() const { return peak_; }

 private:
  FrameOutputs& outputs_;
  std::mutex mutex_;
  double peak_ = 0;
};

TEST_F(Memory, FilmOfLargeTilesAndAPicture) {
  SceneBuilderForTests b;
  b.add_floor(1, 0, b.add_material(lambert(Rgb(0.5f))));
  b.set_environment(Rgb(1.0f));
  const auto scene = b.build();
  constexpr int kWidth = 1024, kHeight = 4096, kTile = 1024;
  const Rect crop{0, 0, kWidth, kHeight};
  const Camera camera(perspective({0, 2, 2}, {0, 0, 0}, 40), kWidth, kHeight, scene->origin(),
                      scene->scale());
  FrameSettings frame_settings;
  frame_settings.width = kWidth;
  frame_settings.height = kHeight;
  frame_settings.spp = 1;
  frame_settings.max_depth = 0;
  frame_settings.filter = "box";
  const RenderPlan plan(frame_settings);
  const Frame frame = plan.frame(*scene, camera);
  const double before = ProcessMemory::now().resident;
  OutputSettings settings;
  settings.width = kWidth;
  settings.height = kHeight;
  settings.crop = crop;
  settings.tile_size = kTile;
  settings.transparent = true;  // makes the PNG 17 MB, a twelfth of the whole
  const StopRequest stop;
  FrameOutputs outputs({path("frame.exr"), path("frame.png")}, settings, stop);
  MeasuredOutputs sink(outputs);
  tbb::task_arena arena(2);
  arena.execute([&] {
    RenderJob(frame, driver_factory("bucket", {kTile, BucketOrder::kScanline})).render(sink, {});
  });
  const double measured = sink.peak_resident() - before;
  expect_true(double(outputs.film_bytes()), measured, "film");
}

}  // namespace
}  // namespace emberline::test
