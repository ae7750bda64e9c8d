#include "renderer/drivers/adaptive/refinement_tree.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cassert>
#include <functional>
#include <string>

#include "renderer/core/color4.h"
#include "renderer/core/errors.h"
#include "renderer/core/hash.h"
#include "renderer/core/parallel.h"

namespace emberline {
namespace {

constexpr uint32_t kNone = ~0u;
constexpr int kMaxSide = 65536;                         // limited by RefinementTree::Cell
constexpr int64_t kMaxPixels = (int64_t(1) << 31) - 1;  // each pixel takes two node ids

// A round splits the most urgent leaves that together hold the fraction kRoundPriority of the total
// priority. While contrast is concentrated, these are few leaves, so that the next round can react
// soon. If all leaves look alike, these are many. Their number is at least 1 / kMinRoundDivisor and
// at most 1 / kMaxRoundDivisor of the leaves that can be split, so that a sample costs at most 16
// evaluations of leaves. It is also at least kMinRoundSize and at least 1 / kMinRoundDivisorOfAll
// of all samples, even if that is above the upper limit, so that the last rounds are not many small
// ones. tests/bench/results shows how other values affect error and speed.
constexpr double kRoundPriority = 0.25;
constexpr size_t kMinRoundDivisor = 16, kMaxRoundDivisor = 4, kMinRoundDivisorOfAll = 64;
constexpr size_t kMinRoundSize = 64;

constexpr float kMaxRadiance = 1e30f, kMaxExposure = 1e6f;

// A parent is prefetched this many splits ahead, since parents are seldom in the caches.
constexpr size_t kPrefetchDistance = 8;

// Number of leaves for which memory is reserved at the start: one for each pixel of a 4K frame.
constexpr size_t kReserved = size_t(3840) * 2160;

// Leaves per task when contrasts are computed: about 0.1 ms.
constexpr size_t kGrain = 4096;

constexpr bool is_leaf(uint32_t node) { return node % 2 == 0; }
constexpr uint32_t leaf_node(uint32_t leaf) { return 2 * leaf; }
constexpr uint32_t split_node(uint32_t split) { return 2 * split + 1; }

// The bits of non-negative floats sort like the floats. Dropping the last 20 bits leaves eight
// buckets per octave.
size_t bucket_of(float priority) { return std::bit_cast<uint32_t>(priority) >> 20; }

// Converts through 32-bit integers, because GCC 12 converts 32-bit integers as a vector, but 16-bit
// integers one by one.
using Int4 [[gnu::vector_size(16)]] = int32_t;
Color4 to_color4(auto shade) {
  return __builtin_convertvector(__builtin_convertvector(shade, Int4), Color4);
}

// Takes the variances of a shade's four components. Returns the mean of the luminance's variance
// and the largest channel variance, in display units.
float combine_variances(Color4 variance) {
  const float channels = std::max(variance[0], std::max(variance[1], variance[2]));
  return 0.5f * (variance[3] + channels) * square(1.0f / 65535);
}

}  // namespace

std::string_view refinement_phase_name(RefinementPhase phase) {
  constexpr std::string_view kNames[] = {"coverage", "features", "pixel level", "finished"};
  return kNames[size_t(phase)];
}

RefinementTree::RefinementTree(const Rect& crop, const RefinementSettings& settings)
    : crop_(crop), settings_(settings) {
  assert(settings.coverage_area > 0 && settings.coverage_weight > 0);
  assert(settings.exposure > 0 && settings.exposure <= kMaxExposure);
  if (crop.width() > kMaxSide || crop.height() > kMaxSide || crop.area() > kMaxPixels) {
    throw UsageError("a frame of " + std::to_string(crop.width()) + "x" +
                     std::to_string(crop.height()) +
                     " pixels is too large for adaptive refinement; the limits are 65536 pixels "
                     "per side and 2147483647 pixels in total");
  }
  if (crop.empty()) phase_ = RefinementPhase::kFinished;
  const auto pixels = size_t(crop.area());
  leaf_of_pixel_.resize(pixels, 0);
  // Reserves the arrays so that growing needs no copies. Memory is committed only when first
  // written.
  leaves_.reserve(std::min(pixels, kReserved));
  shade_.reserve(std::min(pixels, kReserved));
  splits_.reserve(std::min(pixels, kReserved));
}

std::span<const Vec2i> RefinementTree::next_round(size_t limit) {
  assert(requested_.empty());
  if (finished() || limit == 0) return {};
  if (leaves_.empty()) {
    requested_.push_back(pixel_of(draw_pixel(root())));
    return requested_;
  }
  const PriorityBuckets buckets = sort_priorities();
  const size_t count = std::min(limit, round_size(buckets));
  choose_leaves(count, buckets);
  requested_.resize(count);
  parallel_ranges(count, kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const OpenLeaf& open = open_leaves_[chosen_leaves_[i]];
      const auto [first, second] = halves(open.cell);
      const bool sampled_first = first.contains(leaves_[open.leaf].pixel);
      requested_[i] = pixel_of(draw_pixel(sampled_first ? second : first));
    }
  });
  return requested_;
}

