// Chooses which pixels get their first sample next, as long as some pixels have none. The tree is a
// k-d tree over the image plane that is refined where the picture needs it. It follows Painter &
// Sloan 1989, "Antialiased Ray Tracing by Adaptive Progressive Refinement", SIGGRAPH. The caller
// does the rendering:
//
//   RefinementTree tree(crop, settings);
//   while (!tree.finished()) {
//     wanted = tree.next_round(); // pixels that were never requested before
//     tree.insert(values); // the radiance of each of these pixels, in the same order
//   }
//
// A leaf is a rectangle of whole pixels with one sample: the value of one pixel inside it. A leaf
// is split by a cut in the middle of its longer side. The half that contains the sample keeps it.
// In the other half, a pixel is drawn at random and requested. A leaf of one pixel is finished.
// When all leaves are finished, every pixel has been requested exactly once.
//
// Priorities. A leaf of area a (pixels) has the priority p = a (max(v_int, v_ext) + kappa). v_int
// is the variance of the two samples that the last cut separated; v_ext is the variance of the leaf
// and its neighbours across the middles of its edges. Both are variances of display values (below).
// kappa is the coverage term: where there is no contrast, it makes the largest leaf come first.
// While any leaf is larger than `coverage_area`, only such leaves are split.
//
// Differences from the paper. The paper splits one leaf at a time and finds it by descending from
// the root. Here a round splits many leaves: first all that are larger than `coverage_area`, then
// those that hold a quarter of the total priority. So leaves are read sequentially, and the
// renderer gets many pixels to work on. On the other hand, leaves cannot react to samples of their
// own round. The paper also updates v_int with means that are propagated up the tree. Since there
// is v_ext, this would improve little (tests/bench/results).
//
// Display values. Let x be radiance times exposure, which may be arbitrarily large. It is mapped to
// [0, 1] by x / (1 + x) (Reinhard, Stark, Shirley & Ferwerda 2002) and then by a square root, which
// approximates perception. Each variance is the mean of two variances: that of the luminance, and
// that of the channel that varies most.
//
// The tree is a pure function of crop, settings, limits and values, independent of threads and
// time. It computes contrasts on the calling thread's TBB arena. Only one thread at a time may call
// non-const functions; const functions may be called concurrently.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "renderer/core/hash.h"
#include "renderer/core/rect.h"
#include "renderer/core/vector.h"

namespace emberline {

enum class RefinementPhase : uint8_t {
  kCoverage,    // some leaves are larger than the coverage area
  kFeatures,    // some leaves of two or more pixels have contrast
  kPixelLevel,  // the remaining leaves look flat
  kFinished,    // every leaf is one pixel
};
std::string_view refinement_phase_name(RefinementPhase phase);

// RefinementTree's constructor asserts the ranges given here.
struct RefinementSettings {
  uint32_t seed = 0;            // for the drawn pixels, and the order of equal priorities
  int coverage_area = 16 * 16;  // in pixels, > 0
  // kappa, in squared display values, > 0. With test_picture() (refinement_pictures.h) at a quarter
  // of a sample per pixel, the error is almost the same for any kappa from 1e-4 to 3e-3, but
  // doubles at 1e-2.
  float coverage_weight = 1e-3f;
  // tau, the least v_int or v_ext that counts as a feature: the square of two 8-bit display steps.
  float feature_threshold = square(2.0f / 255);
  float exposure = 1.0f;  // factor on radiance, in (0, 1e6]
};

// A node on the path from the root to a pixel. It explains why the pixel was sampled.
struct RefinementNode {
  Rect rect;
  Rgb mean;  // area-weighted mean of the present leaves inside
  // Values at the time of the split; for a leaf, the present values.
  float v_int = 0, v_ext = 0, priority = 0;
  RefinementPhase phase = RefinementPhase::kCoverage;  // kFinished: a leaf of one pixel
  uint32_t round = 0;  // rounds done before the split; for a leaf, rounds done so far
  bool leaf = false;
};

class RefinementTree {
 public:
  // `crop` is half-open and may be empty. Throws UsageError if a side exceeds 65536 pixels or the
  // area exceeds 2^31 - 1.
  RefinementTree(const Rect& crop, const RefinementSettings& settings);

