// `--cryptomatte`: mattes as EXR layers, with their manifests in the header, following Cryptomatte
// specification 1.2.
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

// Returns "CryptoObject" and so on.
const char* cryptomatte_layer_name(CryptomatteKind kind);

// Returns the channel names of each kind. CryptoObject00.{R,G,B,A} and so on each hold the ids and
// coverages of two ranks (zero if unused). They are followed by dropped.CryptoObject, the coverage
// that did not fit.
std::vector<std::string> cryptomatte_channel_names(std::span<const CryptomatteKind> kinds,
                                                   int levels);

// For one kind: the number of names, and the number of pixels so far with more ids than levels.
struct CryptomatteReport {
  CryptomatteKind kind = CryptomatteKind::kObject;
  size_t names = 0;
  uint64_t dropped_pixels = 0;
  float max_dropped = 0.0f;  // largest coverage that a pixel lost, 0 to 1

  void add(float dropped) { merge({kind, names, dropped > 0.0f, dropped}); }
  void merge(const CryptomatteReport& other) {
    dropped_pixels += other.dropped_pixels;
    max_dropped = std::max(max_dropped, other.max_dropped);
  }
};

// Writes the values of cryptomatte_channel_names() for pixel i of the tile, using `ranks` as
// scratch space. Updates the report of each kind.
void put_cryptomattes(const FilmTile& tile, size_t i, float* values,
                      std::vector<CryptomatteSums::Rank>& ranks,
                      std::span<CryptomatteReport> reports);

// Returns the header attributes of each kind: name, hash, conversion and manifest.
std::vector<std::pair<std::string, std::string>> cryptomatte_attributes(
    std::span<const CryptomatteNames> names);

}  // namespace emberline