RefinementTree::PriorityBuckets RefinementTree::sort_priorities() const {
  PriorityBuckets buckets;
  for (const OpenLeaf& open : open_leaves_) {
    ++buckets.count[bucket_of(open.priority)];
    buckets.sum[bucket_of(open.priority)] += double(open.priority);
  }
  return buckets;
}

size_t RefinementTree::round_size(const PriorityBuckets& buckets) const {
  if (phase_ == RefinementPhase::kCoverage) return eligible_;
  double remaining = 0;
  for (const double sum : buckets.sum) remaining += kRoundPriority * sum;
  size_t count = 0, i = kPriorityBuckets - 1;
  for (; buckets.sum[i] < remaining; --i) {
    count += buckets.count[i];
    remaining -= buckets.sum[i];
  }
  if (remaining > 0) count += size_t(std::ceil(remaining / buckets.sum[i] * buckets.count[i]));
  const size_t smallest = std::max({kMinRoundSize, open_leaves_.size() / kMinRoundDivisor,
                                    leaves_.size() / kMinRoundDivisorOfAll});
  const size_t largest = std::max(smallest, open_leaves_.size() / kMaxRoundDivisor);
  return std::min(open_leaves_.size(), std::clamp(count, smallest, largest));
}

void RefinementTree::insert(std::span<const Rgb> values) {
  assert(values.size() == requested_.size());
  if (requested_.empty()) return;
  if (leaves_.empty()) {
    add_leaf(offset_of_pixel(requested_[0]), values[0]);
    if (crop_.area() > 1) open_leaves_.push_back({0, kNone, root(), 0.0f});
  } else {
    split_chosen(values);
  }
  chosen_leaves_.clear();
  requested_.clear();
  ++rounds_;
  update_priorities();
}

// Works in place. First moves the open leaves towards the end of the list by the number of splits.
// Each split adds at most one open leaf, so writing from the start never overtakes reading.
void RefinementTree::split_chosen(std::span<const Rgb> values) {
  const size_t before = open_leaves_.size(), shift = chosen_leaves_.size();
  open_leaves_.resize(before + shift);
  std::copy_backward(open_leaves_.begin(), open_leaves_.begin() + std::ptrdiff_t(before),
                     open_leaves_.end());
  size_t written = 0, next = 0;
  for (size_t position = 0; position < before; ++position) {
    const OpenLeaf open = open_leaves_[position + shift];
    if (next == chosen_leaves_.size() || chosen_leaves_[next] != position) {
      open_leaves_[written++] = open;
      continue;
    }
    if (next + kPrefetchDistance < shift) {
      __builtin_prefetch(
          &splits_[open_leaves_[chosen_leaves_[next + kPrefetchDistance] + shift].parent], 1);
    }
    for (const OpenLeaf& half : split(open, offset_of_pixel(requested_[next]), values[next])) {
      if (half.cell.area() > 1) open_leaves_[written++] = half;
    }
    ++next;
  }
  open_leaves_.resize(written);
}

// Writes the positions of the `count` most urgent open leaves to chosen_leaves_, ascending.
void RefinementTree::choose_leaves(size_t count, const PriorityBuckets& buckets) {
  size_t last_bucket = kPriorityBuckets - 1;  // the bucket of the last chosen leaf
  size_t missing = count;
  while (buckets.count[last_bucket] < missing) missing -= buckets.count[last_bucket--];

  std::vector<uint64_t> keys;
  keys.reserve(buckets.count[last_bucket]);
  for (const OpenLeaf& open : open_leaves_) {
    if (bucket_of(open.priority) == last_bucket) keys.push_back(urgency(open));
  }
  const auto last = keys.begin() + std::ptrdiff_t(missing) - 1;
  std::nth_element(keys.begin(), last, keys.end(), std::greater<>());
  for (size_t i = 0; i < open_leaves_.size(); ++i) {
    const size_t bucket = bucket_of(open_leaves_[i].priority);
    if (bucket > last_bucket || (bucket == last_bucket && urgency(open_leaves_[i]) >= *last)) {
      chosen_leaves_.push_back(uint32_t(i));
    }
  }
}

