#include "renderer/film/film_layout.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <iterator>
#include <type_traits>

#include "renderer/film/finite_float.h"
#include "renderer/film/half_sums.h"
#include "renderer/film/path_layers.h"
#include "renderer/film/pixel_stop.h"

namespace emberline {
namespace {

using Part = FilmLayout::Part;

// ---- Blocks. merge() adds another film's sums of the pixel; is_valid() returns whether samples
// can have produced the sums; add() adds a sample, which counts as black unless `finite` is true.

struct PixelBlock : PixelSums {
  void merge(const PixelSums& more) {
    for (int half = 0; half < 2; ++half) {
      for (int c = 0; c < 3; ++c) rgb[half][c] += more.rgb[half][c];
      count[half] += more.count[half];
    }
    alpha += more.alpha;
    non_finite += more.non_finite;
    if (id == 0) id = more.id;
  }
  bool is_valid() const {
    constexpr uint32_t kMaxSamples = 1u << 25;  // per stream
    return count[0] <= kMaxSamples && count[1] <= kMaxSamples &&
           non_finite <= count[0] + count[1] && all_finite(&rgb[0][0], 6) && std::isfinite(alpha);
  }
};

struct Squares {
  double rgb[3];
  void add(const FilmSample& sample, bool finite) {
    const Rgb value = sample.value.radiance * sample.filter_weight;
    for (int c = 0; finite && c < 3; ++c) rgb[c] = fma(double(value[c]), double(value[c]), rgb[c]);
  }
  void merge(const Squares& more) {
    for (int c = 0; c < 3; ++c) rgb[c] += more.rgb[c];
  }
  bool is_valid() const { return all_finite(rgb); }
};

struct Rays {
  uint32_t count;
  void add(const FilmSample& sample, bool) { count += sample.value.rays.total(); }
  void merge(const Rays& more) { count += more.count; }
  bool is_valid() const { return true; }
};

struct Velocities : VelocitySums {
  void add(const FilmSample& sample, bool finite) {
    const FirstHit& hit = sample.value.first_hit;
    if (finite) merge({double(hit.velocity.x), double(hit.velocity.y), 1, hit.hit ? 1u : 0u});
  }
  void merge(const VelocitySums& more) {
    if (more.surfaces_only > surfaces_only) static_cast<VelocitySums&>(*this) = {0.0, 0.0, 0, 1};
    if (more.surfaces_only < surfaces_only) return;
    x += more.x;
    y += more.y;
    count += more.count;
  }
  bool is_valid() const { return std::isfinite(x) && std::isfinite(y) && surfaces_only <= 1; }
};

struct Seconds {
  float seconds;
  void merge(const Seconds& more) { seconds += more.seconds; }
  bool is_valid() const { return std::isfinite(seconds); }
};

struct Stop {
  uint8_t value;
  void merge(const Stop& more) { value = more.value; }
  bool is_valid() const { return true; }  // every byte encodes a reason and a channel
};

struct Halves : HalfSums {
  void add(const FilmSample& sample, bool finite) {
    if (!finite) return;
    if (sample.features) add_features(sample.half, *sample.features);
    if (sample.shares) add_shares(sample.half, sample.value.radiance, *sample.shares);
  }
};

// The sums of a part's rows, and the number of hits if the part has hits_only.
struct RowBlock {
  const Part& part;
  double* sums;
  uint32_t* hits;

  RowBlock(const FilmLayout&, const Part& of, const FilmPixel& at)
      : part(of), sums(sums_at<double>(of, at)), hits(&hits_at(of, at)) {}
  void add(const FilmSample& sample, bool finite) const {
    if (!finite || (part.hits_only && !sample.value.first_hit.hit)) return;
    double* to = sums;
    for (const ChannelRow& row : part.rows) {
      row.add(sample, to);
      to += row.sum_count();
    }
    if (part.hits_only) ++*hits;
  }
  void merge(const RowBlock& more) const {
    for (size_t i = 0; i < part.sums; ++i) sums[i] += more.sums[i];
    if (part.hits_only) *hits += *more.hits;
  }
  bool is_valid() const { return all_finite(sums, part.sums); }
};

// The whole numbers of a part with a single row: sums for kCount, or for kFirstHit the number of
// the first hit (0: no hit yet).
struct NumberBlock {
  const ChannelRow& row;
  uint32_t* numbers;

