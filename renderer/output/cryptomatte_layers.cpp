#include "renderer/output/cryptomatte_layers.h"

#include <fmt/format.h>

#include <bit>
#include <nlohmann/json.hpp>

#include "renderer/core/murmur3.h"
#include "renderer/film/film.h"

namespace emberline {
namespace {

constexpr size_t kRanksPerLayer = 2;

size_t layer_count(size_t levels) { return (levels + kRanksPerLayer - 1) / kRanksPerLayer; }

std::string hexadecimal(uint32_t id) { return fmt::format("{:08x}", id); }

}  // namespace

const char* cryptomatte_layer_name(CryptomatteKind kind) {
  constexpr const char* kNames[] = {"CryptoObject", "CryptoMaterial", "CryptoAsset"};
  return kNames[size_t(kind)];
}

std::vector<std::string> cryptomatte_channel_names(std::span<const CryptomatteKind> kinds,
                                                   int levels) {
  std::vector<std::string> names;
  for (const CryptomatteKind kind : kinds) {
    for (size_t layer = 0; layer < layer_count(size_t(levels)); ++layer) {
      for (const char channel : {'R', 'G', 'B', 'A'}) {
        names.push_back(fmt::format("{}{:02}.{}", cryptomatte_layer_name(kind), layer, channel));
      }
    }
    names.push_back(fmt::format("dropped.{}", cryptomatte_layer_name(kind)));
  }
  return names;
}

void put_cryptomattes(const FilmTile& tile, size_t i, float* values,
                      std::vector<CryptomatteSums::Rank>& ranks,
                      std::span<CryptomatteReport> reports) {
  ranks.resize(layer_count(size_t(tile.extras().cryptomatte_levels)) * kRanksPerLayer);
  for (size_t kind = 0; kind < reports.size(); ++kind) {
    const float dropped = tile.mattes(i).resolve(kind, tile.sums(i).samples(), ranks);
    for (const CryptomatteSums::Rank& rank : ranks) {
      *values++ = std::bit_cast<float>(rank.id);
      *values++ = rank.coverage;
    }
    *values++ = dropped;
    reports[kind].add(dropped);
  }
}

std::vector<std::pair<std::string, std::string>> cryptomatte_attributes(
    std::span<const CryptomatteNames> names) {
  using Json = nlohmann::json;
  std::vector<std::pair<std::string, std::string>> attributes;
  for (const CryptomatteNames& of_kind : names) {
    const std::string layer = cryptomatte_layer_name(of_kind.kind);
    const std::string begin = "cryptomatte/" + hexadecimal(murmur3_32(layer)).substr(0, 7) + "/";
    Json manifest = Json::object();
    for (const auto& [name, id] : of_kind.ids) manifest[name] = hexadecimal(id);
    attributes.emplace_back(begin + "name", layer);
    attributes.emplace_back(begin + "hash", "MurmurHash3_32");
    attributes.emplace_back(begin + "conversion", "uint32_to_float32");
    attributes.emplace_back(begin + "manifest",
                            manifest.dump(-1, ' ', false, Json::error_handler_t::replace));
  }
  return attributes;
}

}  // namespace emberline
