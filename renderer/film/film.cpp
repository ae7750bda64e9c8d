#include "renderer/film/film.h"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <limits>

#include "renderer/core/archive.h"
#include "renderer/core/parallel.h"
#include "renderer/core/rect_values.h"
#include "renderer/film/finite_float.h"
#include "renderer/film/shadow_sums.h"

namespace emberline {
namespace {

bool is_of_lights(Sums block) {
  return (block >= Sums::kLights && block <= Sums::kLayerRemainders) ||
         block == Sums::kHalfLights || block == Sums::kHalfLightRemainders;
}

// Writes the values of a row whose sums are over `count` samples.
void put_sums(const ChannelRow& row, const double* sums, double count, float* values) {
  if (row.kind == ChannelKind::kVarianceOfHits) {
    const double spread = count > 1 ? std::max(0.0, sums[1] - sums[0] * sums[0] / count) : 0.0;
    *values = count > 1 ? to_finite_float(spread / (count - 1)) : row.background;
    return;
  }
  const bool of_all = row.kind == ChannelKind::kMean;
  for (size_t c = 0; c < row.size(); ++c) {
    values[c] = count == 0.0 ? row.background
                : of_all     ? to_finite_float(sums[c] / count)
                             : to_finite_float(sums[c] * (1.0 / count));
  }
}

}  // namespace

bool is_finite(const FilmSample& sample) {
  return is_finite(sample.value.radiance * sample.filter_weight) &&
         is_finite(sample.value.first_hit) && (!sample.features || is_finite(*sample.features)) &&
         (!sample.catcher || is_finite(*sample.catcher));
}

void FilmTile::reset(const Rect& rect) {
  rect_ = rect;
  part_ = 0;
  // relight_pixel() reads one float beyond the last light sums.
  const bool light = has(Sums::kLights) || has(Sums::kLayers);
  buffer_.reset(pixels() * layout_.bytes_per_pixel() + (light ? sizeof(float) : 0));
  planes_.clear();
  for (const FilmLayout::Part& part : layout_.parts()) {
    planes_.push_back(buffer_.begin() + part.offset * pixels());
  }
  sums_ = reinterpret_cast<PixelSums*>(planes_.front());
  overrides_.reset(0);
  if (stores_sample_variance()) sample_variances_.reset(pixels());
}

bool FilmTile::add(int x, int y, const FilmSample& sample) {
  const size_t i = index(x, y);
  PixelSums& sums = sums_[i];
  sums.count[sample.half]++;
  const bool finite = is_finite(sample);
  if (finite) {
    const Rgb weighted = sample.value.radiance * sample.filter_weight;
    for (int c = 0; c < 3; ++c) sums.rgb[sample.half][c] += double(weighted[c]);
    sums.alpha += double(sample.value.alpha * sample.filter_weight);
    if (sums.id == 0) sums.id = sample.value.first_hit.id;
  } else {
    sums.non_finite++;
  }
  layout_.add(pixel(i), sample, finite);
  return finite;
}

void FilmTile::add_time(int x, int y, double seconds) {
  if (has(Sums::kSeconds)) *at<float>(Sums::kSeconds, index(x, y)) += float(seconds);
}

void FilmTile::set_stop(int x, int y, PixelStop stop, uint32_t judged) {
  if (has(Sums::kStop)) *at<uint8_t>(Sums::kStop, index(x, y)) = stop_value(stop, judged);
}

void FilmTile::set_sample_variance(size_t i, const Rgb& variance) {
  assert(emberline::is_finite(variance));
  if (!sample_variances_.empty()) {
    sample_variances_[i] = {{variance.x, variance.y, variance.z}, true};
  }
}

void FilmTile::mark_stops(uint32_t budget, PixelStop complete, PixelStop unfinished) {
  if (!has(Sums::kStop)) return;
  constexpr size_t kGrain = 16384;
  parallel_ranges(pixels(), kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const uint32_t samples = sums(i).count[0] + sums(i).count[1];
      const PixelStop stop = samples == 0        ? PixelStop::kNone
                             : samples == budget ? complete
                                                 : unfinished;
      *at<uint8_t>(Sums::kStop, i) = stop_value(stop);
    }
  });
}

