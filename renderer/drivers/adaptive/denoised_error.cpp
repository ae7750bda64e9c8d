#include "renderer/drivers/adaptive/denoised_error.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "renderer/core/archive.h"
#include "renderer/core/parallel.h"
#include "renderer/drivers/adaptive/ordered_sum.h"
#include "renderer/film/channels.h"
#include "renderer/film/film.h"
#include "renderer/film/half_channels.h"
#include "renderer/film/shared_samples.h"
#include "renderer/reconstruction/denoise.h"

namespace emberline {
namespace {

// With fewer samples, one of the two streams may be empty (samplers/sampler.h).
constexpr double kMinSamples = 16.0;
constexpr size_t kGrain = 8192;

// Indices of the channels of half1 (or half2) as ShareResolver returns them. The order is that of
// put_halves(), but the shares for 3 x 3 pixels are replaced by R, G and B of the summed shares.
enum Channel : size_t { kRed, kAlbedo = 3, kFeatures = 6, kSamples = 11, kShared };
constexpr size_t kChannels = kShared + 3;
constexpr int kRowsAtOnce = 64;

// Holds rows of a film as planes: first the planes of the first half, then those of the second.
class HalfRows {
 public:
  HalfRows(const FilmTile& film, int begin, int end)
      : width_(film.rect().width()), rows_(end - begin) {
    const Rect& crop = film.rect();
    const std::vector<std::string> names = names_of(half_channels());
    ShareResolver shared(crop, names, [&](const Rect& rows, std::vector<float>& pixels) {
      pixels.resize(size_t(rows.area()) * names.size());
      const size_t first = crop.index_of(rows.x0, rows.y0);
      parallel_ranges(size_t(rows.area()), kGrain, [&](size_t from, size_t to) {
        for (size_t i = from; i < to; ++i) put_halves(film, first + i, &pixels[i * names.size()]);
      });
    });
    for (std::vector<float>& plane : planes_) plane.reserve(size_t(width_) * size_t(rows_));
    std::vector<float> pixels;
    for (int y = crop.y0 + begin; y < crop.y0 + end; y += kRowsAtOnce) {
      shared.read({crop.x0, y, crop.x1, std::min(y + kRowsAtOnce, crop.y0 + end)}, pixels);
      parallel_each(planes_.size(), [&](size_t c) {
        for (size_t i = c; i < pixels.size(); i += planes_.size()) planes_[c].push_back(pixels[i]);
      });
    }
  }

  DenoiseInput input() const {
    DenoiseInput input;
    input.width = width_;
    input.height = rows_;
    input.samples = halves(kSamples);
    for (size_t c = 0; c < 3; ++c) input.colour[c] = halves(kRed + c);
    for (size_t c = 0; c < 3; ++c) input.albedo[c] = halves(kAlbedo + c);
    for (size_t c = kFeatures; c < kSamples; ++c) input.features.push_back(halves(c));
    for (size_t c = 0; c < 3; ++c) input.shared[c] = halves(kShared + c);
    return input;
  }

 private:
  HalfPlanes halves(size_t channel) const {
    return {planes_[channel], planes_[kChannels + channel]};
  }

  int width_, rows_;
  std::array<std::vector<float>, 2 * kChannels> planes_;
};

template <typename Value>
double mean_of(std::span<const float> values, const Value& value) {
  const double sum = ordered_sum(values.size(), [&](size_t begin, size_t end) {
    double part = 0.0;
    for (size_t i = begin; i < end; ++i) part += double(value(values[i]));
    return part;
  });
  return sum / double(std::max<size_t>(1, values.size()));
}

}  // namespace

bool DenoisedError::update(const FilmTile& film, std::span<const float> counts, bool may_filter,
                           ErrorMap* map, const std::stop_token& stop) {
  samples_ = mean_of(counts, [](float count) { return count; });
  const bool due = samples_ >= std::max(kMinSamples, kFilterGrowth * filtered_at_);
  if (may_filter && due) return filter(film, counts, map, stop);
  write_errors(counts, map);
  return true;
}

bool DenoisedError::filter(const FilmTile& film, std::span<const float> counts, ErrorMap* map,
                           const std::stop_token& stop) {
  const int width = film.rect().width(), height = film.rect().height();
  std::vector<float> square(counts.size());
  for (int begin = 0; begin < height; begin += kDenoiseBandRows) {
    const int end = std::min(height, begin + kDenoiseBandRows);
    const int above = std::max(0, begin - kDenoiseMargin);
    const HalfRows rows(film, above, std::min(height, end + kDenoiseMargin));
    const std::vector<float> error = denoise(rows.input(), begin - above, end - above, stop).error;
    if (stop.stop_requested()) return false;
    const size_t first = size_t(begin) * size_t(width);
    for (size_t i = 0; i < error.size(); ++i) {
      square[first + i] = error[i] * error[i] * counts[first + i];
    }
  }
  square_ = std::move(square);
  filtered_at_ = samples_;
  write_errors(counts, map);
  return true;
}

void DenoisedError::write_errors(std::span<const float> counts, ErrorMap* map) const {
  if (square_.empty()) return;
  parallel_ranges(square_.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      map->error[i] = std::sqrt(square_[i] / std::max(1.0f, counts[i]));
      map->deviation[i] = std::sqrt(square_[i]);
    }
  });
}

void DenoisedError::archive(Archive& archive, size_t pixels) {
  archive.number(filtered_at_, 0.0, double(UINT32_MAX));
  archive.array(square_, pixels);
  archive.check(square_.empty() == (filtered_at_ == 0.0));
  for (const float square : square_) archive.check(square >= 0.0f && std::isfinite(square));
}

double root_mean_square(std::span<const float> values) {
  return std::sqrt(mean_of(values, [](float value) { return square(value); }));
}

}  // namespace emberline