  NumberBlock(const FilmLayout&, const Part& part, const FilmPixel& at)
      : row(part.rows.front()), numbers(sums_at<uint32_t>(part, at)) {}
  bool counts() const { return row.kind == ChannelKind::kCount; }
  void add(const FilmSample& sample, bool finite) const {
    if (counts() || (finite && *numbers == 0)) row.count(sample, numbers);
  }
  void merge(const NumberBlock& more) const {
    for (size_t i = 0; i < row.size(); ++i) {
      if (counts() || numbers[i] == 0) numbers[i] += more.numbers[i];
    }
  }
  static bool is_valid() { return true; }
};

// Light sums by light group or by light-path layer. With kSecondHalf, only the samples of the
// second half are added.
template <const LightGroupValues* FilmSample::*kValues, bool kSecondHalf = false>
struct LightBlock : LightGroupSums {
  LightBlock(const FilmLayout& layout, const Part& part, const FilmPixel& at)
      : LightGroupSums(lights_at(layout, part.block, at)) {}
  void add(const FilmSample& sample, bool finite) {
    if (kSecondHalf && sample.half != 1) return;
    const float alpha = finite && !kSecondHalf ? sample.value.alpha : 0.0f;
    LightGroupSums::add(sample.filter_weight, alpha, finite ? sample.*kValues : nullptr,
                        sample.lane);
  }
};

struct MatteBlock : CryptomatteSums {
  MatteBlock(const FilmLayout& layout, const Part&, const FilmPixel& at)
      : CryptomatteSums(mattes_at(layout, at)) {}
  void add(const FilmSample& sample, bool finite) {
    if (!finite || sample.value.alpha == 0.0f || sample.ids.empty()) return;
    CryptomatteSums::add(sample.filter_weight * sample.value.alpha, sample.ids);
  }
};

// More storage for the preceding block, whose add(), merge() and is_valid() also handle this
// storage.
struct SecondaryBlock {
  SecondaryBlock(const FilmLayout&, const Part&, const FilmPixel&) {}
  static void merge(const SecondaryBlock&) {}
  static bool is_valid() { return true; }
};

// ---- The table of blocks.

struct SumsType {
  size_t alignment;
  size_t (*bytes)(const FilmContents& contents);  // bytes per pixel; 0: the film lacks the block
  SumGroup group;
  void (*add)(const FilmLayout&, const Part&, const FilmPixel&, const FilmSample&, bool finite);
  void (*merge)(const FilmLayout&, const Part&, const FilmPixel& at, const FilmPixel& more);
  bool (*is_valid)(const FilmLayout&, const Part&, const FilmPixel&);
};

// Returns a block as an object: a newly constructed view if the block type is a view, otherwise a
// reference to the stored object.
template <class Block>
decltype(auto) block_at(const FilmLayout& layout, const Part& part, const FilmPixel& at) {
  if constexpr (std::is_constructible_v<Block, const FilmLayout&, const Part&, const FilmPixel&>) {
    return Block(layout, part, at);
  } else {
    return *sums_at<Block>(part, at);
  }
}

template <class Block, class Number = Block>
constexpr SumsType type_of_block(size_t (*bytes)(const FilmContents&),
                                 SumGroup group = SumGroup::kNone) {
  SumsType type{alignof(Number), bytes, group, nullptr, nullptr, nullptr};
  if constexpr (requires(Block block, const FilmSample& sample) { block.add(sample, true); }) {
    type.add = [](const FilmLayout& layout, const Part& part, const FilmPixel& at,
                  const FilmSample& sample,
                  bool finite) { block_at<Block>(layout, part, at).add(sample, finite); };
  }
  type.merge = [](const FilmLayout& layout, const Part& part, const FilmPixel& at,
                  const FilmPixel& more) {
    block_at<Block>(layout, part, at).merge(block_at<Block>(layout, part, more));
  };
  type.is_valid = [](const FilmLayout& layout, const Part& part, const FilmPixel& at) {
    return block_at<Block>(layout, part, at).is_valid();
  };
  return type;
}

template <Aov kAov, class Block>
constexpr SumsType with_channel() {
  return type_of_block<Block>(
      [](const FilmContents& c) { return c.aovs.contains(kAov) ? sizeof(Block) : 0; });
}

// Here, `bytes` tells only whether the block is present; make_part() computes the block's size.
template <SumGroup kGroup>
constexpr SumsType with_group() {
  return type_of_block<RowBlock, double>(
      [](const FilmContents& c) -> size_t { return c.aovs.needs(kGroup); }, kGroup);
}

size_t group_bytes(const FilmContents& c) {
  return LightGroupSums::bytes_per_pixel(c.extras.light_groups) / 2;
}
size_t layer_bytes(const FilmContents& c) {
  const int layers = PathLayers(c.aovs).size();
  return layers > 0 ? LightGroupSums::bytes_per_pixel(layers) / 2 : 0;
}
size_t half_light_bytes(const FilmContents& c) {
  return c.aovs.contains(Aov::kDenoising) && c.extras.light_groups > 0 ? group_bytes(c) : 0;
}

constexpr SumsType kTypes[] = {
    type_of_block<PixelBlock>([](const FilmContents&) { return sizeof(PixelSums); }),
    type_of_block<Squares>([](const FilmContents& c) {
      return c.aovs.contains(Aov::kVariance) || c.extras.squares ? sizeof(Squares) : 0;
    }),
    type_of_block<Rays>([](const FilmContents& c) { return c.extras.rays ? sizeof(Rays) : 0; }),
    with_group<SumGroup::kSurface>(),
    with_group<SumGroup::kPositionUv>(),
    with_channel<Aov::kVelocity, Velocities>(),
    with_group<SumGroup::kClamped>(),
    with_channel<Aov::kTime, Seconds>(),
    with_channel<Aov::kStop, Stop>(),
    type_of_block<LightBlock<&FilmSample::lights>, float>(group_bytes),
    type_of_block<SecondaryBlock, float>(group_bytes),
    type_of_block<LightBlock<&FilmSample::layers>, float>(layer_bytes),
    type_of_block<SecondaryBlock, float>(layer_bytes),
    with_group<SumGroup::kShadow>(),
    with_channel<Aov::kDenoising, Halves>(),
    type_of_block<LightBlock<&FilmSample::lights, true>, float>(half_light_bytes),
    type_of_block<SecondaryBlock, float>(half_light_bytes),
    type_of_block<MatteBlock, uint32_t>(
        [](const FilmContents& c) { return CryptomatteSums::id_bytes(c.extras); }),
    type_of_block<SecondaryBlock, double>(
        [](const FilmContents& c) { return CryptomatteSums::weight_bytes(c.extras); }),
};
static_assert(std::size(kTypes) == kNamedSums);
constexpr SumsType kSumsOfRow = type_of_block<RowBlock, double>(nullptr);
constexpr SumsType kNumbersOfRow = type_of_block<NumberBlock, uint32_t>(nullptr);

void set_rows(std::span<const ChannelRow> rows, Part& part) {
  part.rows = rows;
  for (const ChannelRow& row : rows) {
    part.sums += row.sum_count();
    part.hits_only = part.hits_only || row.is_of_hits();
  }
  part.bytes = sizeof(double) * (part.sums + (part.hits_only ? 1 : 0));
}

Part make_part(Sums block, const FilmContents& contents) {
  const SumsType& type = kTypes[size_t(block)];
  Part part{.block = block, .bytes = type.bytes(contents)};
  if (type.group == SumGroup::kNone || part.bytes == 0) return part;
  const std::span<const ChannelRow> table = channel_table();
  const auto is_in = [&](const ChannelRow& row) { return row.group == type.group; };
  const auto first = std::ranges::find_if(table, is_in);
  set_rows({first, std::find_if_not(first, table.end(), is_in)}, part);
  return part;
}

// Returns the part for a row outside all groups. It has 0 bytes if the row has no sums or counters
// of its own.
Part part_of_row(const ChannelRow& row) {
  Part part{.block = Sums::kRow};
  if (row.add && row.group == SumGroup::kNone) set_rows({&row, 1}, part);
  if (row.count) {
    part.rows = {&row, 1};
    part.bytes = row.size() * sizeof(uint32_t);
  }
  return part;
}

const SumsType& type_of(const Part& part) {
  if (part.block != Sums::kRow) return kTypes[size_t(part.block)];
  return part.sums > 0 ? kSumsOfRow : kNumbersOfRow;
}

}  // namespace

// Orders the planes by alignment, largest first, so that all are aligned for any number of pixels.
FilmLayout::FilmLayout(const FilmContents& contents) : contents_(contents) {
  for (size_t i = 0; i < kNamedSums; ++i) parts_.push_back(make_part(Sums(i), contents));
  for (const ChannelRow* row : rows_of(contents.aovs)) {
    const Part part = part_of_row(*row);
    if (part.bytes > 0) parts_.push_back(part);
  }
  for (const size_t alignment : {alignof(double), alignof(float), alignof(uint8_t)}) {
    for (Part& part : parts_) {
      if (type_of(part).alignment != alignment) continue;
      part.index = size_t(&part - parts_.data());
      part.offset = bytes_;
      bytes_ += part.bytes;
    }
  }
  std::ranges::copy_if(parts_, std::back_inserter(sampled_parts_), [](const Part& part) {
    return part.bytes > 0 && type_of(part).add != nullptr;
  });
}

FilmLayout::RowSums FilmLayout::sums_of(const ChannelRow& row) const {
  for (const Part& part : parts_) {
    size_t first = 0;
    for (const ChannelRow& of_part : part.rows) {
      if (&of_part == &row) return {&part, first};
      first += of_part.sum_count();
    }
  }
  assert(false);
  return {};
}

void FilmLayout::add(const FilmPixel& at, const FilmSample& sample, bool finite) const {
  for (const Part& part : sampled_parts_) type_of(part).add(*this, part, at, sample, finite);
}

void FilmLayout::merge(const FilmPixel& at, const FilmPixel& more) const {
  for (const Part& part : parts_) {
    if (part.bytes > 0) type_of(part).merge(*this, part, at, more);
  }
}

bool FilmLayout::is_valid(const FilmPixel& at) const {
  return std::ranges::all_of(parts_, [&](const Part& part) {
    return part.bytes == 0 || type_of(part).is_valid(*this, part, at);
  });
}

void FilmLayout::prefetch(const FilmPixel& at) const {
  constexpr size_t kCacheLine = 64;
  const auto prefetch_block = [&](const Part& part) {
    const std::byte* const first = sums_at<std::byte>(part, at);
    for (size_t i = 0; i < part.bytes; i += kCacheLine) __builtin_prefetch(first + i, 1);
    __builtin_prefetch(first + part.bytes - 1, 1);
  };
  prefetch_block(part(Sums::kPixel));
  std::ranges::for_each(sampled_parts_, prefetch_block);
}

LightGroupSums lights_at(const FilmLayout& layout, Sums block, const FilmPixel& at) {
  const FilmLayout::Part& sums = layout.part(block);
  const FilmLayout::Part& remainders = layout.part(Sums(size_t(block) + 1));
  return {sums_at<float>(sums, at), sums_at<float>(remainders, at),
          int(sums.bytes / sizeof(float[3])) - 1};
}

CryptomatteSums mattes_at(const FilmLayout& layout, const FilmPixel& at) {
  return {sums_at<uint32_t>(layout.part(Sums::kMattes), at),
          sums_at<double>(layout.part(Sums::kMatteWeights), at), layout.contents().extras};
}

}  // namespace emberline
