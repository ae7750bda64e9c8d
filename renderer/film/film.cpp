#include "renderer/film/film.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>

#include "renderer/core/archive.h"
#include "renderer/core/names.h"
#include "renderer/core/parallel.h"
#include "renderer/film/finite_float.h"
#include "renderer/film/half_channels.h"

namespace emberline {
namespace {

bool is_finite(const FirstHit& hit) {
  return !hit.hit || (emberline::is_finite(hit.albedo) && emberline::is_finite(hit.normal) &&
                      std::isfinite(hit.depth) && emberline::is_finite(hit.position) &&
                      std::isfinite(hit.uv.x) && std::isfinite(hit.uv.y));
}

}  // namespace

void FilmTile::reset(const Rect& rect) {
  rect_ = rect;
  part_ = 0;
  const auto n = size_t(rect.area());
  sums_.reset(n);
  shown_.reset(0);
  if (aovs_.contains(Aov::kVariance) || extras_.squares) squares_.reset(3 * n);
  if (extras_.rays) rays_.reset(n);
  if (wants_surface()) surfaces_.reset(n);
  if (wants_place()) places_.reset(n);
  if (aovs_.contains(Aov::kVelocity)) velocities_.reset(n);
  if (aovs_.contains(Aov::kClamped)) clamped_.reset(3 * n);
  if (aovs_.contains(Aov::kTime)) seconds_.reset(n);
  if (aovs_.contains(Aov::kStop)) stops_.reset(n);
  if (takes_sample_variance()) sample_variances_.reset(n);
  light_groups_.reset(n);
  path_layers_.reset(n);
  shadows_.reset(n);
  halves_.reset(n);
  cryptomattes_.reset(n);
}

bool FilmTile::add(int x, int y, int half, float filter_weight, const SampleValue& value,
                   const DenoiserFeatures* features, const SampleShares* shares) {
  const size_t i = index(x, y);
  PixelSums& sums = sums_[i];
  sums.count[half]++;
  const Rgb weighted = value.radiance * filter_weight;
  if (!emberline::is_finite(weighted) || !is_finite(value.first_hit) ||
      (features && !emberline::is_finite(*features))) {
    sums.non_finite++;
    return false;
  }
  for (int c = 0; c < 3; ++c) sums.rgb[half][c] += double(weighted[c]);
  sums.alpha += double(value.alpha * filter_weight);
  if (sums.id == 0) sums.id = value.first_hit.id;
  if (!squares_.empty()) {
    for (int c = 0; c < 3; ++c) {
      double& sum = squares_[3 * i + size_t(c)];
      sum = fma(double(weighted[c]), double(weighted[c]), sum);
    }
  }
  if (!surfaces_.empty() && value.first_hit.hit) {
    SurfaceSums& surface = surfaces_[i];
    for (int c = 0; c < 3; ++c) {
      surface.albedo[c] += double(value.first_hit.albedo[c]);
      surface.normal[c] += double(value.first_hit.normal[c]);
    }
    surface.depth += double(value.first_hit.depth);
    surface.hits++;
  }
  if (!places_.empty() && value.first_hit.hit) {
    const FirstHit& hit = value.first_hit;
    places_[i].add({{double(hit.position.x), double(hit.position.y), double(hit.position.z)},
                    {double(hit.uv.x), double(hit.uv.y)},
                    1});
  }
  if (!velocities_.empty()) {
    const FirstHit& hit = value.first_hit;
    velocities_[i].add({double(hit.velocity.x), double(hit.velocity.y), 1, hit.hit ? 1u : 0u});
  }
  if (!clamped_.empty()) {
    const Rgb clamped = value.clamped * filter_weight;
    for (int c = 0; c < 3; ++c) clamped_[3 * i + size_t(c)] += double(clamped[c]);
  }
  if (features) halves_.add(i, half, *features);
  if (shares) halves_.add_shares(i, half, value.radiance, *shares);
  return true;
}

void FilmTile::add_time(int x, int y, double seconds) {
  if (!seconds_.empty()) seconds_[index(x, y)] += float(seconds);
}

void FilmTile::add_rays(int x, int y, uint32_t rays) {
  if (!rays_.empty()) rays_[index(x, y)] += rays;
}

void FilmTile::set_stop(int x, int y, PixelStop stop) {
  if (!stops_.empty()) stops_[index(x, y)] = stop;
}

void FilmTile::set_sample_variance(size_t i, const Rgb& variance) {
  assert(emberline::is_finite(variance));
  if (!sample_variances_.empty()) {
    sample_variances_[i] = {{variance.x, variance.y, variance.z}, true};
  }
}

void FilmTile::mark_stops(uint32_t budget, PixelStop cut_short) {
  constexpr size_t kGrain = 16384;
  parallel_ranges(stops_.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const uint32_t samples = sums_[i].count[0] + sums_[i].count[1];
      stops_[i] = samples == 0        ? PixelStop::kNone
                  : samples == budget ? PixelStop::kBudget
                                      : cut_short;
    }
  });
}

