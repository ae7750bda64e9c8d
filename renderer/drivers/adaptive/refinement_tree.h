// Which pixel gets its first sample next, below one sample per pixel: a k-d tree over the image
// plane that is refined where the picture needs it, after Painter & Sloan 1989, "Antialiased Ray
// Tracing by Adaptive Progressive Refinement", SIGGRAPH. No rendering happens here:
//
//   RefinementTree tree(crop, settings);
//   while (!tree.finished()) {
//     wanted = tree.next_round();       // pixels, each for the first time
//     tree.insert(values);              // one radiance for each of them, in their order
//   }
//
// A leaf is a rectangle of whole pixels that holds one sample: the value of one pixel inside it. To
// split a leaf, its longer side is cut in the middle; the half that holds the sample keeps it, a
// pixel drawn in the other half is asked for. A leaf of one pixel is finished; when all are, every
// pixel was asked for exactly once.
//
// Priorities. Leaf of area a (pixels): p = a (max(v_int, v_ext) + kappa). v_int is the variance of
// the two samples that the last cut parted, v_ext that of the leaf and what lies across the middles
// of its edges; both of display values (below). kappa is the coverage term: without contrast the
// largest leaf goes first. While a leaf is larger than `coverage_area`, only such leaves are split.
//
// Where this departs from the paper: it splits one leaf at a time and finds it by descending from
// the root; here a round splits many leaves, all that are too large for coverage, then those that
// hold a quarter of all priority, so that they are read in one stream and the renderer gets many
// pixels to work on. Leaves cannot react to samples of their own round. And its v_int is kept up to
// date by means that are pulled up the tree, which gains little with v_ext beside it
// (tests/bench/results/adaptive.md).
//
// Display values: radiance x exposure through x / (1 + x) (Reinhard, Stark, Shirley & Ferwerda
// 2002) and a square root for the eye, so they lie in [0, 1] however bright a light is. A variance
// is the mean of two: of the luminance, and of the channel that varies most.
//
// The tree is a pure function of crop, settings, limits and values: neither threads nor time
// enter. Contrasts are computed on the calling thread's TBB arena. One caller at a time; const
// functions may be called concurrently.
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
  kCoverage,    // some leaf is larger than the coverage area
  kFeatures,    // some leaf of two pixels or more has contrast
  kPixelLevel,  // what is left to split looks flat
  kFinished,    // every leaf is a pixel
};
std::string_view refinement_phase_name(RefinementPhase phase);

// Ranges are asserted.
struct RefinementSettings {
  uint32_t seed = 0;            // of the pixels drawn, and of the order among equals
  int coverage_area = 16 * 16;  // in pixels, > 0
  // kappa, in squared display values, > 0. Chosen on test_picture() of refinement_pictures.h: from
  // 1e-4 to 3e-3 the error at a quarter sample per pixel hardly changes, at 1e-2 it is twice that.
  float coverage_weight = 1e-3f;
  // tau: a contrast from here on counts as a feature. Two steps of an 8-bit display, squared.
  float feature_threshold = square(2.0f / 255);
  float exposure = 1.0f;  // factor on radiance, in (0, 1e6]
};

// A node on the way to a pixel, for people who ask why it was sampled.
struct RefinementNode {
  Rect rect;
  Rgb mean;  // area-weighted, of the leaves inside as they are now
  // At the time it was split; of a leaf, as they are now.
  float v_int = 0, v_ext = 0, priority = 0;
  RefinementPhase phase = RefinementPhase::kCoverage;  // kFinished: a leaf of one pixel
  uint32_t round = 0;  // rounds done when it was split; of a leaf, the number of rounds done
  bool leaf = false;
};

class RefinementTree {
 public:
  // Pixels of `crop`, half-open; may be empty. Throws UsageError for a side above 65536 pixels or
  // an area above 2^31 - 1.
  RefinementTree(const Rect& crop, const RefinementSettings& settings);

  const Rect& crop() const { return crop_; }
  const RefinementSettings& settings() const { return settings_; }
  // All pixels have been asked for and inserted.
  bool finished() const { return phase_ == RefinementPhase::kFinished; }
  RefinementPhase phase() const { return phase_; }
  uint32_t rounds() const { return rounds_; }  // inserted so far
  size_t sample_count() const { return leaf_.size(); }

  // The pixels whose first sample is wanted, those of the best leaves, listed in the order of the
  // tree, so that neighbours in the list are neighbours in the frame. The first round is one pixel;
  // a coverage round is all leaves that are too large; others are the leaves that hold a quarter of
  // all priority, but between a 16th and a quarter of the leaves that can be split, and at least 64
  // and a 64th of all samples. Never more than `limit`. Calls alternate with insert() (asserted);
  // the span is valid until then.
  std::span<const Vec2i> next_round(size_t limit = std::numeric_limits<size_t>::max());
  // The radiances of the pixels wanted, linear Rec. 709. A NaN or an infinity is black.
  void insert(std::span<const Rgb> values);

  // The leaf that covers pixel (x, y) of the crop; and of all its pixels, rows from its top.
  // Meaningless before the first sample.
  uint32_t leaf_at(int x, int y) const { return owner_[index(x, y)]; }
  std::span<const uint32_t> leaf_map() const { return owner_; }
  // Leaves, 0 .. sample_count() - 1, in the order in which their samples came.
  const Rgb& value(uint32_t leaf) const { return leaf_[leaf].value; }
  Vec2i sampled_pixel(uint32_t leaf) const { return pixel_of(leaf_[leaf].pixel); }

