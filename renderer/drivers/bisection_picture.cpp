#include "renderer/drivers/bisection_picture.h"

#include <algorithm>
#include <cassert>

#include "renderer/core/parallel.h"
#include "renderer/film/film.h"
#include "renderer/film/light_mix.h"

namespace emberline {
namespace {

constexpr NamedValue<Reconstruction> kReconstructions[] = {
    {"duplicate", "copy the nearest pixel that has samples, as in the paper",
     Reconstruction::kDuplicate},
    {"linear", "blend the nearest pixels that have samples", Reconstruction::kLinear},
};

constexpr size_t kChannels = 4;  // R G B A

void blend(const float* lower, const float* upper, float weight, float* out) {
  for (size_t c = 0; c < kChannels; ++c) out[c] = lower[c] + weight * (upper[c] - lower[c]);
}

}  // namespace

std::span<const NamedValue<Reconstruction>> reconstruction_table() { return kReconstructions; }

std::vector<LineBlend> blend_lines(std::span<const int> lines, int size,
                                   Reconstruction reconstruction) {
  assert(!lines.empty());
  std::vector<LineBlend> blends;
  blends.reserve(size_t(size));
  size_t next = 0;  // the first sampled line at or after i
  for (int i = 0; i < size; ++i) {
    while (next < lines.size() && lines[next] < i) ++next;
    const int above = next < lines.size() ? lines[next] : lines.back();
    const int below = above == i || next == 0 ? above : lines[next - 1];
    if (below == above) {
      blends.push_back({below, below, 0.0f});
    } else if (reconstruction == Reconstruction::kLinear) {
      blends.push_back({below, above, float(i - below) / float(above - below)});
    } else {
      const int nearest = i - below <= above - i ? below : above;
      blends.push_back({nearest, nearest, 0.0f});
    }
  }
  return blends;
}

namespace {

// Describes how the picture's columns and rows are computed from a lattice.
struct View {
  std::vector<LineBlend> columns, rows;
};

// Tells whether all, some or none of the pixels in a row of the current step have samples.
enum class RowState : uint8_t { kComplete, kMixed, kEmpty };

bool sampled(const FilmTile& film, int x, int y) {
  return film.sample_count(film.rect().x0 + x, film.rect().y0 + y) > 0;
}

View view_of(const BisectionPicture& p, const PixelLattice& lattice) {
  return {blend_lines(lattice.columns, p.film.rect().width(), p.reconstruction),
          blend_lines(lattice.rows, p.film.rect().height(), p.reconstruction)};
}

// Returns the sampled pixels of a first step that was interrupted. They form a lattice, since the
// first step is one line or one pixel.
PixelLattice sampled_lattice(const BisectionPicture& p) {
  PixelLattice lattice;
  const PixelLattice& first = p.steps.front().added;
  for (const int y : first.rows) {
    for (const int x : first.columns) {
      if (!sampled(p.film, x, y)) continue;
      if (lattice.columns.empty() || lattice.columns.back() != x) lattice.columns.push_back(x);
      if (lattice.rows.empty() || lattice.rows.back() != y) lattice.rows.push_back(y);
    }
  }
  return lattice;
}

// Derives the row states of the current step from the schedule, because reading the film would
// commit its memory too early.
std::vector<RowState> row_states(const BisectionPicture& p) {
  std::vector<RowState> states(size_t(p.film.rect().height()), RowState::kComplete);
  const std::vector<int>& rows = p.steps[p.coverage.complete_steps].added.rows;
  const BisectionPass::Blocks& blocks = p.first_pass.blocks(p.coverage.complete_steps);
  for (size_t j = 0; j < rows.size(); ++j) {
    const size_t first = j / blocks.height * blocks.across, end = first + blocks.across;
    RowState& state = states[size_t(rows[j])];
    if (first >= p.coverage.begun_parts) {
      state = RowState::kEmpty;
    } else if (end > p.coverage.complete_parts) {
      state = RowState::kMixed;
    }
  }
  return states;
}

// Computes consecutive rows of the picture from rows of the film.
class RowReader {
 public:
  RowReader(const FilmTile& film, const LightMix* mix)
      : film_(film), mix_(mix), width_(size_t(film.rect().width())) {}

  void row(const View& view, int y, float* out) {
    const LineBlend& rows = view.rows[size_t(y)];
    if (rows.lower == rows.upper) {
      // In an early picture, many rows are identical to the row before.
      if (view_ == &view && last_row_.line == rows.lower) {
        std::copy_n(last_row_.values, kChannels * width_, out);
      } else {
        expand(view, rows.lower, out);
      }
      last_row_ = {rows.lower, out};
      view_ = &view;
      return;
    }
    const float* lower = cached_row(view, rows.lower, rows.upper);
    const float* upper = cached_row(view, rows.upper, rows.lower);
    for (size_t x = 0; x < width_; ++x) {
      blend(lower + kChannels * x, upper + kChannels * x, rows.weight, out + kChannels * x);
    }
  }

