// `--cryptomatte`: stores mattes as EXR layers and their manifests in the EXR header, according to
// the Cryptomatte specification 1.2.
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

// Returns the name of the layer for a kind of matte, such as "CryptoObject".
const char* cryptomatte_layer_name(CryptomatteKind kind);

// Returns the channel names of all kinds. For the kind "object", these are
// CryptoObject00.{R,G,B,A}, CryptoObject01.{R,G,B,A} and so on, each with the ids and coverages of
// two ranks (zero if unused). The last channel of the kind is dropped.CryptoObject, the coverage
// that did not fit.
std::vector<std::string> cryptomatte_channel_names(std::span<const CryptomatteKind> kinds,
                                                   int levels);

// A report on one kind of matte: its number of names, and the number of pixels so far that have
// more ids than can be stored.
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

// Writes the values of the channels in cryptomatte_channel_names() for pixel i of the tile to
// `values`. Uses `ranks` as scratch space. Updates the report of each kind.
void put_cryptomattes(const FilmTile& tile, size_t i, float* values,
                      std::vector<CryptomatteSums::Rank>& ranks,
                      std::span<CryptomatteReport> reports);

// Returns the header attributes of each kind: name, hash, conversion and manifest.
std::vector<std::pair<std::string, std::string>> cryptomatte_attributes(
    std::span<const CryptomatteNames> names);

}  // namespace emberline
