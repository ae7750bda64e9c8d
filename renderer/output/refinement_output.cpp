#include "renderer/output/refinement_output.h"

#include <algorithm>
#include <vector>

#include "io/display/display.h"
#include "io/files/atomic_file.h"
#include "io/image/output.h"
#include "renderer/core/file_suffix.h"
#include "renderer/drivers/adaptive/refinement_tree.h"
#include "renderer/drivers/adaptive/refinement_views.h"

namespace emberline {
namespace {

ByteImage picture_with_leaves(const LivePicture& picture, const RefinementTree& tree,
                              const RenderOptions& options) {
  const Rect& crop = picture.film().rect();
  const auto pixels = size_t(crop.area());
  std::vector<float> rgba(4 * pixels), rgb(3 * pixels);
  picture.resolve(rgba);
  for (size_t i = 0; i < pixels; ++i) std::copy_n(&rgba[4 * i], 3, &rgb[3 * i]);
  DisplayTransform(options.display, options.working_space).apply(rgb.data(), pixels);
  // Over the displayed picture, where borders stand out alike against light and dark.
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
