// Pictures for the tests of the refinement tree, and functions that insert them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "renderer/core/hash.h"
#include "renderer/drivers/adaptive/refinement_tree.h"

namespace emberline {

// The radiance at the centre of a pixel.
using Picture = std::function<Rgb(int x, int y)>;

inline Picture constant_picture(const Rgb& value) {
  return [value](int, int) { return value; };
}

// Noise per pixel, so that trees grow unevenly.
inline Rgb noise(int x, int y) {
  const uint32_t h = hash_combine(hash32(uint32_t(x)), uint32_t(y));
  return {to_unit_float(h), to_unit_float(hash32(h)), 4 * to_unit_float(hash32(h + 1))};
}

// A picture of 256 x 256 pixels: discs of three sizes, a line, a checker board, and a ramp between
// them.
inline Rgb test_picture(int x, int y) {
  const double u = x + 0.5, v = y + 0.5;
  double value = 0.15 + 0.25 * u / 256;
  if (std::hypot(u - 70, v - 70) < 40) value = 0.9;
  if (std::hypot(u - 190, v - 60) < 22) value = 0.05 + 0.3 * v / 100;
  if (std::hypot(u - 128, v - 128) < 5) value = 1;
  if (std::abs(0.5 * (u - 20) - (v - 140)) < 1.2 && u > 20 && u < 240) value = 0.95;
  if (u > 150 && u < 230 && v > 160 && v < 240) {
    value = (int(u - 150) / 10 + int(v - 160) / 10) % 2 == 0 ? 0.2 : 0.8;
  }
  return Rgb(float(value));
}

// Inserts one round of `picture` with at most `limit` samples. Returns the requested pixels.
inline std::vector<Vec2i> insert_round(RefinementTree& tree, const Picture& picture,
                                       size_t limit = ~size_t(0)) {
  const std::span<const Vec2i> wanted = tree.next_round(limit);
  std::vector<Vec2i> pixels(wanted.begin(), wanted.end());
  std::vector<Rgb> values;
  for (const Vec2i& pixel : pixels) values.push_back(picture(pixel.x, pixel.y));
  tree.insert(values);
  return pixels;
}

// Returns, for each leaf, the rectangle around its pixels.
inline std::vector<Rect> leaf_rects(const RefinementTree& tree) {
  const Rect& crop = tree.crop();
  std::vector<Rect> rects(tree.sample_count(), Rect{crop.x1, crop.y1, crop.x0, crop.y0});
  if (rects.empty()) return rects;
  for (int y = crop.y0; y < crop.y1; ++y) {
    for (int x = crop.x0; x < crop.x1; ++x) {
      Rect& rect = rects[tree.leaf_at(x, y)];
      rect = {std::min(rect.x0, x), std::min(rect.y0, y), std::max(rect.x1, x + 1),
              std::max(rect.y1, y + 1)};
    }
  }
  return rects;
}

// Refines until the tree has `samples` samples, or all pixels are sampled.
inline void refine(RefinementTree& tree, const Picture& picture, size_t samples = ~size_t(0)) {
  while (!tree.finished() && tree.sample_count() < samples) {
    insert_round(tree, picture, samples - tree.sample_count());
  }
}

inline std::string name_of(const Rect& r) {
  return std::to_string(r.width()) + "x" + std::to_string(r.height()) + " at " +
         std::to_string(r.x0) + "," + std::to_string(r.y0);
}

// Edge cases: one pixel, one row, one column, primes, and windows away from the origin.
inline std::vector<Rect> awkward_windows() {
  return {{0, 0, 1, 1},   {3, 4, 4, 5},    {0, 0, 1, 97},      {-8, 2, 89, 3}, {0, 0, 2, 2},
          {0, 0, 64, 64}, {5, 9, 118, 40}, {-50, -70, 51, 33}, {0, 0, 37, 256}};
}

}  // namespace emberline