void RefinementTree::add_leaf(PixelOffset pixel, const Rgb& value) {
  const Rgb finite = is_finite(value) ? value : Rgb(0.0f);
  leaves_.push_back({finite, pixel});
  shade_.push_back(shade(finite));
}

// Splits a leaf. The half that contains the leaf's sample keeps it; the other half gets the new
// sample. Returns the halves, the one with the smaller coordinates first.
std::array<RefinementTree::OpenLeaf, 2> RefinementTree::split(const OpenLeaf& open,
                                                              PixelOffset pixel, const Rgb& value) {
  const auto new_split = uint32_t(splits_.size()), new_leaf = uint32_t(leaves_.size());
  add_leaf(pixel, value);
  if (open.parent != kNone) {
    uint32_t* const child = splits_[open.parent].child;
    child[child[0] == leaf_node(open.leaf) ? 0 : 1] = split_node(new_split);
  }

  const Color4 difference = to_color4(shade_[open.leaf]) - to_color4(shade_[new_leaf]);
  const float v_cut = combine_variances(0.5f * difference * difference);
  const auto [first, second] = halves(open.cell);
  const bool is_new_leaf_first = first.contains(pixel);
  assign_cell(is_new_leaf_first ? first : second, new_leaf);
  const uint32_t a = is_new_leaf_first ? new_leaf : open.leaf,
                 b = is_new_leaf_first ? open.leaf : new_leaf;
  splits_.push_back(
      {{leaf_node(a), leaf_node(b)}, v_cut, open.v_ext, 4 * rounds_ + uint32_t(phase_)});
  return {OpenLeaf{a, new_split, first, v_cut}, OpenLeaf{b, new_split, second, v_cut}};
}

void RefinementTree::assign_cell(const Cell& cell, uint32_t leaf) {
  const size_t stride = size_t(crop_.width());
  uint32_t* row = leaf_of_pixel_.data() + cell.y0 * stride + cell.x0;
  for (int y = 0; y < cell.height(); ++y, row += stride) std::fill_n(row, cell.width(), leaf);
}

// Updates the variances and priorities of the open leaves, and the phase.
void RefinementTree::update_priorities() {
  const auto large = [&](const OpenLeaf& o) { return o.cell.area() > settings_.coverage_area; };
  const size_t too_large = phase_ == RefinementPhase::kCoverage
                               ? size_t(std::ranges::count_if(open_leaves_, large))
                               : 0;  // once it is 0, it stays 0: leaves only shrink
  std::atomic<bool> features{false};
  parallel_ranges(open_leaves_.size(), kGrain, [&](size_t begin, size_t end) {
    bool has_feature = false;
    for (size_t i = begin; i < end; ++i) {
      OpenLeaf& open = open_leaves_[i];
      open.v_ext = external_variance(open.cell, open.leaf);
      open.priority =
          too_large > 0 && !large(open) ? 0.0f : priority(open.cell.area(), open.v_int, open.v_ext);
      has_feature |= std::max(open.v_int, open.v_ext) >= settings_.feature_threshold;
    }
    if (has_feature) features.store(true, std::memory_order_relaxed);
  });
  eligible_ = too_large > 0 ? too_large : open_leaves_.size();
  phase_ = open_leaves_.empty() ? RefinementPhase::kFinished
           : too_large > 0      ? RefinementPhase::kCoverage
           : features           ? RefinementPhase::kFeatures
                                : RefinementPhase::kPixelLevel;
}

// Returns the variance of the display values of the leaf and its neighbours across the middles of
// its edges.
float RefinementTree::external_variance(const Cell& c, uint32_t leaf) const {
  const Color4 own = to_color4(shade_[leaf]);
  const size_t stride = size_t(crop_.width());
  const uint32_t* const middle_row = leaf_of_pixel_.data() + size_t(c.y0 + c.y_last) / 2 * stride;
  const uint32_t* const middle_column = leaf_of_pixel_.data() + (c.x0 + c.x_last) / 2;
  Color4 sum = splat4(0.0f), squares = splat4(0.0f);
  float count = 1;
  const auto add_neighbour = [&](const uint32_t* neighbour) {
    const Color4 d = to_color4(shade_[*neighbour]) - own;
    sum += d;
    squares += d * d;
    count += 1;
  };
  if (c.x0 > 0) add_neighbour(middle_row + c.x0 - 1);
  if (c.x_last + 1 < crop_.width()) add_neighbour(middle_row + c.x_last + 1);
  if (c.y0 > 0) add_neighbour(middle_column + (c.y0 - 1) * stride);
  if (c.y_last + 1 < crop_.height()) add_neighbour(middle_column + (c.y_last + 1) * stride);
  return count > 1 ? combine_variances((squares - sum * sum / count) / (count - 1)) : 0.0f;
}

