#include "renderer/film/cryptomatte_sums.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

#include "renderer/core/option_values.h"
#include "renderer/film/finite_float.h"

namespace emberline {
namespace {

constexpr NamedValue<CryptomatteKind> kKinds[] = {
    {"object", "mattes of nodes that have a mesh", CryptomatteKind::kObject},
    {"material", "mattes of materials", CryptomatteKind::kMaterial},
    {"asset", "mattes of the topmost nodes, with all nodes below them", CryptomatteKind::kAsset},
};

}  // namespace

std::span<const NamedValue<CryptomatteKind>> cryptomatte_table() { return kKinds; }

std::vector<CryptomatteKind> parse_cryptomattes(std::string_view list) {
  std::vector<CryptomatteKind> kinds;
  for (const std::string_view name : split_list(list)) {
    kinds.push_back(find_named(kKinds, "`cryptomatte`", "kind", name).value);
  }
  std::ranges::sort(kinds);
  kinds.erase(std::unique(kinds.begin(), kinds.end()), kinds.end());
  return kinds;
}

size_t CryptomatteSums::id_bytes(const FilmExtras& extras) {
  return size_t(extras.cryptomattes) * size_t(extras.cryptomatte_levels) * sizeof(uint32_t);
}

size_t CryptomatteSums::weight_bytes(const FilmExtras& extras) {
  if (extras.cryptomatte_levels == 0) return 0;
  return size_t(extras.cryptomattes) * size_t(extras.cryptomatte_levels + 1) * sizeof(double);
}

void CryptomatteSums::add(float filter_weight, std::span<const uint32_t> ids) {
  assert(ids.size() == kinds_);
  for (size_t kind = 0; kind < kinds_; ++kind) add_to(kind, ids[kind], double(filter_weight));
}

void CryptomatteSums::add_to(size_t kind, uint32_t id, double weight) {
  uint32_t* const ids = &ids_[kind * levels_];
  double* const weights = &weights_[kind * (levels_ + 1)];
  size_t smallest = 0;
  for (size_t i = 0; i < levels_; ++i) {
    if (ids[i] == id || ids[i] == 0) {
      ids[i] = id;
      weights[i] += weight;
      return;
    }
    if (weights[i] <= weights[smallest]) smallest = i;
  }
  weights[levels_] += weights[smallest];
  ids[smallest] = id;
  weights[smallest] = weight;
}

void CryptomatteSums::merge(const CryptomatteSums& more) {
  assert(more.kinds_ == kinds_ && more.levels_ == levels_);
  for (size_t kind = 0; kind < kinds_; ++kind) {
    const uint32_t* const ids = &more.ids_[kind * levels_];
    const double* const weights = &more.weights_[kind * (levels_ + 1)];
    for (size_t i = 0; i < levels_ && ids[i] != 0; ++i) add_to(kind, ids[i], weights[i]);
    weights_[kind * (levels_ + 1) + levels_] += weights[levels_];
  }
}

float CryptomatteSums::resolve(size_t kind, double samples, std::span<Rank> ranks) const {
  const uint32_t* const ids = &ids_[kind * levels_];
  const double* const weights = &weights_[kind * (levels_ + 1)];
  double sum = 0.0, positive = 0.0;
  for (size_t i = 0; i <= levels_; ++i) {
    sum += weights[i];
    positive += std::max(weights[i], 0.0);
  }
  double scale = samples > 0 ? 1.0 / samples : 0.0;
  if (positive > sum || sum > samples) {
    scale *= positive > 0.0 ? std::clamp(sum, 0.0, samples) / positive : 0.0;
  }
  for (size_t i = 0; i < levels_; ++i) {
    ranks[i] = {ids[i], to_finite_float(std::max(weights[i], 0.0) * scale)};
    if (!(ranks[i].coverage > 0.0f)) ranks[i] = {};
  }
  // Ties go to the smaller id, so that the order of samples does not matter.
  std::sort(ranks.begin(), ranks.begin() + ptrdiff_t(levels_), [](const Rank& a, const Rank& b) {
    return a.coverage != b.coverage ? a.coverage > b.coverage : a.id < b.id;
  });
  return to_finite_float(std::max(weights[levels_], 0.0) * scale);
}

bool CryptomatteSums::is_valid() const {
  return std::all_of(
             ids_, ids_ + kinds_ * levels_,
             [](uint32_t id) { return id == 0 || std::isnormal(std::bit_cast<float>(id)); }) &&
         std::all_of(weights_, weights_ + kinds_ * (levels_ + 1),
                     [](double weight) { return std::abs(weight) <= 1e30; });
}

}  // namespace emberline
