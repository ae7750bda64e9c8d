#include "renderer/reconstruction/denoise.h"

#include <cassert>
#include <cmath>
#include <optional>

#include "renderer/core/display_error.h"
#include "renderer/core/parallel.h"
#include "renderer/reconstruction/accumulate.h"
#include "renderer/reconstruction/blend.h"
#include "renderer/reconstruction/box.h"
#include "renderer/reconstruction/feature_filter.h"
#include "renderer/reconstruction/patches.h"
#include "renderer/reconstruction/regression.h"

namespace emberline {
namespace {

static_assert(kBlendReach + 2 * kWindowRadius + std::max(kPatchRadius, kFeatureReach) +
                  kNoiseRadius + kOutlierRadius <=
              kDenoiseMargin);
static_assert(kAccumulateReach <= kAcrossMargin);

HalfPlanes rows_of(const HalfPlanes& planes, size_t first, size_t count) {
  if (planes.a.empty()) return planes;
  return {planes.a.subspan(first, count), planes.b.subspan(first, count)};
}

HalfColour rows_of(const HalfColour& colour, size_t first, size_t count) {
  return {rows_of(colour[0], first, count), rows_of(colour[1], first, count),
          rows_of(colour[2], first, count)};
}

DenoiseInput rows_of(const DenoiseInput& input, int begin, int end) {
  const size_t first = size_t(begin) * size_t(input.width);
  const size_t count = size_t(end - begin) * size_t(input.width);
  DenoiseInput rows = {input.width,
                       end - begin,
                       input.x0,
                       input.y0 + begin,
                       rows_of(input.samples, first, count),
                       rows_of(input.colour, first, count),
                       rows_of(input.albedo, first, count),
                       {},
                       input.tolerances,
                       {},
                       rows_of(input.shared, first, count)};
  for (const HalfPlanes& planes : input.features) {
    rows.features.push_back(rows_of(planes, first, count));
  }
  for (const HalfColour& part : input.parts) rows.parts.push_back(rows_of(part, first, count));
  return rows;
}

std::array<std::vector<float>, 3> rows_of(const ColourPlanes& colour, int begin, int end) {
  std::array<std::vector<float>, 3> out;
  for (size_t c = 0; c < 3; ++c) {
    for (int y = begin; y < end; ++y) {
      out[c].insert(out[c].end(), colour[c].row(y), colour[c].row(y) + colour[c].width());
    }
  }
  return out;
}

// Whether any of the kLanes pixels from x on has noise. If none has, the fits around these pixels
// can be skipped, because the noisy pixels in their windows have fits of their own.
bool has_noise(const Halves& halves, int x, int y) {
  for (const Half& half : halves.half) {
    const float* noise = half.noise.row(y) + x;
    for (int i = 0; i < kLanes; ++i) {
      if (noise[i] > 0.0f) return true;
    }
  }
  return false;
}

// Calls body(fit, half, bandwidth) for each fit that contributes to rows [begin, end), from several
// threads. Fits that contribute to the same pixel are never processed concurrently, and are always
// processed in the same order.
template <typename Body>
void for_each_fit(const Halves& halves, FrameOffset frame_offset, int begin, int end,
                  const std::stop_token& stop, const Body& body) {
  begin = std::max(begin - kWindowRadius, 0);
  end = std::min(end + kWindowRadius, halves.height);
  for_each_tile_in_phases(halves.width, begin, end, frame_offset, [&](const Tile& tile) {
    if (stop.stop_requested()) return;
    WindowWeights weights;
    bool measured = false;
    WindowFit fit(halves);
    for (int row = std::max(begin - tile.y, 0); row < std::min(end - tile.y, tile.rows); ++row) {
      for (int column = 0; column < tile.columns; column += kLanes) {
        if (!has_noise(halves, tile.x + column, tile.y + row)) continue;
        if (!measured) weights.measure(halves, tile);
        measured = true;
        fit.set_position(tile, column, row);
        for (int k = 0; k < kBandwidths; ++k) {
          for (size_t s = 0; s < 2; ++s) {
            fit.fit(weights, s, k);
            body(fit, s, size_t(k));
          }
        }
      }
    }
  });
}

// The weight of a pixel's own value, relative to the weights of the fits. If all of the fits'
// weights are negligible, this weight keeps the pixel unchanged.
constexpr float kOwnWeight = 0.02f;
constexpr float kMinWeight = 1e-30f;  // avoids division by zero

void average_fits(const Halves& h, Candidate& to) {
  for_each_row(h.height, [&](int y) {
    const float *share_a = h.share[0].row(y), *share_b = h.share[1].row(y);
    float *weight_a = to.weight[0].row(y), *weight_b = to.weight[1].row(y);
    for (size_t s = 0; s < 2; ++s) {
      const float* known = h.half[s].known.row(y);
      float* weight = to.weight[s].row(y);
      for (int x = 0; x < h.width; ++x) {
        weight[x] = std::max(weight[x] + kOwnWeight * known[x], kMinWeight);
      }
    }
    for (size_t c = 0; c < 3; ++c) {
      const float *own_a = h.half[0].colour[c].row(y), *own_b = h.half[1].colour[c].row(y);
      float *colour = to.colour[c].row(y), *difference = to.difference[c].row(y);
      for (int x = 0; x < h.width; ++x) {
        const float a = (colour[x] + kOwnWeight * own_a[x]) / weight_a[x];
        const float b = (difference[x] + kOwnWeight * own_b[x]) / weight_b[x];
        colour[x] = share_a[x] * a + share_b[x] * b;
        difference[x] = a - b;
      }
    }
  });
}

WindowFit::Picture pictures_of(const ColourPlanes& planes) {
  return {&planes[0], &planes[1], &planes[2]};
}

Candidates filter_colour(const Halves& h, FrameOffset frame_offset, int begin, int end,
                         const std::stop_token& stop) {
  Candidates candidates;
  for (Candidate& candidate : candidates) {
    candidate.colour.fill(BorderedPlane(h.width, h.height));
    candidate.difference.fill(BorderedPlane(h.width, h.height));
    candidate.weight.fill(BorderedPlane(h.width, h.height));
  }
  for_each_fit(h, frame_offset, begin, end, stop, [&](WindowFit& fit, size_t s, size_t bandwidth) {
    Candidate& to = candidates[bandwidth];
    fit.apply(pictures_of(h.half[s].colour));
    fit.add_to(s == 0 ? to.colour : to.difference, nullptr);
    fit.add_weights_to(to.weight[s]);
  });
  for (Candidate& candidate : candidates) average_fits(h, candidate);
  return candidates;
}

void add(const BorderedPlane& more, BorderedPlane& plane) {
  for (int y = 0; y < plane.height(); ++y) {
    const float* from = more.row(y);
    float* to = plane.row(y);
    for (int x = 0; x < plane.width(); ++x) to[x] += from[x];
  }
}

struct Part {
  std::array<Channel, 3> channels;
  ColourPlanes filtered;
};

// `accumulated` contains the halves to filter; if it is null, the frame's own halves are filtered.
Part read_part(const Halves& h, const HalfColour& colour, const HalfColour* accumulated) {
  Part part;
  for (size_t c = 0; c < 3; ++c) {
    Channel& channel = part.channels[c];
    channel = read_channel(h, colour[c]);
    part.filtered[c] = channel.raw;
    if (accumulated == nullptr) continue;
    channel.half = {padded_plane((*accumulated)[c].a, h.width, h.height),
                    padded_plane((*accumulated)[c].b, h.width, h.height)};
  }
  return part;
}

// Indexed by [bandwidth][half]. A fit's weighted prediction of a pixel is multiplied by this
// factor, which includes the division by the total weight.
using Factors = std::array<std::array<BorderedPlane, 2>, kBandwidths>;
Factors factors_of(const Halves& h, const Candidates& candidates, const Blend& shares) {
  Factors factors;
  for (size_t k = 0; k < kBandwidths; ++k) {
    for (size_t s = 0; s < 2; ++s) {
      factors[k][s] = BorderedPlane(h.width, h.height);
      for_each_row(h.height, [&](int y) {
        const float *a = shares.shares[k].row(y), *share = h.share[s].row(y);
        const float* weight = candidates[k].weight[s].row(y);
        float* to = factors[k][s].row(y);
        for (int x = 0; x < h.width; ++x) to[x] = a[x] * share[x] / weight[x];
      });
    }
  }
  return factors;
}

// Subtracts the filtered fraction of each raw pixel of a part, and adds the pixel's own
// contribution to its filtered value. The contributions of the fits are added later.
void add_unfiltered(const Halves& h, const Factors& factors, const Blend& shares, Part& part) {
  for_each_row(h.height, [&](int y) {
    for (size_t c = 0; c < 3; ++c) {
      float* to = part.filtered[c].row(y);
      const float* raw = part.channels[c].raw.row(y);
      for (size_t k = 0; k < kBandwidths; ++k) {
        const float* share = shares.shares[k].row(y);
        for (int x = 0; x < h.width; ++x) to[x] -= share[x] * raw[x];
        for (size_t s = 0; s < 2; ++s) {
          const float *factor = factors[k][s].row(y), *own = part.channels[c].half[s].row(y);
          for (int x = 0; x < h.width; ++x) to[x] += kOwnWeight * factor[x] * own[x];
        }
      }
    }
  });
}

// Radius of the neighbourhood that determines the proportions of the parts.
constexpr int kSplitRadius = 2;
static_assert(kSplitRadius <= kPoolRadius);  // rows that far outside [begin, end) must be filtered

// Distributes the difference between the whole and the sum of the parts among the parts, for rows
// [begin, end).
void distribute_remainder(const ColourPlanes& whole, int begin, int end, std::vector<Part>& parts) {
  const int width = whole[0].width(), height = whole[0].height();
  for (size_t c = 0; c < 3; ++c) {
    std::vector<BorderedPlane> near;
    for (const Part& part : parts) {
      BorderedPlane light(width, height);
      for (int y = 0; y < height; ++y) {
        const float* value = part.filtered[c].row(y);
        for (int x = 0; x < width; ++x) light.row(y)[x] = std::max(value[x], 0.0f);
      }
      near.push_back(box_sum(light, kSplitRadius));
    }
    parallel_each(size_t(std::max(end - begin, 0)), [&](size_t row) {
      const int y = begin + int(row);
      for (int x = 0; x < width; ++x) {
        float rest = whole[c].row(y)[x], all = 0.0f;
        for (const Part& part : parts) rest -= part.filtered[c].row(y)[x];
        for (const BorderedPlane& light : near) all += light.row(y)[x];
        for (size_t p = 0; p < parts.size(); ++p) {
          const float share = all > 0 ? near[p].row(y)[x] / all : 1.0f / float(parts.size());
          parts[p].filtered[c].row(y)[x] += rest * share;
        }
      }
    });
  }
}

// Filters the parts with the weights of the whole. The fits are those of the halves `h`.
std::vector<Part> filter_parts(const Halves& h, std::vector<Part> parts,
                               const Candidates& candidates, const Blend& shares,
                               FrameOffset frame_offset, int begin, int end,
                               const std::stop_token& stop) {
  const Factors factors = factors_of(h, candidates, shares);
  for (Part& part : parts) add_unfiltered(h, factors, shares, part);
  const int first = std::max(begin - kOutlierEnergyReach - kSplitRadius, 0);
  const int last = std::min(end + kOutlierEnergyReach + kSplitRadius, h.height);
  for_each_fit(h, frame_offset, first, last, stop, [&](WindowFit& fit, size_t s, size_t bandwidth) {
    for (Part& part : parts) {
      const std::array<Channel, 3>& of = part.channels;
      fit.apply({&of[0].half[s], &of[1].half[s], &of[2].half[s]});
      fit.add_to(part.filtered, &factors[bandwidth][s]);
    }
  });
  for (Part& part : parts) {
    for (size_t c = 0; c < 3; ++c) {
      shares.outlier_energy->restore(part.channels[c].raw, part.filtered[c]);
      add(part.channels[c].excess, part.filtered[c]);
    }
  }
  return parts;
}

void store_errors(const Blend& shares, const Halves& h, int begin, int end, DenoisedPicture& out) {
  constexpr float kMinFilteredFraction = 0.01f;  // below this fraction, the pixel looks unchanged
  const size_t width = size_t(h.width);
  out.error.resize(width * size_t(end - begin));
  for (int y = begin; y < end; ++y) {
    for (int x = 0; x < h.width; ++x) {
      const size_t i = size_t(y - begin) * width + size_t(x);
      out.error[i] = std::sqrt(shares.error.row(y)[x]);
      out.squared_error_after += double(shares.error.row(y)[x]);
      out.squared_error_before += double(shares.error_before.row(y)[x]);
      float share = 0.0f;
      for (const BorderedPlane& plane : shares.shares) share += plane.row(y)[x];
      out.unchanged_pixels += share < kMinFilteredFraction;
    }
  }
}

// Returns the neighbour with positions only for rows [begin, end) of the frame.
NeighbourFrame rows_of(const NeighbourFrame& neighbour, int begin, int end) {
  const auto width = size_t(neighbour.input.width);
  const size_t first = size_t(begin) * width, count = size_t(end - begin) * width;
  return {neighbour.input, neighbour.x.subspan(first, count), neighbour.y.subspan(first, count)};
}

}  // namespace

DenoisedPicture denoise(const DenoiseInput& input, int begin, int end, const std::stop_token& stop,
                        std::span<const NeighbourFrame> neighbours) {
  assert(0 <= begin && begin <= end && end <= input.height);
  if (begin == end || input.width <= 0) return {};
  const int margin = kDenoiseMargin + (neighbours.empty() ? 0 : kAcrossMargin);
  const int first = std::max(begin - margin, 0);
  const int last = std::min(end + margin, input.height);
  const DenoiseInput rows = rows_of(input, first, last);
  const FrameOffset frame_offset = {rows.x0, rows.y0};
  // `h` is filtered, and its error is measured against `own`.
  const Halves own = neighbours.empty() ? prepare_halves(rows) : prepare_colour(rows);
  std::optional<AccumulatedFrames> accumulated;
  std::optional<Halves> accumulated_halves;
  if (!neighbours.empty()) {
    std::vector<NeighbourFrame> near;
    for (const NeighbourFrame& neighbour : neighbours) {
      near.push_back(rows_of(neighbour, first, last));
    }
    accumulated.emplace(rows, own, near);
    accumulated_halves = prepare_halves(accumulated->input());
  }
  const Halves& h = accumulated_halves ? *accumulated_halves : own;
  begin -= first;
  end -= first;
  const int filter_begin = std::max(begin - kBlendReach, 0);
  const int filter_end = std::min(end + kBlendReach, h.height);
  const Candidates candidates = filter_colour(h, frame_offset, filter_begin, filter_end, stop);
  if (stop.stop_requested()) return {};
  Blend shares = blend(own, candidates);
  DenoisedPicture out;
  for (size_t c = 0; c < 3; ++c) add(own.excess[c], shares.colour[c]);
  out.colour = rows_of(shares.colour, begin, end);
  if (!rows.parts.empty()) {
    std::vector<Part> parts;
    for (size_t p = 0; p < rows.parts.size(); ++p) {
      parts.push_back(
          read_part(own, rows.parts[p], accumulated ? &accumulated->input().parts[p] : nullptr));
    }
    parts = filter_parts(h, std::move(parts), candidates, shares, frame_offset, begin, end, stop);
    if (stop.stop_requested()) return {};
    if (!rows.shared[0].a.empty()) distribute_remainder(shares.colour, begin, end, parts);
    for (const Part& part : parts) out.parts.push_back(rows_of(part.filtered, begin, end));
  }
  store_errors(shares, own, begin, end, out);
  out.frames =
      accumulated ? accumulated->frames(begin, end) : double(end - begin) * double(rows.width);
  return out;
}

DenoisedPicture denoise(const DenoiseInput& input, const std::stop_token& stop,
                        std::span<const NeighbourFrame> neighbours) {
  return denoise(input, 0, input.height, stop, neighbours);
}

}  // namespace emberline