  const Rect& crop() const { return crop_; }
  const RefinementSettings& settings() const { return settings_; }
  // Returns whether all pixels have been requested and inserted.
  bool finished() const { return phase_ == RefinementPhase::kFinished; }
  RefinementPhase phase() const { return phase_; }
  uint32_t rounds() const { return rounds_; }  // number of rounds inserted so far
  size_t sample_count() const { return leaves_.size(); }

  // Requests first samples. Returns one pixel for each of the most urgent leaves. The pixels are in
  // tree order, so that neighbours in the list are neighbours in the frame. The first round is one
  // pixel. A coverage round splits all leaves that are too large. Any other round splits the most
  // urgent leaves that together hold a quarter of the total priority. Their number is at least a
  // 16th and at most a quarter of the number of leaves that can be split. It is also at least 64
  // and at least a 64th of the number of all samples, even if that is more than a quarter. No round
  // has more than `limit` pixels. Calls must alternate with insert() (asserted), which invalidates
  // the returned span.
  std::span<const Vec2i> next_round(size_t limit = std::numeric_limits<size_t>::max());
  // Takes the radiance of each requested pixel, in the order of next_round(), in linear Rec. 709.
  // NaN and infinity count as black.
  void insert(std::span<const Rgb> values);

  // leaf_at() returns the leaf that covers pixel (x, y) of the crop; leaf_map() returns the leaf of
  // each pixel, in rows from the crop's top. Both are meaningless before the first sample.
  uint32_t leaf_at(int x, int y) const { return leaf_of_pixel_[index(x, y)]; }
  std::span<const uint32_t> leaf_map() const { return leaf_of_pixel_; }
  // Return the value and the sampled pixel of a leaf. Leaves 0 .. sample_count() - 1 are in the
  // order in which their samples were inserted.
  const Rgb& value(uint32_t leaf) const { return leaves_[leaf].value; }
  Vec2i sampled_pixel(uint32_t leaf) const { return pixel_of(leaves_[leaf].pixel); }

  // Returns the nodes from the root to the leaf that covers pixel (x, y) of the crop, or nothing
  // before the first insert(). Reads every pixel of the crop.
  std::vector<RefinementNode> describe(int x, int y) const;

  // most_urgent() returns the first `max_count` leaves of two or more pixels in the order in which
  // they will be split; open_count() returns the number of all such leaves.
  std::vector<RefinementNode> most_urgent(size_t max_count) const;
  size_t open_count() const { return open_leaves_.size(); }
  // Returns the number of leaves with 2^k .. 2^(k+1) - 1 pixels, for k = 0, 1, ...
  std::vector<size_t> leaves_by_area() const;

  // node_bytes() is at most 16 bytes plus 36 bytes for each of the 2 sample_count() - 1 nodes. Once
  // the tree is finished, a node takes only 22 bytes. map_bytes() is 4 bytes per pixel.
  size_t node_bytes() const;
  size_t map_bytes() const { return leaf_of_pixel_.capacity() * sizeof(uint32_t); }

 private:
  struct PixelOffset {
    uint16_t x, y;
  };
  // A rectangle given by its first and last column and row, relative to the crop. The last column
  // is included in the cell, so that 65536 columns fit into 16 bits.
  struct Cell {
    uint16_t x0, y0, x_last, y_last;
    int width() const { return x_last - x0 + 1; }
    int height() const { return y_last - y0 + 1; }
    int64_t area() const { return int64_t(width()) * height(); }
    bool contains(PixelOffset p) const {
      return p.x >= x0 && p.x <= x_last && p.y >= y0 && p.y <= y_last;
    }
  };

  // Four display values of 16 bits each: R, G, B, luminance. They are rounded to integers, so that
  // nearly equal values become exactly equal.
  using Shade [[gnu::vector_size(8)]] = uint16_t;

