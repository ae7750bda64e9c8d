#include "renderer/output/refinement_output.h"

#include <algorithm>
#include <cassert>
#include <nlohmann/json.hpp>
#include <vector>

#include "io/display/display.h"
#include "io/files/atomic_file.h"
#include "io/image/output.h"
#include "renderer/core/file_suffix.h"
#include "renderer/core/parallel.h"
#include "renderer/drivers/adaptive/refinement_tree.h"

namespace emberline {
namespace {

// Rows per task; one task takes about 0.1 ms.
constexpr size_t kRowGrain = 16;

const Rgb kBorder(1.0f, 0.25f, 0.02f);  // orange: rare in pictures, visible on bright and dark
constexpr float kBorderOpacity = 0.5f;

ByteImage picture_with_leaves(const LivePicture& picture, const RefinementTree& tree,
                              const RenderOptions& options) {
  const Rect& crop = picture.rect();
  const auto pixels = size_t(crop.area());
  std::vector<float> rgba(4 * pixels), rgb(3 * pixels);
  picture.resolve(rgba);
  for (size_t i = 0; i < pixels; ++i) std::copy_n(&rgba[4 * i], 3, &rgb[3 * i]);
  DisplayTransform(options.display, options.working_space).apply(rgb.data(), pixels);
  // Borders are drawn after the display transform, so that they are equally visible on bright and
  // dark pixels.
  for (size_t i = 0; i < pixels; ++i) std::copy_n(&rgb[3 * i], 3, &rgba[4 * i]);
  draw_leaf_borders(tree, rgba, crop.width());
  ByteImage image;
  image.width = crop.width();
  image.height = crop.height();
  image.values.reserve(3 * pixels);
  for (size_t i = 0; i < pixels; ++i) {
    for (size_t c = 0; c < 3; ++c) image.values.push_back(to_byte(rgba[4 * i + c]));
  }
  return image;
}

}  // namespace

void draw_leaf_borders(const RefinementTree& tree, std::span<float> rgba, int width) {
  const int w = tree.crop().width(), h = tree.crop().height();
  assert(width >= w && rgba.size() >= size_t(width) * size_t(h) * 4);
  if (tree.sample_count() == 0) return;
  const auto leaf = [&](int x, int y) {
    return tree.leaf_map()[size_t(y) * size_t(w) + size_t(x)];
  };
  parallel_ranges(size_t(h), kRowGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin * size_t(w); i < end * size_t(w); ++i) {
      const int x = int(i % size_t(w)), y = int(i / size_t(w));
      const auto same = [&](int nx, int ny) {
        return nx >= 0 && nx < w && ny >= 0 && ny < h && leaf(nx, ny) == leaf(x, y);
      };
      const bool left = same(x - 1, y), above = same(x, y - 1);
      const bool alone = !left && !above && !same(x + 1, y) && !same(x, y + 1);
      if ((left && above) || alone) continue;
      float* const pixel = rgba.data() + 4 * (size_t(y) * size_t(width) + size_t(x));
      for (int c = 0; c < 3; ++c) pixel[c] = lerp(pixel[c], kBorder[c], kBorderOpacity);
    }
  });
}

std::string refinement_json(const RefinementTree& tree, size_t max_leaves) {
  using Json = nlohmann::ordered_json;
  const auto rect = [](const Rect& r) { return Json{r.x0, r.y0, r.x1, r.y1}; };
  const RefinementSettings& settings = tree.settings();
  Json json;
  json["window"] = rect(tree.crop());
  json["phase"] = refinement_phase_name(tree.phase());
  json["rounds"] = tree.rounds();
  json["samples"] = tree.sample_count();
  json["pixels"] = tree.crop().area();
  json["settings"] = {{"seed", settings.seed},
                      {"coverage_area", settings.coverage_area},
                      {"coverage_weight", settings.coverage_weight},
                      {"feature_threshold", settings.feature_threshold},
                      {"exposure", settings.exposure}};
  json["leaves_by_area"] = tree.leaves_by_area();
  json["open"] = tree.open_count();
  json["next"] = Json::array();
  for (const RefinementNode& leaf : tree.most_urgent(max_leaves)) {
    json["next"].push_back({{"rect", rect(leaf.rect)},
                            {"value", {leaf.mean.x, leaf.mean.y, leaf.mean.z}},
                            {"v_int", leaf.v_int},
                            {"v_ext", leaf.v_ext},
                            {"priority", leaf.priority}});
  }
  return json.dump(1);
}

void write_refinement(const RenderOptions& options, const RenderJob& rendered,
                      WriteAttempts& attempts) {
  if (options.trees.empty()) return;
  const RefinementTree& tree = *rendered.facts().tree;
  for (const std::string& path : options.trees) {
    attempts.attempt(path, [&] {
      if (is_json(path)) {
        write_file_atomically(path, refinement_json(tree));
      } else {
        write_image(path, picture_with_leaves(*rendered.picture(), tree, options));
      }
    });
  }
}

}  // namespace emberline
