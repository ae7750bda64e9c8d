// Benchmarks the refinement tree: the cost per sample of growing it, and the cost of its pictures.
// The benchmark uses one thread and a picture of 1280 x 720 pixels, with edges everywhere and flat
// areas between them.
#include <tbb/task_arena.h>

#include <memory>
#include <string>
#include <vector>

#include "bench/parts.h"
#include "renderer/drivers/adaptive/smooth_reconstruction.h"

namespace emberline::bench {
namespace {

constexpr Rect kWindow = {0, 0, 1280, 720};

// Returns a pixel of a picture of 80 x 80 pixel tiles with a disc in each. A fifth of the final
// leaves lie on edges.
Rgb disc_picture(int x, int y) {
  const int dx = x % 80 - 40, dy = y % 80 - 40;
  return Rgb(dx * dx + dy * dy < 900 ? 0.8f : 0.1f + 1e-4f * float(x));
}

void refine(RefinementTree& tree, size_t samples) {
  std::vector<Rgb> values;
  while (!tree.finished() && tree.sample_count() < samples) {
    values.clear();
    for (const Vec2i& pixel : tree.next_round(samples - tree.sample_count())) {
      values.push_back(disc_picture(pixel.x, pixel.y));
    }
    tree.insert(values);
  }
}

void on_one_thread(const auto& body) { tbb::task_arena(1).execute(body); }

}  // namespace

void add_refinement_benchmarks() {
  const auto pixels = size_t(kWindow.area());
  for (const size_t part : {16, 4, 1}) {  // samples one pixel in `part`
    const std::string at = "/1_of_" + std::to_string(part);
    const size_t samples = pixels / part;
    add_benchmark(
        "refinement/grow" + at,
        [samples] {
          size_t bytes = 0;
          on_one_thread([&] {
            RefinementTree tree(kWindow, {});
            refine(tree, samples);
            bytes = tree.node_bytes();
          });
          return bytes;
        },
        double(samples));
    const auto tree = std::make_shared<RefinementTree>(kWindow, RefinementSettings{});
    refine(*tree, samples);
    std::vector<Rgb> values;
    for (uint32_t leaf = 0; leaf < tree->sample_count(); ++leaf)
      values.push_back(tree->value(leaf));
    add_benchmark("refinement/smooth" + at,
                  [tree, values, picture = std::vector<Rgb>(pixels)]() mutable {
                    on_one_thread([&] { reconstruct_smooth(*tree, values, picture); });
                    return picture[0].x;
                  });
  }
}

}  // namespace emberline::bench
