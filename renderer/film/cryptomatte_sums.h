// Which things each pixel shows, and how much of it each covers: the ranks of Cryptomatte
// (J. Friedman, A. Jones, "Fully automatic ID mattes with support for motion blur and
// transparency", SIGGRAPH 2015 posters; specification 1.2).
//
// Of each pixel and kind a list of so many ids is kept, and the sum of the filter weights of the
// samples that saw each. An id that finds the list full takes the place of the least sum, which is
// added to what was dropped: nothing is lost without being counted. A pixel's samples come in index
// order from one owner, so the list depends on nothing else.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "renderer/core/names.h"
#include "renderer/core/zeroed_array.h"

namespace emberline {

class Archive;

enum class CryptomatteKind : uint8_t { kObject, kMaterial, kAsset };
// The table behind --cryptomatte, its --help and its error message.
std::span<const NamedValue<CryptomatteKind>> cryptomatte_table();
// "object,asset" -> those, in table order, each once. Throws UsageError that lists the valid names.
std::vector<CryptomatteKind> parse_cryptomattes(std::string_view list);

class CryptomatteSums {
 public:
  // Lists of `levels` ids for each of `kinds`; none of them: nothing is kept.
  CryptomatteSums(int kinds, int levels) : kinds_(size_t(kinds)), levels_(size_t(levels)) {}

  // Clears to no samples of so many pixels, as FilmTile does.
  void reset(size_t pixels);
  bool empty() const { return weights_.empty(); }
  size_t kinds() const { return kinds_; }
  size_t levels() const { return levels_; }

  // A sample that saw something: an id for each kind, none of them 0.
  void add(size_t pixel, float filter_weight, std::span<const uint32_t> ids);
  void add_sums(const CryptomatteSums& from, size_t pixel);
  void copy(const CryptomatteSums& from, size_t from_pixel, size_t pixel);

  struct Rank {
    uint32_t id = 0;  // 0: none
    float coverage = 0.0f;
  };
  // Of one kind, the largest first; `ranks` has room for all levels. Returns the share of the pixel
  // that was dropped. Together they are the alpha of so many samples, at most 1: a filter with
  // negative lobes may leave [0, 1], coverage may not.
  float resolve(size_t pixel, size_t kind, double samples, std::span<Rank> ranks) const;

  uint64_t bytes() const {
    return ids_.capacity() * sizeof(uint32_t) + weights_.capacity() * sizeof(double);
  }
  // Of so many pixels as reset() was told. Throws InputError.
  void archive(Archive& archive);

 private:
  size_t list_of(size_t pixel, size_t kind) const { return pixel * kinds_ + kind; }
  void add_to(size_t list, uint32_t id, double weight);

  size_t kinds_, levels_;
  ZeroedArray<uint32_t> ids_;    // by list; 0: a free place
  ZeroedArray<double> weights_;  // by list, with what was dropped behind each
};

}  // namespace emberline