void FilmTile::show(int x, int y, const float* rgba) {
  if (shown_.empty()) shown_.reset(sums_.size());
  ShownValue& value = shown_[index(x, y)];
  std::copy_n(rgba, 4, value.rgba);
  value.set = true;
}

void FilmTile::copy_pixel(const FilmTile& from, int x, int y) {
  const size_t i = index(x, y), j = from.index(x, y);
  sums_[i] = from.sums_[j];
  if (!squares_.empty()) std::copy_n(&from.squares_[3 * j], 3, &squares_[3 * i]);
  if (!rays_.empty()) rays_[i] = from.rays_[j];
  if (!surfaces_.empty()) surfaces_[i] = from.surfaces_[j];
  if (!places_.empty()) places_[i] = from.places_[j];
  if (!velocities_.empty()) velocities_[i] = from.velocities_[j];
  if (!clamped_.empty()) std::copy_n(&from.clamped_[3 * j], 3, &clamped_[3 * i]);
  if (!seconds_.empty()) seconds_[i] = from.seconds_[j];
  if (!stops_.empty()) stops_[i] = from.stops_[j];
  if (!sample_variances_.empty()) sample_variances_[i] = from.sample_variances_[j];
  if (!light_groups_.empty()) light_groups_.copy(from.light_groups_, j, i);
  if (!path_layers_.empty()) path_layers_.copy(from.path_layers_, j, i);
  if (!shadows_.empty()) shadows_.copy(from.shadows_, j, i);
  halves_.copy(from.halves_, j, i);
  cryptomattes_.copy(from.cryptomattes_, j, i);
  if (!from.shown_.empty() && from.shown_[j].set) show(x, y, from.shown_[j].rgba);
}

void FilmTile::add_film(const FilmTile& other) {
  assert(rect_ == other.rect_);
  if (shown_.empty() && !other.shown_.empty()) shown_.reset(sums_.size());
  for (size_t i = 0; i < sums_.size(); ++i) {
    PixelSums& sums = sums_[i];
    const PixelSums& more = other.sums_[i];
    const double n = sums.samples(), m = more.samples();
    if (m == 0) continue;
    add_means_of(other, i, n / (n + m), m / (n + m));
    for (int half = 0; half < 2; ++half) {
      for (int c = 0; c < 3; ++c) sums.rgb[half][c] += more.rgb[half][c];
      sums.count[half] += more.count[half];
    }
    sums.alpha += more.alpha;
    sums.non_finite += more.non_finite;
    if (sums.id == 0) sums.id = more.id;
    for (size_t c = 3 * i; c < 3 * i + 3 && !squares_.empty(); ++c)
      squares_[c] += other.squares_[c];
    if (!rays_.empty()) rays_[i] += other.rays_[i];
    if (!surfaces_.empty()) surfaces_[i].add(other.surfaces_[i]);
    if (!places_.empty()) places_[i].add(other.places_[i]);
    if (!velocities_.empty()) velocities_[i].add(other.velocities_[i]);
    for (size_t c = 3 * i; c < 3 * i + 3 && !clamped_.empty(); ++c)
      clamped_[c] += other.clamped_[c];
    if (!seconds_.empty()) seconds_[i] += other.seconds_[i];
    if (!stops_.empty()) stops_[i] = other.stops_[i];
    if (!light_groups_.empty()) light_groups_.add_sums(other.light_groups_, i);
    if (!path_layers_.empty()) path_layers_.add_sums(other.path_layers_, i);
    if (!shadows_.empty()) shadows_.add_sums(other.shadows_, i);
    halves_.add_sums(other.halves_, i);
    if (!cryptomattes_.empty()) cryptomattes_.add_sums(other.cryptomattes_, i);
  }
}

