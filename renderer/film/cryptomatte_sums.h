// Cryptomatte sums, which tell what objects a pixel shows and how much of the pixel each object
// covers (J. Friedman, A. Jones, "Fully automatic ID mattes with support for motion blur and
// transparency", SIGGRAPH 2015 posters; specification 1.2).
//
// For each kind, a pixel keeps a list of ids, and for each id the summed filter weights of the
// samples that saw it. If the list is full, a new id replaces the id with the smallest sum. This
// sum is added to the list's dropped weight, so no weight is lost. The list does not depend on the
// schedule, because one owner adds a pixel's samples in index order.
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
// The table that --cryptomatte, its --help and its error message use.
std::span<const NamedValue<CryptomatteKind>> cryptomatte_table();
// Parses a list such as "object,asset". Returns kinds in table order, without duplicates. Throws
// UsageError with the valid names.
std::vector<CryptomatteKind> parse_cryptomattes(std::string_view list);

// A view of a pixel's lists, which the film owns.
class CryptomatteSums {
 public:
  // `ids` points to id_bytes() bytes, where 0 marks a free slot; `weights` points to weight_bytes()
  // bytes, where each list ends with the dropped weight.
  CryptomatteSums(uint32_t* ids, double* weights, const FilmExtras& extras)
      : ids_(ids),
        weights_(weights),
        kinds_(size_t(extras.cryptomattes)),
        levels_(size_t(extras.cryptomatte_levels)) {}
  static size_t id_bytes(const FilmExtras& extras);
  static size_t weight_bytes(const FilmExtras& extras);

  // Adds a sample that hit something. `ids` has one nonzero id for each kind.
  void add(float filter_weight, std::span<const uint32_t> ids);
  void merge(const CryptomatteSums& more);

  struct Rank {
    uint32_t id = 0;  // 0: none
    float coverage = 0.0f;
  };
  // Writes the ranks of one kind, largest coverage first; `ranks` must have room for all levels.
  // `samples` is the pixel's sample count. Returns the share of the pixel that was dropped. The
  // coverages and this share add up to the pixel's alpha. This alpha is clamped to [0, 1], since
  // filters with negative lobes may exceed this range.
  float resolve(size_t kind, double samples, std::span<Rank> ranks) const;
  // Whether all weights are in range, and all ids are valid as floats, since files store ids as
  // floats.
  bool is_valid() const;

 private:
  void add_to(size_t kind, uint32_t id, double weight);

  uint32_t* ids_;
  double* weights_;
  size_t kinds_, levels_;
};

}  // namespace emberline