  // Forgets the row that row() wrote last, so that it is not copied. Must be called before that row
  // is changed.
  void invalidate() { view_ = nullptr; }

 private:
  struct Source {
    int line = -1;
    const float* values = nullptr;
  };
  struct CachedRow {
    const View* view = nullptr;
    int line = -1;
    std::vector<float> values;
  };

  void read(int x, int y, float* out) const {
    const int film_x = film_.rect().x0 + x, film_y = film_.rect().y0 + y;
    if (mix_) {
      mix_->sums(film_, film_.rect().index_of(film_x, film_y)).relight_pixel(*mix_, out);
    } else {
      film_.rgba(film_x, film_y, out);
    }
  }

  // Reads a row of the film and fills in the pixels between its sampled columns.
  void expand(const View& view, int y, float* out) const {
    float lower[kChannels], upper[kChannels];
    const LineBlend* before = nullptr;
    for (size_t x = 0; x < width_; ++x, out += kChannels) {
      const LineBlend& columns = view.columns[x];
      if (!before || before->lower != columns.lower) read(columns.lower, y, lower);
      if (columns.lower == columns.upper) {
        std::copy_n(lower, kChannels, out);
      } else {
        if (!before || before->upper != columns.upper) read(columns.upper, y, upper);
        blend(lower, upper, columns.weight, out);
      }
      before = &columns;
    }
  }

  // Returns an expanded row, and caches it for the following rows of the picture. Does not evict
  // the row `other` from the cache.
  const float* cached_row(const View& view, int line, int other) {
    for (const CachedRow& h : cached_rows_) {
      if (h.view == &view && h.line == line) return h.values.data();
    }
    CachedRow& h =
        cached_rows_[cached_rows_[0].view == &view && cached_rows_[0].line == other ? 1 : 0];
    h.view = &view;
    h.line = line;
    h.values.resize(kChannels * width_);
    expand(view, line, h.values.data());
    return h.values.data();
  }

  const FilmTile& film_;
  const LightMix* mix_;
  size_t width_;
  const View* view_ = nullptr;
  Source last_row_;  // the last line that was shown without blending, and its values
  CachedRow cached_rows_[2];
};

}  // namespace

void BisectionPicture::resolve(std::span<float> rgba, const LightMix* mix) const {
  const auto width = size_t(film.rect().width()), height = size_t(film.rect().height());
  assert(rgba.size() == kChannels * width * height);
  const size_t done = coverage.complete_steps;
  if (mix && done == steps.size()) return relight(film, *mix, rgba);
  const PixelLattice coarse_lattice = done > 0 ? steps[done - 1].complete : sampled_lattice(*this);
  if (coarse_lattice.pixels() == 0) {
    std::ranges::fill(rgba, 0.0f);
    return;
  }
  const View coarse = view_of(*this, coarse_lattice);
  const bool has_current_step = done > 0 && done < steps.size() && coverage.begun_parts > 0;
  const View fine = has_current_step ? view_of(*this, steps[done].complete) : View{};
  const std::vector<RowState> states =
      has_current_step ? row_states(*this) : std::vector<RowState>{};
  const auto pixel_sampled = [&](size_t x, const LineBlend& rows) {
    const LineBlend& columns = fine.columns[x];
    return sampled(film, columns.lower, rows.lower) && sampled(film, columns.upper, rows.lower) &&
           sampled(film, columns.lower, rows.upper) && sampled(film, columns.upper, rows.upper);
  };

  // Rows per task. This is enough that most rows can be copied from the row before, and few enough
  // to give all threads work.
  constexpr size_t kGrain = 16;
  parallel_ranges(height, kGrain, [&](size_t begin, size_t end) {
    RowReader from_coarse(film, mix), from_fine(film, mix);
    std::vector<float> fine_row;
    for (size_t y = begin; y < end; ++y) {
      float* out = &rgba[kChannels * width * y];
      const auto state = [&] {
        if (!has_current_step) return RowState::kEmpty;
        const LineBlend& rows = fine.rows[y];
        return std::max(states[size_t(rows.lower)], states[size_t(rows.upper)]);
      }();
      if (state == RowState::kComplete) {
        from_fine.row(fine, int(y), out);
        continue;
      }
      from_coarse.row(coarse, int(y), out);
      if (state == RowState::kEmpty) continue;
      fine_row.resize(kChannels * width);
      RowReader(film, mix).row(fine, int(y), fine_row.data());
      from_coarse.invalidate();
      for (size_t x = 0; x < width; ++x) {
        if (!pixel_sampled(x, fine.rows[y])) continue;
        std::copy_n(&fine_row[kChannels * x], kChannels, out + kChannels * x);
      }
    }
  });
}

}  // namespace emberline