// Before the sums are added: what stands for a mean is weighted by the samples behind it. The
// variance of a sample, n times that of a mean of n, comes to the same weights.
void FilmTile::add_means_of(const FilmTile& other, size_t i, double here, double there) {
  if (!sample_variances_.empty()) {
    SampleVariance& variance = sample_variances_[i];
    const SampleVariance& more = other.sample_variances_[i];
    variance.known = more.known && (variance.known || here == 0);
    for (int c = 0; c < 3; ++c) {
      variance.rgb[c] =
          to_finite_float(here * double(variance.rgb[c]) + there * double(more.rgb[c]));
    }
  }
  const bool shown_there = !other.shown_.empty() && other.shown_[i].set;
  if (shown_.empty() || !(shown_[i].set || shown_there)) return;
  float mine[4], theirs[4];
  put_rgba(i, mine);
  other.put_rgba(i, theirs);
  for (int c = 0; c < 4; ++c) {
    shown_[i].rgba[c] = to_finite_float(here * double(mine[c]) + there * double(theirs[c]));
  }
  shown_[i].set = true;
}

uint32_t FilmTile::sample_count(int x, int y) const {
  const PixelSums& sums = sums_[index(x, y)];
  return sums.count[0] + sums.count[1];
}

uint32_t FilmTile::least_samples() const {
  uint32_t least = sums_.empty() ? 0 : std::numeric_limits<uint32_t>::max();
  for (const PixelSums& sums : sums_) least = std::min(least, sums.count[0] + sums.count[1]);
  return least;
}

Rgb FilmTile::mean(int x, int y) const {
  float rgba[4];
  put_rgba(index(x, y), rgba);
  return {rgba[0], rgba[1], rgba[2]};
}

FilmTile::Surface FilmTile::surface(int x, int y) const {
  const size_t i = index(x, y);
  const SurfaceSums& sums = surfaces_[i];
  const auto per = float(1.0 / sums_[i].samples());
  Surface out;
  for (int c = 0; c < 3; ++c) out.albedo[c] = to_finite_float(sums.albedo[c]) * per;
  for (int c = 0; c < 3; ++c) out.normal[c] = to_finite_float(sums.normal[c]) * per;
  out.nearness = sums.hits > 0 && sums.depth > 0.0 ? to_finite_float(sums.hits / sums.depth) : 0.0f;
  return out;
}

std::optional<Rgb> FilmTile::variance(int x, int y) const {
  const size_t i = index(x, y);
  const PixelSums& sums = sums_[i];
  const bool two_streams = sums.count[0] > 0 && sums.count[1] > 0;
  if (!knows_sample_variance(i) && !two_streams && (squares_.empty() || sums.samples() < 2.0))
    return std::nullopt;
  Rgb result;
  for (int c = 0; c < 3; ++c) result[c] = to_finite_float(variance_of_mean(i, size_t(c)));
  return result;
}

double FilmTile::variance_of_mean(size_t i, size_t c) const {
  const PixelSums& sums = sums_[i];
  const double n0 = sums.count[0], n1 = sums.count[1], n = n0 + n1;
  if (knows_sample_variance(i)) return double(sample_variances_[i].rgb[c]) / n;
  if (n0 > 0 && n1 > 0) {
    // Two independent streams: the square of their means' difference is the variance of a sample
    // times (1 / n0 + 1 / n1), whatever the samples of one stream owe to each other.
    return square(sums.rgb[0][c] / n0 - sums.rgb[1][c] / n1) * (n0 * n1) / (n * n);
  }
  // One stream: as if its samples were independent, (sum of squares - n mean^2) / (n (n - 1)).
  // Non-finite samples count as the black they were added as.
  const double sum = sums.rgb[0][c] + sums.rgb[1][c];
  const double spread = squares_[3 * i + c] - (n > 0 ? sum * sum / n : 0.0);
  return n > 1 ? std::max(0.0, spread) / (n * (n - 1)) : 0.0;
}

void FilmTile::put_rgba(size_t i, float* out) const {
  if (!shown_.empty() && shown_[i].set) {
    std::copy_n(shown_[i].rgba, 4, out);
    return;
  }
  const PixelSums& sums = sums_[i];
  const double n = sums.samples();
  const double scale = n > 0 ? 1.0 / n : 0.0;
  for (int c = 0; c < 3; ++c) out[c] = to_finite_float((sums.rgb[0][c] + sums.rgb[1][c]) * scale);
  // A filter with negative lobes may leave [0, 1]; coverage may not.
  const double alpha = shadows_.empty() ? sums.alpha : sums.alpha + shadows_.alpha(i);
  out[3] = to_finite_float(std::clamp(alpha * scale, 0.0, 1.0));
}

