#include "renderer/drivers/adaptive/smooth_reconstruction.h"

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <vector>

#include "renderer/core/parallel.h"

namespace emberline {
namespace {

// Rows per task: about 0.1 ms.
constexpr size_t kRowGrain = 16;

// A level of the pull-push pyramid.
struct Level {
  int width = 0, height = 0;
  std::vector<Rgb> color;
  std::vector<uint8_t> known;

  Level(int w, int h)
      : width(w), height(h), color(size_t(w) * size_t(h), Rgb(0.0f)), known(color.size(), 0) {}
  size_t index(int x, int y) const { return size_t(y) * size_t(width) + size_t(x); }
};

template <typename Body>
void for_each_row(int rows, const Body& body) {
  parallel_ranges(size_t(rows), kRowGrain, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) body(int(y));
  });
}

Level samples_of(const RefinementTree& tree, std::span<const Rgb> values) {
  Level level(tree.crop().width(), tree.crop().height());
  for (uint32_t i = 0; i < tree.sample_count(); ++i) {
    const Vec2i pixel = tree.sampled_pixel(i) - Vec2i(tree.crop().x0, tree.crop().y0);
    level.color[level.index(pixel.x, pixel.y)] = values[i];
    level.known[level.index(pixel.x, pixel.y)] = 1;
  }
  return level;
}

// Computes the mean of the known pixels of each 2 x 2 block. A block without known pixels stays
// unknown. Uses a running mean, because the mean of equal values is then exact.
Level pull(const Level& fine) {
  Level coarse((fine.width + 1) / 2, (fine.height + 1) / 2);
  for_each_row(coarse.height, [&](int y) {
    for (int x = 0; x < coarse.width; ++x) {
      Rgb mean(0.0f);
      float count = 0;
      for (int fy = 2 * y; fy < std::min(2 * y + 2, fine.height); ++fy) {
        for (int fx = 2 * x; fx < std::min(2 * x + 2, fine.width); ++fx) {
          const size_t i = fine.index(fx, fy);
          if (fine.known[i]) mean += (fine.color[i] - mean) / ++count;
        }
      }
      coarse.color[coarse.index(x, y)] = mean;
      coarse.known[coarse.index(x, y)] = count > 0;
    }
  });
  return coarse;
}

// Fills the holes of `fine` bilinearly. A fine pixel's centre is a quarter of a coarse pixel away
// from the centre of the coarse pixel that contains it.
void push(const Level& coarse, Level& fine) {
  for_each_row(fine.height, [&](int y) {
    const int y0 = y / 2, y1 = std::clamp(y % 2 == 0 ? y0 - 1 : y0 + 1, 0, coarse.height - 1);
    for (int x = 0; x < fine.width; ++x) {
      if (fine.known[fine.index(x, y)]) continue;
      const int x0 = x / 2, x1 = std::clamp(x % 2 == 0 ? x0 - 1 : x0 + 1, 0, coarse.width - 1);
      const auto row = [&](int cy) {
        return lerp(coarse.color[coarse.index(x0, cy)], coarse.color[coarse.index(x1, cy)], 0.25f);
      };
      fine.color[fine.index(x, y)] = lerp(row(y0), row(y1), 0.25f);
    }
  });
}

}  // namespace

void reconstruct_smooth(const RefinementTree& tree, std::span<const Rgb> values,
                        std::span<Rgb> picture) {
  assert(picture.size() == size_t(tree.crop().area()) && values.size() == tree.sample_count());
  if (picture.empty()) return;
  std::vector<Level> levels;
  levels.push_back(samples_of(tree, values));
  while (levels.back().color.size() > 1) levels.push_back(pull(levels.back()));
  for (size_t i = levels.size() - 1; i-- > 0;) push(levels[i + 1], levels[i]);
  std::ranges::copy(levels[0].color, picture.begin());
}

}  // namespace emberline