void FilmTile::set_override(int x, int y, const float* rgba) {
  if (overrides_.empty()) overrides_.reset(pixels());
  ValueOverride& value = overrides_[index(x, y)];
  std::copy_n(rgba, 4, value.rgba);
  value.set = true;
}

void FilmTile::copy_pixel(const FilmTile& from, int x, int y) {
  const size_t i = index(x, y), j = from.index(x, y);
  const std::vector<FilmLayout::Part>&to = layout_.parts(), &have = from.layout_.parts();
  assert(to.size() == have.size());
  for (size_t p = 0; p < to.size(); ++p) {
    assert(have[p].bytes >= to[p].bytes);
    std::memcpy(sums_at<std::byte>(to[p], pixel(i)), sums_at<std::byte>(have[p], from.pixel(j)),
                to[p].bytes);
  }
  if (!sample_variances_.empty()) sample_variances_[i] = from.sample_variances_[j];
  if (!from.overrides_.empty() && from.overrides_[j].set)
    set_override(x, y, from.overrides_[j].rgba);
}

void FilmTile::add_film(const FilmTile& other) {
  assert(rect_ == other.rect_);
  if (overrides_.empty() && !other.overrides_.empty()) overrides_.reset(pixels());
  for (size_t i = 0; i < pixels(); ++i) {
    const double n = sums(i).samples(), m = other.sums(i).samples();
    if (m == 0) continue;
    merge_overrides(other, i, n / (n + m), m / (n + m));
    layout_.merge(pixel(i), other.pixel(i));
  }
}

// Must be called before the sums are merged. Averages overrides and sample variances, weighting
// each film by its sample count. The average of the sample variances, divided by the total sample
// count, is the variance of the merged mean.
void FilmTile::merge_overrides(const FilmTile& other, size_t i, double own_weight,
                               double other_weight) {
  if (!sample_variances_.empty()) {
    SampleVariance& variance = sample_variances_[i];
    const SampleVariance& more = other.sample_variances_[i];
    variance.known = more.known && (variance.known || own_weight == 0);
    for (int c = 0; c < 3; ++c) {
      variance.rgb[c] = to_finite_float(own_weight * double(variance.rgb[c]) +
                                        other_weight * double(more.rgb[c]));
    }
  }
  const bool is_other_overridden = !other.overrides_.empty() && other.overrides_[i].set;
  if (overrides_.empty() || !(overrides_[i].set || is_other_overridden)) return;
  float mine[4], theirs[4];
  put_rgba(i, mine);
  other.put_rgba(i, theirs);
  for (int c = 0; c < 4; ++c) {
    overrides_[i].rgba[c] =
        to_finite_float(own_weight * double(mine[c]) + other_weight * double(theirs[c]));
  }
  overrides_[i].set = true;
}

uint32_t FilmTile::sample_count(int x, int y) const {
  const PixelSums& sums = this->sums(index(x, y));
  return sums.count[0] + sums.count[1];
}

uint32_t FilmTile::min_samples() const {
  uint32_t minimum = pixels() == 0 ? 0 : std::numeric_limits<uint32_t>::max();
  for (size_t i = 0; i < pixels(); ++i)
    minimum = std::min(minimum, sums(i).count[0] + sums(i).count[1]);
  return minimum;
}

Rgb FilmTile::mean(int x, int y) const {
  float rgba[4];
  put_rgba(index(x, y), rgba);
  return {rgba[0], rgba[1], rgba[2]};
}