// Where something else than the mean is shown, each layer is its share of that.
float* FilmTile::put_layers(size_t i, float* out) const {
  const PixelSums& sums = sums_[i];
  const double n = sums.samples();
  const bool shares = n > 0 && !shown_.empty() && shown_[i].set;
  for (int layer = 0; layer < path_layers_.groups(); ++layer) {
    const Rgb mean = path_layers_.mean(i, layer);
    for (int c = 0; c < 3; ++c) {
      const double whole = (sums.rgb[0][c] + sums.rgb[1][c]) / n;
      *out++ =
          shares && whole != 0 ? to_finite_float(mean[c] * (shown_[i].rgba[c] / whole)) : mean[c];
    }
  }
  return out;
}

void FilmTile::resolve_rgba(std::vector<float>& out) const {
  out.resize(4 * sums_.size());
  resolve_rgba(std::span(out));
}

void FilmTile::resolve_rgba(std::span<float> out) const {
  assert(out.size() >= 4 * sums_.size());
  for (size_t i = 0; i < sums_.size(); ++i) put_rgba(i, &out[4 * i]);
}

void FilmTile::resolve(std::vector<float>& out) const {
  const size_t channels = film_channels(aovs_).size();
  out.resize(channels * sums_.size());
  for (size_t i = 0; i < sums_.size(); ++i) {
    const PixelSums& sums = sums_[i];
    const double n = sums.samples();
    float* p = &out[channels * i];
    put_rgba(i, p);
    p += 4;
    *p++ = float(n);
    if (aovs_.contains(Aov::kVariance)) {
      for (size_t c = 0; c < 3; ++c) *p++ = to_finite_float(variance_of_mean(i, c));
    }
    const SurfaceSums* surface = surfaces_.empty() ? nullptr : &surfaces_[i];
    const double per_hit = surface && surface->hits ? 1.0 / surface->hits : 0.0;
    if (aovs_.contains(Aov::kAlbedo)) {
      // Averaged over all samples: a pixel half covered shows half the albedo, as a denoiser wants.
      for (const double a : surface->albedo) *p++ = n > 0 ? to_finite_float(a / n) : 0.0f;
    }
    if (aovs_.contains(Aov::kNormal)) {
      for (const double c : surface->normal) *p++ = n > 0 ? to_finite_float(c / n) : 0.0f;
    }
    if (aovs_.contains(Aov::kDepth)) {
      *p++ = surface->hits ? to_finite_float(surface->depth * per_hit) : kBackgroundDepth;
    }
    const PlaceSums* place = places_.empty() ? nullptr : &places_[i];
    const double per_place = place && place->hits ? 1.0 / place->hits : 0.0;
    if (aovs_.contains(Aov::kPosition)) {
      for (const double x : place->position) *p++ = to_finite_float(x * per_place);
    }
    if (aovs_.contains(Aov::kUv)) {
      for (const double t : place->uv) *p++ = to_finite_float(t * per_place);
    }
    if (aovs_.contains(Aov::kVelocity)) {
      const VelocitySums& velocity = velocities_[i];
      const double scale = velocity.count > 0 ? 1.0 / velocity.count : 0.0;
      *p++ = to_finite_float(velocity.x * scale);
      *p++ = to_finite_float(velocity.y * scale);
    }
    if (aovs_.contains(Aov::kClamped)) {
      for (size_t c = 0; c < 3; ++c) *p++ = n > 0 ? to_finite_float(clamped_[3 * i + c] / n) : 0.0f;
    }
    if (!path_layers_.empty()) p = put_layers(i, p);
    if (aovs_.contains(Aov::kShadow)) {
      const Rgb shadow = shadows_.shadow(i);
      p = std::copy_n(&shadow.x, 3, p);
    }
    if (aovs_.contains(Aov::kDenoising)) p = put_halves(*this, i, p);
    if (aovs_.contains(Aov::kId)) *p++ = float(sums.id);
    if (aovs_.contains(Aov::kTime)) *p++ = to_finite_float(double(seconds_[i]));
    if (aovs_.contains(Aov::kStop)) *p++ = float(stops_[i]);
    if (aovs_.contains(Aov::kNonFinite)) *p++ = float(sums.non_finite);
    if (aovs_.contains(Aov::kPart)) *p++ = float(part_);
  }
}

