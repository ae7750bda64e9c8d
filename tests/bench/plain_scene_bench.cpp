// Renders a plain scene, to compare the source tree before a feature with the tree that has it.
// unused_features.py builds this program in both trees and counts instructions. Prints one line of
// JSON.
//
//   plain_scene_bench [SAMPLES_PER_PIXEL]
#include <cstdio>
#include <cstdlib>

#include "bench/clocks.h"
#include "support/render.h"
#include "support/scenes.h"

namespace emberline::bench {
namespace {

// Returns a room with a lamp and two balls. The meshes are opaque and untextured, and each is
// placed once.
test::SceneBuilderForTests room() {
  test::SceneBuilderForTests b;
  const int white = b.add_material(test::lambert(Rgb(0.7f)));
  MaterialDescription varnish;
  varnish.base_color = Rgb(0.6f, 0.1f, 0.1f);
  varnish.metallic = 0.0f;
  varnish.roughness = 0.4f;
  const int red = b.add_material(varnish);
  const int gold = b.add_material(test::metal(Rgb(0.9f, 0.7f, 0.3f), 0.3f));
  const int lamp = b.add_material(test::emitter(Rgb(12.0f)));
  b.add_floor(1, 0, white);
  b.add_floor(1, 2, white, false);
  b.add_quad({-1, 0, -1}, {1, 0, -1}, {1, 2, -1}, {-1, 2, -1}, white);
  b.add_quad({-1, 0, 1}, {-1, 0, -1}, {-1, 2, -1}, {-1, 2, 1}, red);
  b.add_quad({1, 0, -1}, {1, 0, 1}, {1, 2, 1}, {1, 2, -1}, gold);
  b.add_floor(0.3f, 1.99f, lamp, false);
  for (const auto& [x, z, material] : {std::tuple{-0.4, -0.3, gold}, std::tuple{0.4, 0.2, red}}) {
    b.place(b.add_mesh(test::SceneBuilderForTests::sphere(0.35f, 64, material, false, true)),
            test::translation(x, 0.35, z));
  }
  return b;
}

test::RenderedImage frame(const Scene& scene, uint32_t spp) {
  test::RenderSettings settings;
  settings.width = settings.height = 96;
  settings.spp = spp;
  settings.max_depth = 9;
  settings.threads = 1;
  settings.bucket_size = 32;
  return test::render(scene, test::perspective({0, 1, 3.2}, {0, 1, 0}, 42), settings);
}

}  // namespace

// The instructions of this function are counted (callgrind --toggle-collect), so its name is fixed
// and it is called once.
extern "C" [[gnu::noipa]] void emberline_measured_frame(const Scene& scene, uint32_t spp,
                                                        test::RenderedImage* image) {
  *image = frame(scene, spp);
}

int run(uint32_t spp) {
  const auto scene = room().build();
  frame(*scene, 1);  // fills tables that are computed once
  const double start = process_cpu();
  test::RenderedImage image;
  emberline_measured_frame(*scene, spp, &image);
  const double cpu = process_cpu() - start;
  const RayCounters& rays = image.counters.rays;
  std::printf(R"({"cpu_s": %.6f, "samples": %llu, "rays": %llu, "mean": %.9g})"
              "\n",
              cpu, static_cast<unsigned long long>(image.counters.samples),
              static_cast<unsigned long long>(rays.total()), image.mean);
  return 0;
}

}  // namespace emberline::bench

int main(int argc, char** argv) {
  const int spp = argc > 1 ? std::atoi(argv[1]) : 64;
  if (spp < 1) return 2;
  return emberline::bench::run(uint32_t(spp));
}
