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
#include "renderer/film/film_extras.h"

namespace emberline {

enum class CryptomatteKind : uint8_t { kObject, kMaterial, kAsset };
// The table behind --cryptomatte, its --help and its error message.
std::span<const NamedValue<CryptomatteKind>> cryptomatte_table();
// "object,asset" -> those, in table order, each once. Throws UsageError that lists the valid names.
std::vector<CryptomatteKind> parse_cryptomattes(std::string_view list);

// A view of the lists of one pixel, which its film holds.
class CryptomatteSums {
 public:
  // The lists of a film with these kinds and levels: id_bytes() at `ids`, 0 a free place, and
  // weight_bytes() at `weights`, what was dropped behind each list.
  CryptomatteSums(uint32_t* ids, double* weights, const FilmExtras& extras)
      : ids_(ids),
        weights_(weights),
        kinds_(size_t(extras.cryptomattes)),
        levels_(size_t(extras.cryptomatte_levels)) {}
  static size_t id_bytes(const FilmExtras& extras);
  static size_t weight_bytes(const FilmExtras& extras);

  // A sample that saw something: an id for each kind, none of them 0.
  void add(float filter_weight, std::span<const uint32_t> ids);
  void merge(const CryptomatteSums& more);

  struct Rank {
    uint32_t id = 0;  // 0: none
    float coverage = 0.0f;
  };
  // Of one kind, the largest first; `ranks` has room for all levels. Returns the share of the pixel
  // that was dropped. Together they are the alpha of so many samples, at most 1: a filter with
  // negative lobes may leave [0, 1], coverage may not.
  float resolve(size_t kind, double samples, std::span<Rank> ranks) const;
  // Ids that are floats, too, as files have them, and sums of weights.
  bool is_sound() const;

 private:
  void add_to(size_t kind, uint32_t id, double weight);

  uint32_t* ids_;
  double* weights_;
  size_t kinds_, levels_;
};

}  // namespace emberline