  struct Leaf {
    Rgb value;
    PixelOffset pixel;  // pixel that was sampled
  };
  // Leaf i has the node id 2 i; split i has the node id 2 i + 1.
  struct Split {
    uint32_t child[2];         // node ids, the one with the smaller coordinates first
    float v_cut;               // variance of the separated samples: v_int of both children
    float v_ext;               // v_ext of the leaf that was split
    uint32_t round_and_phase;  // 4 x round + phase
  };
  // A leaf of two or more pixels, with all data that decides when it is split, so that the list of
  // such leaves can be read sequentially.
  struct OpenLeaf {
    uint32_t leaf;
    uint32_t parent;  // split that created the leaf; kNone for the root
    Cell cell;
    float v_int, v_ext = 0;
    float priority = 0;  // 0 if the current phase does not split this leaf
  };

  size_t index(int x, int y) const {
    return size_t(y - crop_.y0) * size_t(crop_.width()) + size_t(x - crop_.x0);
  }
  // A histogram of the open leaves' priorities, in ascending order: for each bucket, the number of
  // its leaves and the sum of their priorities.
  static constexpr size_t kPriorityBuckets = 2048;
  struct PriorityBuckets {
    std::array<uint32_t, kPriorityBuckets> count = {};
    std::array<double, kPriorityBuckets> sum = {};
  };

  uint32_t root_node() const { return splits_.empty() ? 0 : 1; }  // first split, or the only leaf
  Cell root() const { return {0, 0, uint16_t(crop_.width() - 1), uint16_t(crop_.height() - 1)}; }
  PixelOffset offset_of_pixel(const Vec2i& pixel) const {
    return {uint16_t(pixel.x - crop_.x0), uint16_t(pixel.y - crop_.y0)};
  }
  Vec2i pixel_of(PixelOffset offset) const { return {crop_.x0 + offset.x, crop_.y0 + offset.y}; }
  Rect rect_of(const Cell& cell) const;
  static std::pair<Cell, Cell> halves(const Cell& cell) {
    Cell first = cell, second = cell;
    if (cell.width() >= cell.height()) {
      second.x0 = uint16_t(cell.x0 + cell.width() / 2);
      first.x_last = uint16_t(second.x0 - 1);
    } else {
      second.y0 = uint16_t(cell.y0 + cell.height() / 2);
      first.y_last = uint16_t(second.y0 - 1);
    }
    return {first, second};
  }
  PixelOffset draw_pixel(const Cell& cell) const;
  Shade shade(const Rgb& value) const;
  float external_variance(const Cell& cell, uint32_t leaf) const;
  float priority(int64_t area, float v_int, float v_ext) const {
    return float(area) * (std::max(v_int, v_ext) + settings_.coverage_weight);
  }
  RefinementNode describe(const OpenLeaf& open) const;
  uint32_t descend(uint32_t split, PixelOffset offset, Cell& cell) const;
  Rgb mean_over(const Rect& rect) const;

  // Sort key: the priority, then a hash. If the tree order decided between equal priorities, a flat
  // picture would be refined from one corner to the other.
  uint64_t urgency(const OpenLeaf& open) const {
    return uint64_t(std::bit_cast<uint32_t>(open.priority)) << 32 |
           hash32(open.leaf + hash32(settings_.seed));
  }
  PriorityBuckets sort_priorities() const;
  size_t round_size(const PriorityBuckets& buckets) const;
  void choose_leaves(size_t count, const PriorityBuckets& buckets);
  void add_leaf(PixelOffset pixel, const Rgb& value);
  void split_chosen(std::span<const Rgb> values);
  std::array<OpenLeaf, 2> split(const OpenLeaf& open, PixelOffset pixel, const Rgb& value);
  void assign_cell(const Cell& cell, uint32_t leaf);
  void update_priorities();

  Rect crop_;
  RefinementSettings settings_;
  RefinementPhase phase_ = RefinementPhase::kCoverage;
  uint32_t rounds_ = 0;

  std::vector<Leaf> leaves_;
  std::vector<Shade> shade_;             // display values of the leaves
  std::vector<Split> splits_;            // the root is the first
  std::vector<uint32_t> leaf_of_pixel_;  // for each pixel of the crop, the leaf that covers it

  std::vector<OpenLeaf> open_leaves_;  // in the order of the tree, depth first
  size_t eligible_ = 0;                // number of open leaves that the current phase splits
  // The current round: ascending positions in open_leaves_, and the requested pixels.
  std::vector<uint32_t> chosen_leaves_;
  std::vector<Vec2i> requested_;
};

}  // namespace emberline
