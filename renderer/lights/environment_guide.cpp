#include "renderer/lights/environment_guide.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "renderer/core/fast_angle.h"
#include "renderer/core/hash.h"
#include "renderer/core/ray.h"
#include "renderer/lights/fixed_cdf.h"
#include "renderer/lights/light_guide.h"

namespace emberline {
namespace {

using sky_tiles::kColumns;
using sky_tiles::kCount;
using sky_tiles::kRows;

// Unguided samples are chosen by light alone. Their weight relative to guided samples is
// kUnguidedShare + kUnguidedPoints / (1 + survey points in the region). We chose both values.
constexpr double kUnguidedShare = 0.3, kUnguidedPoints = 1.0;
// A region that sees less than this fraction of all light is not guided, since its factors could
// overflow float.
constexpr double kMinVisibleLight = 1e-9;
// The residual of a texel is the weight that MIS compensation removed from it. kMinResidual is a
// lower bound on the mean residual of a tile, as a fraction of the largest possible residual.
constexpr double kMinResidual = 1e-3;
// The residual of a tile is averaged over a grid of texels. Along each side of the tile, the grid
// has at least this many texels (or all, if there are fewer) and fewer than twice this many.
constexpr int kTexelsPerSide = 16;

// Returns the last entry of the running sums [first, last] that begins at or before `at`. Requires
// that `at` is below the end of the last entry.
template <class Number>
const Number* entry_at(const Number* first, const Number* last, double at) {
  return std::upper_bound(first, last + 1, at, [](double a, Number b) { return a < double(b); }) -
         1;
}

double next_below(double limit) { return std::nextafter(limit, 0.0); }

float remainder(double at, double from, double to) {
  return std::min(float((at - from) / (to - from)), kOneMinusEpsilon);
}

// Writes the running sums of `count` probabilities. The sums after the last entry with a positive
// probability are exactly 1.
void build_running_sums(const auto& share, int count, float* sums) {
  double sum = 0;
  int end = 0;  // end of the last entry that can be chosen
  for (int i = 0; i < count; ++i) {
    sums[i] = float(sum);
    sum += share(i);
    if (share(i) > 0) end = i + 1;
  }
  std::fill(sums + end, sums + count + 1, 1.0f);
}

// Returns the running sums within a row of tiles, which are stored after the running sums of the
// rows.
auto* columns_of(auto* rows, int row) { return rows + kRows + 1 + row * (kColumns + 1); }

}  // namespace

EnvironmentGuide::EnvironmentGuide(const EnvironmentLight& light) : light_(light), tiles_(kCount) {
  assert(!light.black());
  if (light_.image_) assign_texels_to_tiles();
  measure_residual_light();
  for (int tile = 0; tile < kCount; ++tile) mass_ += mass(tile);
}

// Assigns texels to tiles, and computes each tile's probability in the light's tables.
void EnvironmentGuide::assign_texels_to_tiles() {
  const int width = light_.width_, height = light_.height_;
  tile_of_row_.resize(size_t(height));
  tile_of_column_.resize(size_t(width));
  const auto y_of = [&](double row) { return std::cos(row * kPiD / height); };
  int first_row[kRows + 1];
  std::fill_n(first_row, kRows + 1, height);
  for (int row = height; row-- > 0;) {
    const int band = std::clamp(int((1 - y_of(row + 0.5)) / sky_tiles::kRowHeight), 0, kRows - 1);
    tile_of_row_[size_t(row)] = band * kColumns;
    first_row[band] = row;
  }
  // In a small map, a row of tiles may contain no row of texels.
  for (int band = kRows; band-- > 0;) {
    first_row[band] = std::min(first_row[band], first_row[band + 1]);
  }
  const auto first_column = [&](int column) {
    return int(std::ceil(double(light_.column_offset_) + double(column) * width / kColumns));
  };
  row_sums_.resize(size_t(kColumns) * size_t(height + 1));
  for (int column = 0; column < kColumns; ++column) {
    int first = first_column(column);
    int end = column + 1 < kColumns ? first_column(column + 1) : first_column(0) + width;
    if (first >= width) {
      first -= width;
      end -= width;
    }
    for (int c = first; c < end; ++c) tile_of_column_[size_t(c % width)] = column;
    double* const sums = &row_sums_[size_t(column) * size_t(height + 1)];
    double sum = 0;
    for (int row = 0; row < height; ++row) {
      sums[row] = sum;
      const uint32_t* const rows = &light_.row_sums_[size_t(row)];
      sum += double(rows[1] - rows[0]) / double(kCdfTotal) *
             (column_mass(row, first, end) / double(kCdfTotal));
    }
    sums[height] = sum;
    for (int band = 0; band < kRows; ++band) {
      Tile& tile = tiles_[size_t(band * kColumns + column)];
      tile = {first_row[band], first_row[band + 1], first, end};
      tile.top = y_of(tile.first_row);
      tile.bottom = y_of(tile.end_row);
      tile.solid_angle = (tile.top - tile.bottom) * 2 * kPiD * (end - first) / width;
      tile.table_mass = sums[tile.end_row] - sums[tile.first_row];
    }
  }
}

// Returns the probability of the columns [first, end) within a row of the map, as a number of steps
// of the fixed-point sums.
double EnvironmentGuide::column_mass(int row, int first, int end) const {
  const int width = light_.width_;
  const uint32_t* const sums = sums_of_row(row);
  if (end <= width) return double(sums[end] - sums[first]);
  return double(sums[width] - sums[first]) + double(sums[end - width]);
}

// Returns the mean weight that MIS compensation removes from a texel of the tile.
double EnvironmentGuide::mean_residual(const Tile& tile) const {
  double sum = 0;
  int count = 0;
  const int row_step = std::max(1, (tile.end_row - tile.first_row) / kTexelsPerSide);
  const int column_step = std::max(1, (tile.end_column - tile.first_column) / kTexelsPerSide);
  // Offsets are random, so that no regular structure in the map is missed.
  const auto any = [](int first, int step, int end) {
    return std::min(first + int(hash32(uint32_t(first)) % uint32_t(step)), end - 1);
  };
  for (int r = tile.first_row; r < tile.end_row; r += row_step) {
    const int row = any(r, row_step, tile.end_row);
    for (int c = tile.first_column; c < tile.end_column; c += column_step) {
      const int column = any(c + row, column_step, tile.end_column + row) - row;
      const float luminance = light_.texel_luminance(size_t(row), size_t(column % light_.width_));
      sum += double(std::min(luminance * light_.weight_scale_, light_.threshold_));
      ++count;
    }
  }
  return count > 0 ? sum / count : 0;
}

void EnvironmentGuide::measure_residual_light() {
  residual_density_.assign(kCount, 0.0f);
  double density = 1;  // density per solid angle of a texel of weight 1
  if (light_.image_) {
    const int middle = light_.height_ / 2;
    density = double(light_.row_density_[size_t(middle)]) /
              std::sin((middle + 0.5) * kPiD / light_.height_);
  }
  for (size_t t = 0; t < size_t(kCount); ++t) {
    Tile& tile = tiles_[t];
    if (!(tile.solid_angle > 0)) continue;
    // Use at least kMinResidual, since texels between the examined ones may be bright even if all
    // examined texels are black.
    const double weight =
        light_.image_ ? std::max(mean_residual(tile), kMinResidual * double(light_.threshold_))
                      : 1 / (4 * kPiD);
    const double residual = density * weight;
    tile.residual_mass = residual * tile.solid_angle;
    residual_density_[t] = float(residual);
  }
}

void EnvironmentGuide::set_regions(SkyRegions regions) {
  regions_ = std::move(regions);
  factors_.resize(size_t(regions_.count()) * kCount);
  sums_.resize(size_t(regions_.count()) * kSums);
  for (int region = 0; region < regions_.count(); ++region) build_region(region);
  regions_.release_visibility();
}

void EnvironmentGuide::build_region(int region) {
  const std::span<const float> visibility = regions_.visibility(region);
  double visible = 0;
  for (int t = 0; t < kCount; ++t) visible += mass(t) * double(visibility[size_t(t)]);
  // If the region saw hardly any light in the survey, all of its samples are chosen by light alone.
  const double doubt = kUnguidedShare + kUnguidedPoints / (1 + double(regions_.places(region)));
  const double unguided = visible > kMinVisibleLight * mass_ ? doubt * visible / mass_ : 1;
  const double total = visible + unguided * mass_;
  float* const factors = &factors_[size_t(region) * kCount];
  for (int t = 0; t < kCount; ++t)
    factors[t] = float((double(visibility[size_t(t)]) + unguided) / total);
  const auto share_of = [&](int tile) { return mass(tile) * double(factors[tile]); };
  float* const rows = &sums_[size_t(region) * kSums];
  double row_shares[kRows] = {};
  for (int row = 0; row < kRows; ++row) {
    for (int c = 0; c < kColumns; ++c) row_shares[row] += share_of(row * kColumns + c);
    const auto columns = [&](int c) { return share_of(row * kColumns + c) / row_shares[row]; };
    if (row_shares[row] > 0) build_running_sums(columns, kColumns, columns_of(rows, row));
  }
  build_running_sums([&](int row) { return row_shares[row]; }, kRows, rows);
}

// Chooses the row of tiles by u.y and the column by u.x. Both numbers are rescaled to the position
// within the tile, so they stay stratified.
int EnvironmentGuide::choose_tile(int region, Vec2f* u) const {
  const float* const rows = &sums_[size_t(region) * kSums];
  const auto choose = [](const float* sums, int count, float* number) {
    const float* const chosen = entry_at(sums, sums + count, double(*number));
    *number = remainder(double(*number), double(chosen[0]), double(chosen[1]));
    return int(chosen - sums);
  };
  const int row = choose(rows, kRows, &u->y);
  return row * kColumns + choose(columns_of(rows, row), kColumns, &u->x);
}

EnvironmentGuide::RowChoice EnvironmentGuide::choose_row(int tile_index, const Vec2f& u,
                                                         float* row) const {
  const Tile& tile = tiles_[size_t(tile_index)];
  const int width = light_.width_;
  const double* const rows = &row_sums_[size_t(tile_index % kColumns) * size_t(light_.height_ + 1)];
  const double begin = rows[tile.first_row], end = rows[tile.end_row];
  const double at = std::min(begin + double(u.y) * (end - begin), next_below(end));
  const double* const r = entry_at(rows + tile.first_row, rows + tile.end_row, at);
  const int y = int(r - rows);
  *row = light_.sample_row(y, remainder(at, r[0], r[1]));

  const uint32_t* const sums = sums_of_row(y);
  int first = tile.first_column, last = std::min(tile.end_column, width);
  double along = double(u.x) * column_mass(y, tile.first_column, tile.end_column);
  if (const double before_end = double(sums[last] - sums[first]);
      tile.end_column > width && along >= before_end) {
    along -= before_end;
    first = 0;
    last = tile.end_column - width;
  }
  __builtin_prefetch(sums + (first + last) / 2);
  return {sums + first, sums + last,
          std::min(along + double(sums[first]), next_below(double(sums[last])))};
}

float EnvironmentGuide::choose_column(const RowChoice& choice) const {
  const uint32_t* const c = entry_at(choice.first, choice.last, choice.along);
  const auto column = size_t(c - light_.column_sums_.data()) % (size_t(light_.width_) + 1);
  return EnvironmentLight::sample_column(int(column),
                                         remainder(choice.along, double(c[0]), double(c[1])));
}

void EnvironmentGuide::choose_uniformly(int tile_index, const Vec2f& u, float* column,
                                        float* row) const {
  const Tile& tile = tiles_[size_t(tile_index)];
  *column = float(tile.first_column) - 0.5f + u.x * float(tile.end_column - tile.first_column);
  // `down` is 1 - y and `up` is 1 + y, so sin^2 theta = down x up.
  const double down = (1 - tile.top) + double(u.y) * (tile.top - tile.bottom), up = 2 - down;
  const float theta = fast_atan2(float(std::sqrt(std::max(0.0, down * up))), float(1 - down));
  *row = theta * light_.row_scale_ - 0.5f;
}

Vec3f EnvironmentGuide::direction_in(int tile, float u_part, const Vec2f& u) const {
  if (!light_.image_) return sky_tiles::direction_in(tile, u);
  alignas(64) float column[kRayBatch] = {}, row[kRayBatch] = {};
  if (double(u_part) * mass(tile) < tiles_[size_t(tile)].table_mass) {
    column[0] = choose_column(choose_row(tile, u, row));
  } else {
    choose_uniformly(tile, u, column, row);
  }
  EnvironmentLight::BilinearTaps places;
  EnvironmentSample sample;
  light_.sample_taps(1, column, row, &places, &sample);
  return sample.direction;
}

// `light_density` is the density of the light's own tables in this direction.
float EnvironmentGuide::density(const EnvironmentLight::BilinearTaps& places, size_t i,
                                float light_density, int region) const {
  const float* const factors = &factors_[size_t(region) * kCount];
  const int row0 = tile_of_row_[size_t(places.row0[i])],
            row1 = tile_of_row_[size_t(places.row1[i])];
  const int column0 = tile_of_column_[size_t(places.column0[i])];
  const int column1 = tile_of_column_[size_t(places.column1[i])];
  const int tile =
      (places.to_row1[i] < 0.5f ? row0 : row1) + (places.to_column1[i] < 0.5f ? column0 : column1);
  const float residual = residual_density_[size_t(tile)] * factors[tile];
  if (row0 == row1 && column0 == column1) return std::fma(light_density, factors[tile], residual);
  EnvironmentLight::CornerWeights w = light_.weights_at(places, i);
  w.upper0 *= factors[row0 + column0];
  w.upper1 *= factors[row0 + column1];
  w.lower0 *= factors[row1 + column0];
  w.lower1 *= factors[row1 + column1];
  return residual + light_.density_of(w, places, i);
}

void EnvironmentGuide::sample_constant(std::span<const GuidedRequest> requests,
                                       EnvironmentSample* out) const {
  for (size_t i = 0; i < requests.size(); ++i) {
    Vec2f u = requests[i].u;
    const int tile = choose_tile(requests[i].region, &u);
    out[i] = {sky_tiles::direction_in(tile, u), light_.constant_};
    out[i].pdf = residual_density_[size_t(tile)] *
                 factors_[size_t(requests[i].region) * kCount + size_t(tile)];
  }
}

void EnvironmentGuide::sample_map(std::span<const GuidedRequest> requests,
                                  EnvironmentSample* out) const {
  alignas(64) float column[kRayBatch] = {}, row[kRayBatch] = {};
  RowChoice choices[kRayBatch];
  for (size_t i = 0; i < requests.size(); ++i) {
    Vec2f u = requests[i].u;
    const int tile = choose_tile(requests[i].region, &u);
    if (double(requests[i].u_part) * mass(tile) < tiles_[size_t(tile)].table_mass) {
      choices[i] = choose_row(tile, u, &row[i]);
    } else {
      choose_uniformly(tile, u, &column[i], &row[i]);
    }
  }
  for (size_t i = 0; i < requests.size(); ++i) {
    if (choices[i].first) column[i] = choose_column(choices[i]);
  }
  EnvironmentLight::BilinearTaps places;
  light_.sample_taps(requests.size(), column, row, &places, out);
  for (size_t i = 0; i < requests.size(); ++i) {
    out[i].pdf = density(places, i, out[i].pdf, requests[i].region);
  }
}

// Requests without a region and requests that choose the sun use the light's own sampling.
void EnvironmentGuide::sample(std::span<const GuidedRequest> requests,
                              EnvironmentSample* out) const {
  assert(requests.size() <= size_t(kRayBatch));
  const float sun_share = light_.sun_.share;
  GuidedRequest guided[kRayBatch];
  Vec2f own[kRayBatch];
  size_t guided_from[kRayBatch], own_from[kRayBatch];
  size_t guided_count = 0, own_count = 0;
  for (size_t i = 0; i < requests.size(); ++i) {
    const GuidedRequest& request = requests[i];
    if (request.region == SkyRegions::kNone || request.u.x < sun_share) {
      own_from[own_count] = i;
      own[own_count++] = request.u;
      continue;
    }
    guided_from[guided_count] = i;
    GuidedRequest& g = guided[guided_count++] = request;
    if (sun_share > 0.0f) {
      g.u.x = std::min((g.u.x - sun_share) / (1.0f - sun_share), kOneMinusEpsilon);
    }
  }
  EnvironmentSample samples[kRayBatch];
  if (light_.image_) {
    sample_map({guided, guided_count}, samples);
  } else {
    sample_constant({guided, guided_count}, samples);
  }
  for (size_t k = 0; k < guided_count; ++k) {
    EnvironmentSample& s = samples[k];
    if (sun_share > 0.0f) light_.add_sun({&s.direction, 1}, &s.radiance, &s.pdf);
    out[guided_from[k]] = s;
  }
  if (own_count == 0) return;
  light_.sample({own, own_count}, samples);
  for (size_t k = 0; k < own_count; ++k) {
    EnvironmentSample& s = samples[k];
    const int region = requests[own_from[k]].region;
    if (region != SkyRegions::kNone) {
      radiance_and_pdf({&s.direction, 1}, {&region, 1}, &s.radiance, &s.pdf);
    }
    out[own_from[k]] = s;
  }
}

void EnvironmentGuide::radiance_and_pdf(std::span<const Vec3f> directions,
                                        std::span<const int> regions, Rgb* radiance,
                                        float* pdf) const {
  EnvironmentLight::BilinearTaps places;
  light_.radiance_and_pdf(directions, &places, radiance, pdf);
  for (size_t i = 0; i < directions.size(); ++i) {
    if (regions[i] == SkyRegions::kNone) continue;
    if (light_.image_) {
      pdf[i] = density(places, i, pdf[i], regions[i]);
    } else {
      const auto tile = size_t(sky_tiles::tile_of(directions[i]));
      pdf[i] = residual_density_[tile] * factors_[size_t(regions[i]) * kCount + tile];
    }
  }
  if (light_.sun_.share > 0.0f) light_.add_sun(directions, radiance, pdf);
}

std::string EnvironmentGuide::describe() const {
  return fmt::format("environment guide ({} regions, {:.1f} MiB)", regions_.count(),
                     double(bytes()) / 1048576);
}

std::string LightGuide::describe() const {
  if (factors == KindFactors{}) return environment->describe();
  std::string text = fmt::format("light sampling factors (environment x {:g}, directional x {:g})",
                                 factors.environment, factors.directional);
  if (environment) text += ", " + environment->describe();
  return text;
}

uint64_t EnvironmentGuide::bytes() const {
  return regions_.bytes() + (row_sums_.size() * sizeof(double)) +
         (factors_.size() + sums_.size() + residual_density_.size()) * sizeof(float) +
         (tile_of_row_.size() + tile_of_column_.size()) * sizeof(int);
}

}  // namespace emberline