  // The nodes from the root to the leaf that covers pixel (x, y) of the crop. Costs a look at
  // every pixel of the crop; nothing before the first insert().
  std::vector<RefinementNode> describe(int x, int y) const;

  // The first `most` leaves of two pixels or more, in the order in which they will be split, and
  // how many there are.
  std::vector<RefinementNode> most_urgent(size_t most) const;
  size_t open_count() const { return open_.size(); }
  // How many leaves have 2^k .. 2^(k+1) - 1 pixels, for k = 0, 1, ...
  std::vector<size_t> leaves_by_area() const;

  // Of the nodes: at most 36 bytes for each of the 2 sample_count() - 1, and 16; 22 for each in the
  // end. And of the map from pixels to leaves: 4 a pixel.
  size_t node_bytes() const;
  size_t map_bytes() const { return owner_.capacity() * sizeof(uint32_t); }

 private:
  struct Place {
    uint16_t x, y;
  };
  // A rectangle by its first and last column and row, relative to the crop: 65536 fit.
  struct Cell {
    uint16_t x0, y0, x_last, y_last;
    int width() const { return x_last - x0 + 1; }
    int height() const { return y_last - y0 + 1; }
    int64_t area() const { return int64_t(width()) * height(); }
    bool contains(Place p) const {
      return p.x >= x0 && p.x <= x_last && p.y >= y0 && p.y <= y_last;
    }
  };

  // Four display values in 16 bits: R, G, B, luminance. Integers, so that equal is exactly equal.
  using Shade [[gnu::vector_size(8)]] = uint16_t;

  struct Leaf {
    Rgb value;
    Place pixel;  // of the sample
  };
  // Node ids: leaf i is 2 i, split i is 2 i + 1.
  struct Split {
    uint32_t child[2];  // nodes; the one with the smaller coordinates first
    float v_cut;        // variance of the samples parted: v_int of both children
    float v_ext;        // of the leaf that it was
    uint32_t when;      // 4 x round + phase
  };
  // A leaf of two pixels or more, with all that decides when it is split: read in order.
  struct Open {
    uint32_t leaf;
    uint32_t parent;  // the split that made it; none of the root
    Cell cell;
    float v_int, v_ext = 0;
    float priority = 0;  // stays 0 where the phase does not split
  };

  size_t index(int x, int y) const {
    return size_t(y - crop_.y0) * size_t(crop_.width()) + size_t(x - crop_.x0);
  }
  // The open leaves by priority, ascending: how many, and the sum of their priorities.
  static constexpr size_t kPriorityBuckets = 2048;
  struct PriorityBuckets {
    std::array<uint32_t, kPriorityBuckets> count = {};
    std::array<double, kPriorityBuckets> sum = {};
  };

  uint32_t root_node() const { return split_.empty() ? 0 : 1; }  // the first leaf, or split
  Cell root() const { return {0, 0, uint16_t(crop_.width() - 1), uint16_t(crop_.height() - 1)}; }
  Place place_of(const Vec2i& pixel) const {
    return {uint16_t(pixel.x - crop_.x0), uint16_t(pixel.y - crop_.y0)};
  }
  Vec2i pixel_of(Place place) const { return {crop_.x0 + place.x, crop_.y0 + place.y}; }
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
  Place draw_pixel(const Cell& cell) const;
  Shade shade(const Rgb& value) const;
  float external_variance(const Cell& cell, uint32_t leaf) const;
  float priority(int64_t area, float v_int, float v_ext) const {
    return float(area) * (std::max(v_int, v_ext) + settings_.coverage_weight);
  }
  RefinementNode describe(const Open& open) const;
  uint32_t descend(uint32_t split, Place place, Cell& cell) const;
  Rgb mean_over(const Rect& rect) const;

  // By priority; equals in the order of a hash: in the order of the tree, a flat picture would be
  // refined from one corner to the other.
  uint64_t urgency(const Open& open) const {
    return uint64_t(std::bit_cast<uint32_t>(open.priority)) << 32 |
           hash32(open.leaf + hash32(settings_.seed));
  }
  PriorityBuckets sort_priorities() const;
  size_t round_size(const PriorityBuckets& buckets) const;
  void choose(size_t count, const PriorityBuckets& buckets);
  void add_leaf(Place pixel, const Rgb& value);
  void split_chosen(std::span<const Rgb> values);
  std::array<Open, 2> split(const Open& open, Place pixel, const Rgb& value);
  void own_cell(const Cell& cell, uint32_t leaf);
  void evaluate();

  Rect crop_;
  RefinementSettings settings_;
  RefinementPhase phase_ = RefinementPhase::kCoverage;
  uint32_t rounds_ = 0;

  std::vector<Leaf> leaf_;
  std::vector<Shade> shade_;     // of the leaves' values
  std::vector<Split> split_;     // the root is the first
  std::vector<uint32_t> owner_;  // by pixel of the crop: the leaf that covers it

  std::vector<Open> open_;  // in the order of the tree, depth first
  size_t eligible_ = 0;     // how many of them the phase splits
  // The round under way: positions in open_, ascending, and the pixels wanted of them.
  std::vector<uint32_t> chosen_;
  std::vector<Vec2i> wanted_;
};

}  // namespace emberline