FilmTile::Surface FilmTile::surface(int x, int y) const {
  const size_t i = index(x, y);
  // The sums are in the order of the group's rows: albedo, N, Z.
  const double* const sums = at<double>(Sums::kSurface, i);
  const uint32_t hits = hits_at(layout_.part(Sums::kSurface), pixel(i));
  const auto per = float(1.0 / this->sums(i).samples());
  Surface out;
  for (int c = 0; c < 3; ++c) out.albedo[c] = to_finite_float(sums[c]) * per;
  for (int c = 0; c < 3; ++c) out.normal[c] = to_finite_float(sums[3 + c]) * per;
  out.nearness = hits > 0 && sums[6] > 0.0 ? to_finite_float(hits / sums[6]) : 0.0f;
  return out;
}

std::optional<Rgb> FilmTile::variance(int x, int y) const {
  const size_t i = index(x, y);
  const PixelSums& sums = this->sums(i);
  const bool two_streams = sums.count[0] > 0 && sums.count[1] > 0;
  const bool spread_is_known = has(Sums::kSquares) && sums.samples() >= 2.0;
  if (!has_sample_variance(i) && !two_streams && !spread_is_known) return std::nullopt;
  Rgb result;
  for (int c = 0; c < 3; ++c) result[c] = to_finite_float(variance_of_mean(i, size_t(c)));
  return result;
}

double FilmTile::variance_of_mean(size_t i, size_t c) const {
  const PixelSums& sums = this->sums(i);
  const double n0 = sums.count[0], n1 = sums.count[1], n = n0 + n1;
  if (has_sample_variance(i)) return double(sample_variances_[i].rgb[c]) / n;
  if (n0 > 0 && n1 > 0) {
    // With two independent streams, the squared difference of their means estimates the variance of
    // a sample times (1 / n0 + 1 / n1), however correlated the samples within a stream are.
    return square(sums.rgb[0][c] / n0 - sums.rgb[1][c] / n1) * (n0 * n1) / (n * n);
  }
  // With one stream, the samples are assumed to be independent, and non-finite samples count as
  // black. The variance is (sum of squares - n mean^2) / (n (n - 1)).
  const double sum = sums.rgb[0][c] + sums.rgb[1][c];
  const double spread = squares(i)[c] - (n > 0 ? sum * sum / n : 0.0);
  return n > 1 ? std::max(0.0, spread) / (n * (n - 1)) : 0.0;
}

void FilmTile::put_rgba(size_t i, float* out) const {
  if (!overrides_.empty() && overrides_[i].set) {
    std::copy_n(overrides_[i].rgba, 4, out);
    return;
  }
  const PixelSums& sums = this->sums(i);
  const double n = sums.samples();
  const double scale = n > 0 ? 1.0 / n : 0.0;
  for (int c = 0; c < 3; ++c) out[c] = to_finite_float((sums.rgb[0][c] + sums.rgb[1][c]) * scale);
  // With filters that have negative lobes, alpha may leave [0, 1].
  double alpha = sums.alpha;
  if (has(Sums::kShadow)) alpha += shadow_alpha(at<double>(Sums::kShadow, i));
  out[3] = to_finite_float(std::clamp(alpha * scale, 0.0, 1.0));
}

// Writes the mean of one layer. If the pixel's value is overridden, the layers are scaled so that
// they add up to the override.
void FilmTile::put_layer(size_t i, PathLayer layer, float* rgb) const {
  const PixelSums& sums = this->sums(i);
  const double n = sums.samples();
  const bool is_overridden = n > 0 && !overrides_.empty() && overrides_[i].set;
  const Rgb mean = layers(i).mean(int(layers_.index_of(layer)));
  for (int c = 0; c < 3; ++c) {
    const double whole = (sums.rgb[0][c] + sums.rgb[1][c]) / n;
    rgb[c] = is_overridden && whole != 0
                 ? to_finite_float(mean[c] * (overrides_[i].rgba[c] / whole))
                 : mean[c];
  }
}

void FilmTile::resolve_rgba(std::vector<float>& out) const {
  out.resize(4 * pixels());
  resolve_rgba(std::span(out));
}

