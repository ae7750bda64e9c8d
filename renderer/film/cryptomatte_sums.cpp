#include "renderer/film/cryptomatte_sums.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

#include "renderer/core/archive.h"
#include "renderer/core/option_values.h"
#include "renderer/film/finite_float.h"

namespace emberline {
namespace {

constexpr NamedValue<CryptomatteKind> kKinds[] = {
    {"object", "mattes of what has a name: nodes with a mesh", CryptomatteKind::kObject},
    {"material", "mattes of materials", CryptomatteKind::kMaterial},
    {"asset", "mattes of the topmost nodes, with all that is below them", CryptomatteKind::kAsset},
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

void CryptomatteSums::reset(size_t pixels) {
  const size_t lists = levels_ > 0 ? pixels * kinds_ : 0;
  ids_.reset(lists * levels_);
  weights_.reset(lists * (levels_ + 1));
}

void CryptomatteSums::add(size_t pixel, float filter_weight, std::span<const uint32_t> ids) {
  assert(ids.size() == kinds_);
  for (size_t kind = 0; kind < kinds_; ++kind) {
    add_to(list_of(pixel, kind), ids[kind], double(filter_weight));
  }
}

void CryptomatteSums::add_to(size_t list, uint32_t id, double weight) {
  uint32_t* const ids = &ids_[list * levels_];
  double* const weights = &weights_[list * (levels_ + 1)];
  size_t least = 0;
  for (size_t i = 0; i < levels_; ++i) {
    if (ids[i] == id || ids[i] == 0) {
      ids[i] = id;
      weights[i] += weight;
      return;
    }
    if (weights[i] <= weights[least]) least = i;
  }
  weights[levels_] += weights[least];
  ids[least] = id;
  weights[least] = weight;
}

void CryptomatteSums::add_sums(const CryptomatteSums& from, size_t pixel) {
  assert(from.kinds_ == kinds_ && (kinds_ == 0 || from.levels_ == levels_));
  for (size_t list = list_of(pixel, 0); list < list_of(pixel + 1, 0); ++list) {
    const double* const weights = &from.weights_[list * (levels_ + 1)];
    for (size_t i = 0; i < levels_ && from.ids_[list * levels_ + i] != 0; ++i) {
      add_to(list, from.ids_[list * levels_ + i], weights[i]);
    }
    weights_[list * (levels_ + 1) + levels_] += weights[levels_];
  }
}

void CryptomatteSums::copy(const CryptomatteSums& from, size_t from_pixel, size_t pixel) {
  assert(from.kinds_ == kinds_ && (kinds_ == 0 || from.levels_ == levels_));
  if (empty()) return;
  const size_t ids = kinds_ * levels_, weights = kinds_ * (levels_ + 1);
  std::copy_n(&from.ids_[from_pixel * ids], ids, &ids_[pixel * ids]);
  std::copy_n(&from.weights_[from_pixel * weights], weights, &weights_[pixel * weights]);
}

float CryptomatteSums::resolve(size_t pixel, size_t kind, double samples,
                               std::span<Rank> ranks) const {
  const size_t list = list_of(pixel, kind);
  const uint32_t* const ids = &ids_[list * levels_];
  const double* const weights = &weights_[list * (levels_ + 1)];
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
  // Of equals the smaller id, so that the order of their samples does not show.
  std::sort(ranks.begin(), ranks.begin() + ptrdiff_t(levels_), [](const Rank& a, const Rank& b) {
    return a.coverage != b.coverage ? a.coverage > b.coverage : a.id < b.id;
  });
  return to_finite_float(std::max(weights[levels_], 0.0) * scale);
}

void CryptomatteSums::archive(Archive& archive) {
  archive.values(std::span(ids_.begin(), ids_.size()));
  archive.values(std::span(weights_.begin(), weights_.size()));
  if (!archive.loading()) return;
  bool sound = true;
  // As floats they are written to files.
  for (const uint32_t id : ids_) sound &= id == 0 || std::isnormal(std::bit_cast<float>(id));
  for (const double weight : weights_) sound &= std::abs(weight) <= 1e30;
  archive.check(sound);
}

}  // namespace emberline