RefinementTree::Shade RefinementTree::shade(const Rgb& value) const {
  Color4 x = color4(value, luminance(value));
  x = x > 0.0f ? x : splat4(0.0f);
  x = x < kMaxRadiance ? x : splat4(kMaxRadiance);  // keeps x * exposure and the quotient finite
  x *= settings_.exposure;
  x /= 1.0f + x;
  for (int i = 0; i < 4; ++i) x[i] = std::sqrt(x[i]);
  return __builtin_convertvector(__builtin_convertvector(x * 65535.0f + 0.5f, Int4), Shade);
}

// A cell's sampled pixel depends only on the seed and the cell, not on earlier splits.
RefinementTree::PixelOffset RefinementTree::draw_pixel(const Cell& cell) const {
  const uint64_t h = hash_combine64(hash64(settings_.seed), std::bit_cast<uint64_t>(cell));
  const auto uniform_below = [](uint64_t bits, int count) {  // uniform to within a relative 2^-16
    return uint16_t((bits & 0xffffffffu) * uint64_t(count) >> 32);
  };
  return {uint16_t(cell.x0 + uniform_below(h, cell.width())),
          uint16_t(cell.y0 + uniform_below(h >> 32, cell.height()))};
}

Rect RefinementTree::rect_of(const Cell& cell) const {
  return {crop_.x0 + cell.x0, crop_.y0 + cell.y0, crop_.x0 + cell.x_last + 1,
          crop_.y0 + cell.y_last + 1};
}

uint32_t RefinementTree::descend(uint32_t split, PixelOffset offset, Cell& cell) const {
  const auto [first, second] = halves(cell);
  const bool in_first = first.contains(offset);
  cell = in_first ? first : second;
  return splits_[split / 2].child[in_first ? 0 : 1];
}

std::vector<RefinementNode> RefinementTree::describe(int x, int y) const {
  assert(crop_.contains(x, y));
  std::vector<RefinementNode> steps;
  if (leaves_.empty()) return steps;
  Cell cell = root();
  float v_int = 0;
  uint32_t node = root_node();
  while (!is_leaf(node)) {
    const Split& s = splits_[node / 2];
    steps.push_back({rect_of(cell), mean_over(rect_of(cell)), v_int, s.v_ext,
                     priority(cell.area(), v_int, s.v_ext), RefinementPhase(s.round_and_phase % 4),
                     s.round_and_phase / 4, false});
    v_int = s.v_cut;
    node = descend(node, offset_of_pixel({x, y}), cell);
  }
  const float v_ext = external_variance(cell, node / 2);
  const bool done = cell.area() == 1;
  steps.push_back({rect_of(cell), leaves_[node / 2].value, v_int, v_ext,
                   done ? 0.0f : priority(cell.area(), v_int, v_ext),
                   done ? RefinementPhase::kFinished : phase_, rounds_, true});
  return steps;
}

RefinementNode RefinementTree::describe(const OpenLeaf& open) const {
  return {rect_of(open.cell), value(open.leaf), open.v_int, open.v_ext,
          open.priority,      phase_,           rounds_,    true};
}

std::vector<RefinementNode> RefinementTree::most_urgent(size_t max_count) const {
  const auto urgency_of = [&](const OpenLeaf& open) { return urgency(open); };
  std::vector<OpenLeaf> best(std::min(max_count, open_leaves_.size()));
  std::ranges::partial_sort_copy(open_leaves_, best, std::greater<>(), urgency_of, urgency_of);
  std::vector<RefinementNode> steps;
  steps.reserve(best.size());
  for (const OpenLeaf& open : best) steps.push_back(describe(open));
  return steps;
}

std::vector<size_t> RefinementTree::leaves_by_area() const {
  std::vector<size_t> counts(leaves_.empty() ? 0 : 1, leaves_.size() - open_leaves_.size());
  for (const OpenLeaf& open : open_leaves_) {
    const auto log2 = size_t(std::bit_width(uint64_t(open.cell.area())) - 1);
    counts.resize(std::max(counts.size(), log2 + 1));
    ++counts[log2];
  }
  return counts;
}

Rgb RefinementTree::mean_over(const Rect& rect) const {
  Vec3d sum(0.0);
  for (int y = rect.y0; y < rect.y1; ++y) {
    for (int x = rect.x0; x < rect.x1; ++x) sum += to_double(value(leaf_at(x, y)));
  }
  return to_float(sum / double(rect.area()));
}

size_t RefinementTree::node_bytes() const {
  return leaves_.size() * (sizeof(Leaf) + sizeof(Shade)) + splits_.size() * sizeof(Split) +
         open_leaves_.size() * sizeof(OpenLeaf);
}

}  // namespace emberline
