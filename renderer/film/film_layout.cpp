#include "renderer/film/film_layout.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <iterator>

#include "renderer/film/half_sums.h"
#include "renderer/film/path_layers.h"
#include "renderer/film/pixel_stop.h"

namespace emberline {
namespace {

using Part = FilmLayout::Part;

// A block of any film, and what is done with it. Functions that are null have nothing to do.
struct SumsType {
  size_t alignment;
  size_t (*bytes)(const FilmContents& contents);  // 0: not kept
  SumGroup group = SumGroup::kNone;
  void (*add)(const FilmLayout& layout, const Part& part, const FilmPixel& at,
              const FilmSample& sample, bool finite) = nullptr;
  void (*merge)(const FilmLayout& layout, const Part& part, const FilmPixel& at,
                const FilmPixel& more) = nullptr;
  bool (*is_sound)(const FilmLayout& layout, const Part& part, const FilmPixel& at) = nullptr;
};

template <class T>
bool all_finite(const T* values, size_t count) {
  return std::all_of(values, values + count, [](T value) { return std::isfinite(value); });
}

// Sums that are merged by adding them.
template <class T, size_t kCount>
void merge_numbers(const FilmLayout&, const Part& part, const FilmPixel& at,
                   const FilmPixel& more) {
  for (size_t i = 0; i < kCount; ++i) sums_at<T>(part, at)[i] += sums_at<T>(part, more)[i];
}
template <class T, size_t kCount>
bool numbers_are_sound(const FilmLayout&, const Part& part, const FilmPixel& at) {
  return all_finite(sums_at<T>(part, at), kCount);
}

void merge_pixel(const FilmLayout&, const Part& part, const FilmPixel& at, const FilmPixel& from) {
  PixelSums& sums = *sums_at<PixelSums>(part, at);
  const PixelSums& more = *sums_at<PixelSums>(part, from);
  for (int half = 0; half < 2; ++half) {
    for (int c = 0; c < 3; ++c) sums.rgb[half][c] += more.rgb[half][c];
    sums.count[half] += more.count[half];
  }
  sums.alpha += more.alpha;
  sums.non_finite += more.non_finite;
  if (sums.id == 0) sums.id = more.id;
}

bool pixel_is_sound(const FilmLayout&, const Part& part, const FilmPixel& at) {
  constexpr uint32_t kMost = 1u << 25;  // of one stream
  const PixelSums& sums = *sums_at<PixelSums>(part, at);
  const uint64_t count = uint64_t(sums.count[0]) + sums.count[1];
  return sums.count[0] <= kMost && sums.count[1] <= kMost && sums.non_finite <= count &&
         all_finite(&sums.rgb[0][0], 6) && std::isfinite(sums.alpha);
}

void add_squares(const FilmLayout&, const Part& part, const FilmPixel& at, const FilmSample& sample,
                 bool finite) {
  if (!finite) return;
  const Rgb weighted = sample.value.radiance * sample.filter_weight;
  double* sums = sums_at<double>(part, at);
  for (int c = 0; c < 3; ++c) sums[c] = fma(double(weighted[c]), double(weighted[c]), sums[c]);
}

void add_rays(const FilmLayout&, const Part& part, const FilmPixel& at, const FilmSample& sample,
              bool) {
  *sums_at<uint32_t>(part, at) += sample.value.rays.total();
}

void add_group(const FilmLayout&, const Part& part, const FilmPixel& at, const FilmSample& sample,
               bool finite) {
  if (!finite || (part.of_hits && !sample.value.first_hit.hit)) return;
  double* sums = sums_at<double>(part, at);
  for (const ChannelRow& row : part.rows) {
    row.add(sample, sums);
    sums += row.sum_count();
  }
  if (part.of_hits) ++hits_at(part, at);
}

void merge_group(const FilmLayout&, const Part& part, const FilmPixel& at, const FilmPixel& more) {
  for (size_t i = 0; i < part.sums; ++i)
    sums_at<double>(part, at)[i] += sums_at<double>(part, more)[i];
  if (part.of_hits) hits_at(part, at) += hits_at(part, more);
}

bool group_is_sound(const FilmLayout&, const Part& part, const FilmPixel& at) {
  return all_finite(sums_at<double>(part, at), part.sums);
}

void add_velocities(VelocitySums& sums, const VelocitySums& more) {
  if (more.of_surfaces > sums.of_surfaces) sums = {0.0, 0.0, 0, 1};
  if (more.of_surfaces < sums.of_surfaces) return;
  sums.x += more.x;
  sums.y += more.y;
  sums.count += more.count;
}

void add_velocity(const FilmLayout&, const Part& part, const FilmPixel& at,
                  const FilmSample& sample, bool finite) {
  const FirstHit& hit = sample.value.first_hit;
  if (!finite) return;
  add_velocities(*sums_at<VelocitySums>(part, at),
                 {double(hit.velocity.x), double(hit.velocity.y), 1, hit.hit ? 1u : 0u});
}

void merge_velocity(const FilmLayout&, const Part& part, const FilmPixel& at,
                    const FilmPixel& more) {
  add_velocities(*sums_at<VelocitySums>(part, at), *sums_at<VelocitySums>(part, more));
}

bool velocity_is_sound(const FilmLayout&, const Part& part, const FilmPixel& at) {
  const VelocitySums& sums = *sums_at<VelocitySums>(part, at);
  return std::isfinite(sums.x) && std::isfinite(sums.y) && sums.of_surfaces <= 1;
}

int light_groups_of(const FilmContents& contents) { return contents.extras.light_groups; }
int layers_of(const FilmContents& contents) {
  const int layers = PathLayers(contents.aovs).size();
  return layers > 0 ? layers : -1;
}
int half_lights_of(const FilmContents& contents) {
  const bool kept = contents.aovs.contains(Aov::kDenoising) && contents.extras.light_groups > 0;
  return kept ? contents.extras.light_groups : -1;
}

void merge_lights(const FilmLayout& layout, const Part& part, const FilmPixel& at,
                  const FilmPixel& more) {
  lights_at(layout, part.block, at).merge(lights_at(layout, part.block, more));
}

bool lights_are_sound(const FilmLayout& layout, const Part& part, const FilmPixel& at) {
  return lights_at(layout, part.block, at).is_sound();
}

void add_lights(const FilmLayout& layout, const Part& part, const FilmPixel& at,
                const FilmSample& sample, bool finite) {
  const float alpha = finite ? sample.value.alpha : 0.0f;
  lights_at(layout, part.block, at)
      .add(sample.filter_weight, alpha, finite ? sample.lights : nullptr, sample.lane);
}

void add_layers(const FilmLayout& layout, const Part& part, const FilmPixel& at,
                const FilmSample& sample, bool finite) {
  const float alpha = finite ? sample.value.alpha : 0.0f;
  lights_at(layout, part.block, at)
      .add(sample.filter_weight, alpha, finite ? sample.layers : nullptr, sample.lane);
}

void add_half_lights(const FilmLayout& layout, const Part& part, const FilmPixel& at,
                     const FilmSample& sample, bool finite) {
  if (sample.half != 1) return;
  lights_at(layout, part.block, at)
      .add(sample.filter_weight, 0.0f, finite ? sample.lights : nullptr, sample.lane);
}

void add_halves(const FilmLayout&, const Part& part, const FilmPixel& at, const FilmSample& sample,
                bool finite) {
  if (!finite) return;
  HalfSums& sums = *sums_at<HalfSums>(part, at);
  if (sample.features) sums.add(sample.half, *sample.features);
  if (sample.shares) sums.add_shares(sample.half, sample.value.radiance, *sample.shares);
}

void merge_halves(const FilmLayout&, const Part& part, const FilmPixel& at, const FilmPixel& more) {
  sums_at<HalfSums>(part, at)->merge(*sums_at<HalfSums>(part, more));
}

bool halves_are_sound(const FilmLayout&, const Part& part, const FilmPixel& at) {
  return sums_at<HalfSums>(part, at)->is_sound();
}

void add_mattes(const FilmLayout& layout, const Part&, const FilmPixel& at,
                const FilmSample& sample, bool finite) {
  if (!finite || sample.value.alpha == 0.0f || sample.ids.empty()) return;
  mattes_at(layout, at).add(sample.filter_weight * sample.value.alpha, sample.ids);
}

void merge_mattes(const FilmLayout& layout, const Part&, const FilmPixel& at,
                  const FilmPixel& more) {
  mattes_at(layout, at).merge(mattes_at(layout, more));
}

bool mattes_are_sound(const FilmLayout& layout, const Part&, const FilmPixel& at) {
  return mattes_at(layout, at).is_sound();
}

// Bytes of what is kept with a channel.
template <Aov kAov, class T>
size_t bytes_with(const FilmContents& contents) {
  return contents.aovs.contains(kAov) ? sizeof(T) : 0;
}

void add_numbers(const FilmLayout&, const Part& part, const FilmPixel& at, const FilmSample& sample,
                 bool finite) {
  const ChannelRow& row = part.rows.front();
  uint32_t* const numbers = sums_at<uint32_t>(part, at);
  const bool is_first = finite && *numbers == 0;
  if (row.kind == ChannelKind::kCount || is_first) row.count(sample, numbers);
}

void merge_numbers_of_row(const FilmLayout&, const Part& part, const FilmPixel& at,
                          const FilmPixel& from) {
  const ChannelRow& row = part.rows.front();
  uint32_t* const numbers = sums_at<uint32_t>(part, at);
  const uint32_t* const more = sums_at<uint32_t>(part, from);
  for (size_t i = 0; i < row.size(); ++i) {
    if (row.kind == ChannelKind::kCount || numbers[i] == 0) numbers[i] += more[i];
  }
}

template <SumGroup kGroup>
constexpr SumsType group_type() {
  // The parts of groups know their size: `bytes` only says whether there is one.
  return {alignof(double),
          [](const FilmContents& contents) -> size_t { return contents.aovs.needs(kGroup); },
          kGroup,
          add_group,
          merge_group,
          group_is_sound};
}

template <int (*kGroups)(const FilmContents&)>
size_t light_bytes(const FilmContents& contents) {
  return LightGroupSums::bytes_per_pixel(kGroups(contents)) / 2;
}

template <int (*kGroups)(const FilmContents&)>
constexpr SumsType light_type(decltype(SumsType::add) add) {
  return {alignof(float), light_bytes<kGroups>, SumGroup::kNone, add,
          merge_lights,   lights_are_sound};
}
template <int (*kGroups)(const FilmContents&)>
constexpr SumsType rest_type() {
  return {.alignment = alignof(float), .bytes = light_bytes<kGroups>};
}

constexpr SumsType kTypes[] = {
    {alignof(double), [](const FilmContents&) { return sizeof(PixelSums); }, SumGroup::kNone,
     nullptr, merge_pixel, pixel_is_sound},
    {alignof(double),
     [](const FilmContents& c) -> size_t {
       return c.aovs.contains(Aov::kVariance) || c.extras.squares ? sizeof(double[3]) : 0;
     },
     SumGroup::kNone, add_squares, merge_numbers<double, 3>, numbers_are_sound<double, 3>},
    {alignof(uint32_t), [](const FilmContents& c) { return c.extras.rays ? sizeof(uint32_t) : 0; },
     SumGroup::kNone, add_rays, merge_numbers<uint32_t, 1>},
    group_type<SumGroup::kSurface>(),
    group_type<SumGroup::kPlace>(),
    {alignof(double), bytes_with<Aov::kVelocity, VelocitySums>, SumGroup::kNone, add_velocity,
     merge_velocity, velocity_is_sound},
    group_type<SumGroup::kClamped>(),
    {alignof(float), bytes_with<Aov::kTime, float>, SumGroup::kNone, nullptr,
     merge_numbers<float, 1>, numbers_are_sound<float, 1>},
    {alignof(PixelStop), bytes_with<Aov::kStop, PixelStop>, SumGroup::kNone, nullptr,
     [](const FilmLayout&, const Part& part, const FilmPixel& at, const FilmPixel& more) {
       *sums_at<PixelStop>(part, at) = *sums_at<PixelStop>(part, more);
     },
     [](const FilmLayout&, const Part& part, const FilmPixel& at) {
       return *sums_at<PixelStop>(part, at) <= PixelStop::kGoingOn;
     }},
    light_type<light_groups_of>(add_lights),
    rest_type<light_groups_of>(),
    light_type<layers_of>(add_layers),
    rest_type<layers_of>(),
    group_type<SumGroup::kShadow>(),
    {alignof(double), bytes_with<Aov::kDenoising, HalfSums>, SumGroup::kNone, add_halves,
     merge_halves, halves_are_sound},
    light_type<half_lights_of>(add_half_lights),
    rest_type<half_lights_of>(),
    {alignof(uint32_t), [](const FilmContents& c) { return CryptomatteSums::id_bytes(c.extras); },
     SumGroup::kNone, add_mattes, merge_mattes, mattes_are_sound},
    {.alignment = alignof(double),
     .bytes = [](const FilmContents& c) { return CryptomatteSums::weight_bytes(c.extras); }},
};
constexpr SumsType kSumsOfRow = {alignof(double), nullptr,     SumGroup::kNone,
                                 add_group,       merge_group, group_is_sound};
constexpr SumsType kNumbersOfRow = {alignof(uint32_t), nullptr, SumGroup::kNone, add_numbers,
                                    merge_numbers_of_row};
static_assert(std::size(kTypes) == kNamedSums);

// Of rows with sums.
void set_rows(std::span<const ChannelRow> rows, Part& part) {
  part.rows = rows;
  for (const ChannelRow& row : rows) {
    part.sums += row.sum_count();
    part.of_hits = part.of_hits || row.is_of_hits();
  }
  part.bytes = sizeof(double) * (part.sums + (part.of_hits ? 1 : 0));
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

// Of a row that shares no sums; without bytes if it has none.
Part part_of_row(const ChannelRow& row) {
  Part part{.block = Sums::kOfRow};
  if (row.add && row.group == SumGroup::kNone) set_rows({&row, 1}, part);
  if (row.count) {
    part.rows = {&row, 1};
    part.bytes = row.size() * sizeof(uint32_t);
  }
  return part;
}

const SumsType& type_of(const Part& part) {
  if (part.block != Sums::kOfRow) return kTypes[size_t(part.block)];
  return part.sums > 0 ? kSumsOfRow : kNumbersOfRow;
}

}  // namespace

// Planes of large numbers first, so that all are aligned whatever the number of pixels.
FilmLayout::FilmLayout(const FilmContents& contents) : contents_(contents) {
  for (size_t i = 0; i < kNamedSums; ++i) parts_.push_back(make_part(Sums(i), contents));
  for (const ChannelRow* row : rows_of(contents.aovs)) {
    const Part part = part_of_row(*row);
    if (part.bytes > 0) parts_.push_back(part);
  }
  for (const size_t alignment : {alignof(double), alignof(float), alignof(PixelStop)}) {
    for (Part& part : parts_) {
      if (type_of(part).alignment != alignment) continue;
      part.place = size_t(&part - parts_.data());
      part.offset = bytes_;
      bytes_ += part.bytes;
    }
  }
  std::ranges::copy_if(parts_, std::back_inserter(added_), [](const Part& part) {
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
  for (const Part& part : added_) type_of(part).add(*this, part, at, sample, finite);
}

void FilmLayout::merge(const FilmPixel& at, const FilmPixel& more) const {
  for (const Part& part : parts_) {
    const auto merge = type_of(part).merge;
    if (merge && part.bytes > 0) merge(*this, part, at, more);
  }
}

bool FilmLayout::is_sound(const FilmPixel& at) const {
  return std::ranges::all_of(parts_, [&](const Part& part) {
    const auto is_sound = type_of(part).is_sound;
    return !is_sound || part.bytes == 0 || is_sound(*this, part, at);
  });
}

void FilmLayout::prefetch(const FilmPixel& at) const {
  constexpr size_t kLine = 64;
  const auto prefetch_block = [&](const Part& part) {
    const std::byte* const first = sums_at<std::byte>(part, at);
    for (size_t i = 0; i < part.bytes; i += kLine) __builtin_prefetch(first + i, 1);
    __builtin_prefetch(first + part.bytes - 1, 1);
  };
  prefetch_block(part(Sums::kPixel));
  std::ranges::for_each(added_, prefetch_block);
}

LightGroupSums lights_at(const FilmLayout& layout, Sums block, const FilmPixel& at) {
  const FilmLayout::Part& sums = layout.part(block);
  const FilmLayout::Part& rests = layout.part(Sums(size_t(block) + 1));
  return {sums_at<float>(sums, at), sums_at<float>(rests, at),
          int(sums.bytes / sizeof(float[3])) - 1};
}

CryptomatteSums mattes_at(const FilmLayout& layout, const FilmPixel& at) {
  return {sums_at<uint32_t>(layout.part(Sums::kMattes), at),
          sums_at<double>(layout.part(Sums::kMatteWeights), at), layout.contents().extras};
}

}  // namespace emberline