uint64_t FilmTile::bytes() const {
  return sums_.capacity() * sizeof(PixelSums) + squares_.capacity() * sizeof(double) +
         rays_.capacity() * sizeof(uint32_t) + surfaces_.capacity() * sizeof(SurfaceSums) +
         places_.capacity() * sizeof(PlaceSums) + velocities_.capacity() * sizeof(VelocitySums) +
         clamped_.capacity() * sizeof(double) + seconds_.capacity() * sizeof(float) +
         stops_.capacity() * sizeof(PixelStop) +
         sample_variances_.capacity() * sizeof(SampleVariance) +
         shown_.capacity() * sizeof(ShownValue) + light_groups_.bytes() + path_layers_.bytes() +
         shadows_.bytes() + halves_.bytes() + cryptomattes_.bytes();
}

void FilmTile::archive(Archive& archive) {
  archive.values(std::span(sums_.begin(), sums_.size()));
  archive.values(std::span(squares_.begin(), squares_.size()));
  archive.values(std::span(rays_.begin(), rays_.size()));
  archive.values(std::span(surfaces_.begin(), surfaces_.size()));
  archive.values(std::span(places_.begin(), places_.size()));
  archive.values(std::span(velocities_.begin(), velocities_.size()));
  archive.values(std::span(clamped_.begin(), clamped_.size()));
  archive.values(std::span(seconds_.begin(), seconds_.size()));
  archive.values(std::span(stops_.begin(), stops_.size()));
  archive.values(std::span(sample_variances_.begin(), sample_variances_.size()));
  light_groups_.archive(archive);
  path_layers_.archive(archive);
  shadows_.archive(archive);
  halves_.archive(archive);
  cryptomattes_.archive(archive);
  bool shown = !shown_.empty();
  archive.number(shown, false, true);
  if (archive.loading()) shown_.reset(shown ? sums_.size() : 0);
  archive.values(std::span(shown_.begin(), shown_.size()));
  if (archive.loading()) check(archive);
}

// What was loaded may have been written by anybody: means must be finite, and counts those that the
// arithmetic here is made for.
void FilmTile::check(const Archive& archive) const {
  const auto finite = [&](const auto& values) {
    bool all = true;
    for (const auto value : values) all &= std::isfinite(value);
    archive.check(all);
  };
  constexpr uint32_t kMost = 1u << 25;  // of one stream
  for (const PixelSums& sums : sums_) {
    const uint64_t count = uint64_t(sums.count[0]) + sums.count[1];
    archive.check(sums.count[0] <= kMost && sums.count[1] <= kMost && sums.non_finite <= count);
    finite(sums.rgb[0]);
    finite(sums.rgb[1]);
    archive.check(std::isfinite(sums.alpha));
  }
  finite(squares_);
  finite(clamped_);
  finite(seconds_);
  for (const SurfaceSums& surface : surfaces_) {
    finite(surface.albedo);
    finite(surface.normal);
    archive.check(std::isfinite(surface.depth));
  }
  for (const PlaceSums& place : places_) {
    finite(place.position);
    finite(place.uv);
  }
  for (const VelocitySums& velocity : velocities_) {
    archive.check(std::isfinite(velocity.x) && std::isfinite(velocity.y));
    archive.check(velocity.of_surfaces <= 1);
  }
  for (const PixelStop stop : stops_) archive.check(stop <= PixelStop::kGoingOn);
  // A bool that is neither is no bool to C++: looked at as the byte that it is.
  const auto is_flag = [](const bool& flag) {
    uint8_t byte;
    std::memcpy(&byte, &flag, sizeof byte);
    return byte <= 1;
  };
  for (size_t i = 0; i < sample_variances_.size(); ++i) {
    const SampleVariance& variance = sample_variances_[i];
    archive.check(is_flag(variance.known));
    archive.check(!variance.known || sums_[i].samples() > 0);
    finite(variance.rgb);
  }
  for (const ShownValue& value : shown_) {
    archive.check(is_flag(value.set));
    finite(value.rgba);
  }
}

void put_channels(const FilmTile& tile, const Rect& frame, std::span<float> values) {
  std::vector<float> pixels;
  tile.resolve(pixels);
  const Rect& rect = tile.rect();
  const size_t channels = film_channels(tile.aovs()).size();
  const size_t row = size_t(rect.width()) * channels;
  for (int y = rect.y0; y < rect.y1; ++y) {
    std::copy_n(&pixels[size_t(y - rect.y0) * row], row,
                &values[frame.index_of(rect.x0, y) * channels]);
  }
}

}  // namespace emberline
