#include "renderer/film/half_channels.h"

#include <fmt/format.h>

#include <array>

#include "renderer/film/film.h"
#include "renderer/film/finite_float.h"

namespace emberline {
namespace {

constexpr const char* kNames[] = {"R",   "G",   "B",   "albedo.R", "albedo.G",  "albedo.B",
                                  "N.X", "N.Y", "N.Z", "nearness", "visibility"};
static_assert(std::size(kNames) == 3 + kFeatureValues);

double per(uint32_t count) { return count > 0 ? 1.0 / count : 0.0; }

// Returns the pixel's value, which may be overridden, minus the mean of the pixel's samples.
std::array<double, 3> override_offset(const FilmTile& tile, size_t i) {
  const PixelSums& sums = tile.sums(i);
  float rgba[4];
  tile.rgba(tile.rect().x_of(i), tile.rect().y_of(i), rgba);
  std::array<double, 3> shift = {};
  if (sums.samples() == 0) return shift;
  for (size_t c = 0; c < 3; ++c) {
    const double mean = (sums.rgb[0][c] + sums.rgb[1][c]) * (1.0 / sums.samples());
    shift[c] = double(rgba[c]) - double(to_finite_float(mean));
  }
  return shift;
}

}  // namespace

std::vector<PictureChannel> half_channels() {
  std::vector<PictureChannel> channels;
  for (const std::string half : kHalfNames) {
    for (const char* name : kNames) channels.push_back({half + "." + name});
    channels.push_back({half + ".samples", ChannelType::kUint});
    for (size_t k = 0; k < kSharedPixels; ++k) {
      for (const char* c : {"R", "G", "B", "A"}) {
        channels.push_back({fmt::format("{}.shared.{}.{}", half, k, c)});
      }
    }
  }
  return channels;
}

void put_halves(const FilmTile& tile, size_t i, float* values) {
  const PixelSums& sums = tile.sums(i);
  const std::array<double, 3> shift = override_offset(tile, i);
  for (int half = 0; half < 2; ++half) {
    const double scale = per(sums.count[half]);
    for (size_t c = 0; c < 3; ++c) {
      *values++ = sums.count[half] > 0 ? to_finite_float(sums.rgb[half][c] * scale + shift[c]) : 0;
    }
    for (const double sum : tile.halves(i).features[half]) *values++ = to_finite_float(sum * scale);
    *values++ = float(sums.count[half]);
    const std::array<float, kSharedValues>& shared = tile.halves(i).shared[half];
    for (size_t k = 0; k < kSharedValues; k += 4) {
      const double weight = double(shared[k + 3]) * scale;
      for (size_t c = 0; c < 3; ++c) {
        *values++ = to_finite_float(double(shared[k + c]) * scale + shift[c] * weight);
      }
      *values++ = to_finite_float(weight);
    }
  }
}

float* put_half_lights(const FilmTile& tile, size_t i, int half, float* values) {
  const LightGroupSums all = tile.lights(i), second = tile.second_lights(i);
  const uint32_t count = tile.sums(i).count[half];
  for (int group = 0; group < all.groups(); ++group) {
    const std::array<double, 3> sum = all.sum(group), of_second = second.sum(group);
    for (size_t c = 0; c < 3; ++c) {
      const double of_half = half == 1 ? of_second[c] : sum[c] - of_second[c];
      *values++ = to_finite_float(of_half * per(count));
    }
  }
  return values;
}

}  // namespace emberline
