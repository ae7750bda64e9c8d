#include "renderer/engine/live_denoiser.h"

#include <algorithm>

#include "renderer/core/parallel.h"
#include "renderer/core/vector.h"
#include "renderer/drivers/bisection_picture.h"
#include "renderer/engine/live_picture.h"
#include "renderer/film/channels.h"
#include "renderer/film/film.h"

namespace emberline {
namespace {

constexpr Aov kChannels[] = {Aov::kVariance, Aov::kAlbedo, Aov::kNormal, Aov::kDepth};

const FilmTile& film_of(const LiveDenoiser::Source& source, int x, int y) {
  const FilmTile& film = source.picture.film();
  if (!source.region || !source.region->rect().contains(x, y)) return film;
  const FilmTile& region = source.region->film();
  return region.sample_count(x, y) > film.sample_count(x, y) ? region : film;
}

// Writes the pixel's features to index `to` of the row. `rgba` is the pixel's displayed colour. If
// `mixed` is set (light groups were remixed), assumes that the noise has changed in proportion to
// luminance.
void read_pixel(const FilmTile& film, int x, int y, const float* rgba, bool mixed,
                const FeatureRow& row, size_t to) {
  const uint32_t samples = film.sample_count(x, y);
  row.samples[to] = float(samples);
  if (samples == 0) return;
  const FilmTile::Surface surface = film.surface(x, y);
  for (size_t c = 0; c < 3; ++c) {
    row.albedo[c][to] = surface.albedo[c];
    row.normal[c][to] = surface.normal[c];
  }
  row.nearness[to] = surface.nearness;
  row.variance[to] = -1.0f;
  const std::optional<Rgb> variance = samples > 1 ? film.variance(x, y) : std::nullopt;
  if (!variance) return;
  row.variance[to] = luminance(*variance);
  if (!mixed) return;
  const float shown_luminance = luminance(Rgb(rgba[0], rgba[1], rgba[2])),
              film_luminance = luminance(film.mean(x, y));
  const float factor = film_luminance > 0.0f ? shown_luminance / film_luminance : 1.0f;
  row.variance[to] *= factor * factor;
}

// Returns, for each of `size` positions, the index of the nearest entry in `lines`.
std::vector<size_t> nearest_lines(const std::vector<int>& lines, int size) {
  std::vector<size_t> nearest;
  for (const LineBlend& line : blend_lines(lines, size, Reconstruction::kDuplicate)) {
    nearest.push_back(size_t(std::ranges::lower_bound(lines, line.lower) - lines.begin()));
  }
  return nearest;
}

}  // namespace

void LiveDenoiser::add_channels(AovSet& aovs) {
  for (const Aov aov : kChannels) aovs.insert(aov);
}

bool LiveDenoiser::has_channels(const AovSet& aovs) {
  return std::ranges::all_of(kChannels, [&](Aov aov) { return aovs.contains(aov); });
}

void LiveDenoiser::denoise(const Source& source, std::span<const float> rgba,
                           std::span<float> denoised) {
  if (source.lattice) return denoise_lattice(source, rgba, denoised);
  const Rect& rect = source.picture.rect();
  const auto width = size_t(rect.width());
  const auto read = [&](int y, const FeatureRow& row) {
    for (size_t x = 0; x < width; ++x) {
      const int film_x = rect.x0 + int(x), film_y = rect.y0 + y;
      read_pixel(film_of(source, film_x, film_y), film_x, film_y,
                 &rgba[4 * (size_t(y) * width + x)], source.mixed, row, x);
    }
  };
  filter_.filter(rect.width(), rect.height(), rgba, read,
                 FastFilter::levels_for(source.samples_per_pixel), denoised);
}

void LiveDenoiser::denoise_lattice(const Source& source, std::span<const float> rgba,
                                   std::span<float> denoised) {
  const Rect& rect = source.picture.rect();
  const auto width = size_t(rect.width());
  const std::vector<int>&columns = source.lattice->columns, &rows = source.lattice->rows;
  const size_t values = 4 * columns.size() * rows.size();
  lattice_rgba_.resize(
      std::max(lattice_rgba_.size(), values));  // does not shrink: growing again would clear it
  lattice_denoised_.resize(lattice_rgba_.size());
  parallel_each(rows.size(), [&](size_t j) {
    for (size_t i = 0; i < columns.size(); ++i) {
      const size_t from = size_t(rows[j]) * width + size_t(columns[i]);
      std::copy_n(&rgba[4 * from], 4, &lattice_rgba_[4 * (j * columns.size() + i)]);
    }
  });
  const auto read = [&](int j, const FeatureRow& row) {
    for (size_t i = 0; i < columns.size(); ++i) {
      read_pixel(source.picture.film(), rect.x0 + columns[i], rect.y0 + rows[size_t(j)],
                 &lattice_rgba_[4 * (size_t(j) * columns.size() + i)], source.mixed, row, i);
    }
  };
  filter_.filter(int(columns.size()), int(rows.size()), std::span(lattice_rgba_).first(values),
                 read, FastFilter::levels_for(1.0), std::span(lattice_denoised_).first(values));
  const std::vector<size_t> column_of = nearest_lines(columns, rect.width());
  const std::vector<size_t> row_of = nearest_lines(rows, rect.height());
  parallel_ranges(row_of.size(), 16, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      float* out = &denoised[4 * y * width];
      if (y > begin && row_of[y] == row_of[y - 1]) {
        std::copy_n(out - 4 * width, 4 * width, out);
        continue;
      }
      const float* from = &lattice_denoised_[4 * row_of[y] * columns.size()];
      for (size_t x = 0; x < width; ++x) std::copy_n(from + 4 * column_of[x], 4, out + 4 * x);
    }
  });
}

}  // namespace emberline