void FilmTile::resolve_rgba(std::span<float> out) const {
  assert(out.size() >= 4 * pixels());
  for (size_t i = 0; i < pixels(); ++i) put_rgba(i, &out[4 * i]);
}

void FilmTile::resolve(std::vector<float>& out, size_t more) const {
  const size_t channels = film_channels(aovs()).size() + more;
  out.resize(channels * pixels());
  size_t first = 0;
  for (const ChannelRow* row : rows_of(aovs())) {
    for (size_t i = 0; i < pixels(); ++i) put_row(*row, i, &out[i * channels + first]);
    first += channels_of(*row).size();
  }
}

void FilmTile::put_row(const ChannelRow& row, size_t i, float* values) const {
  if (row.put) return row.put(*this, i, values);
  const auto [part, first] = layout_.sums_of(row);
  const FilmPixel at = pixel(i);
  if (row.count) {
    std::copy_n(sums_at<uint32_t>(*part, at), row.size(), values);
    return;
  }
  const double count = row.is_of_hits() ? hits_at(*part, at) : sums(i).samples();
  put_sums(row, sums_at<double>(*part, at) + first, count, values);
}

double FilmTile::share_of_samples(const ChannelRow& row, size_t i) const {
  const double samples = sums(i).samples();
  if (samples == 0.0) return 1.0;
  if (row.feed == ChannelFeed::kCatchers) {
    const double weight = shadow_weight(at<double>(Sums::kShadow, i)) / samples;
    return std::clamp(weight, 0.0, 1.0);  // filters may have negative lobes
  }
  if (!row.is_of_hits()) return 1.0;
  return hits_at(*layout_.sums_of(row).part, pixel(i)) / samples;
}

uint64_t FilmTile::bytes() const {
  return buffer_.capacity() + sample_variances_.capacity() * sizeof(SampleVariance) +
         overrides_.capacity() * sizeof(ValueOverride);
}

void FilmTile::archive(Archive& archive) {
  for (const FilmLayout::Part& part : layout_.parts()) {
    if (part.bytes > 0) {
      std::byte* const plane = sums_at<std::byte>(part, pixel(0));
      archive.values(std::span(plane, pixels() * part.bytes));
      // The checkpoint format has an unused float after each block of light sums.
      float unused = 0.0f;
      if (is_of_lights(part.block)) archive.values(std::span(&unused, 1));
    }
    if (part.block == Sums::kStop) {
      archive.values(std::span(sample_variances_.begin(), sample_variances_.size()));
    }
  }
  bool has_overrides = !overrides_.empty();
  archive.number(has_overrides, false, true);
  if (archive.loading()) overrides_.reset(has_overrides ? pixels() : 0);
  archive.values(std::span(overrides_.begin(), overrides_.size()));
  if (archive.loading()) check(archive);
}

// Validates loaded sums, since a checkpoint is untrusted input.
void FilmTile::check(const Archive& archive) const {
  for (size_t i = 0; i < pixels(); ++i) archive.check(layout_.is_valid(pixel(i)));
  // A loaded bool's byte may be neither 0 nor 1, and reading such a bool is undefined behaviour.
  const auto is_flag = [](const bool& flag) {
    uint8_t byte;
    std::memcpy(&byte, &flag, sizeof byte);
    return byte <= 1;
  };
  for (size_t i = 0; i < sample_variances_.size(); ++i) {
    const SampleVariance& variance = sample_variances_[i];
    archive.check(is_flag(variance.known));
    archive.check(!variance.known || sums(i).samples() > 0);
    archive.check(all_finite(variance.rgb));
  }
  for (const ValueOverride& value : overrides_) {
    archive.check(is_flag(value.set) && all_finite(value.rgba));
  }
}

void put_channels(const FilmTile& tile, const Rect& frame, std::span<float> values) {
  std::vector<float> pixels;
  tile.resolve(pixels);
  put_rect(pixels, tile.rect(), frame, values);
}

}  // namespace emberline
