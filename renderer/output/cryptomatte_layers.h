// `--cryptomatte`: which things each pixel shows as layers of the EXR, and their names in its
// header, as the specification 1.2 has them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "renderer/film/cryptomatte_sums.h"
#include "renderer/scene/cryptomatte_ids.h"

namespace emberline {

class FilmTile;

// "CryptoObject" and its like.
const char* cryptomatte_layer_name(CryptomatteKind kind);

// Of each kind CryptoObject00.{R,G,B,A} and so on: id and coverage of two ranks in each, the last
// empty where there are fewer; then dropped.CryptoObject, what was covered by more.
std::vector<std::string> cryptomatte_channel_names(std::span<const CryptomatteKind> kinds,
                                                   int levels);

// Of one kind: how many names there are, and of the pixels so far those that more things shared
// than there are levels.
struct CryptomatteReport {
  CryptomatteKind kind = CryptomatteKind::kObject;
  size_t names = 0;
  uint64_t dropped_pixels = 0;
  float most_dropped = 0.0f;  // share of a pixel

  void add(float dropped) { merge({kind, names, dropped > 0.0f, dropped}); }
  void merge(const CryptomatteReport& other) {
    dropped_pixels += other.dropped_pixels;
    most_dropped = std::max(most_dropped, other.most_dropped);
  }
};

// Writes the values of these channels of the tile's pixel i, with `ranks` as room to work in; adds
// to the report of each kind.
void put_cryptomattes(const FilmTile& tile, size_t i, float* values,
                      std::vector<CryptomatteSums::Rank>& ranks,
                      std::span<CryptomatteReport> reports);

// The header's texts: name, hash, conversion and manifest of each kind.
std::vector<std::pair<std::string, std::string>> cryptomatte_attributes(
    std::span<const CryptomatteNames> names);

}  // namespace emberline
