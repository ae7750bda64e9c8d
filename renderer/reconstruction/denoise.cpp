#include "renderer/reconstruction/denoise.h"

#include <cassert>
#include <cmath>

#include "renderer/core/display_error.h"
#include "renderer/core/parallel.h"
#include "renderer/reconstruction/blend.h"
#include "renderer/reconstruction/feature_filter.h"
#include "renderer/reconstruction/filtered_runs.h"

namespace emberline {
namespace {

static_assert(kBlendReach + kWindowRadius + std::max(kPatchRadius, kFeatureReach) + kNoiseRadius +
                  kOutlierRadius <=
              kDenoiseMargin);

HalfPlanes rows_of(const HalfPlanes& planes, size_t first, size_t count) {
  if (planes.a.empty()) return planes;
  return {planes.a.subspan(first, count), planes.b.subspan(first, count)};
}

HalfColour rows_of(const HalfColour& colour, size_t first, size_t count) {
  return {rows_of(colour[0], first, count), rows_of(colour[1], first, count),
          rows_of(colour[2], first, count)};
}

// Rows [begin, end) alone.
DenoiseInput rows_of(const DenoiseInput& input, int begin, int end) {
  const size_t first = size_t(begin) * size_t(input.width);
  const size_t count = size_t(end - begin) * size_t(input.width);
  DenoiseInput rows = {input.width,
                       end - begin,
                       rows_of(input.samples, first, count),
                       rows_of(input.colour, first, count),
                       rows_of(input.albedo, first, count),
                       {},
                       {}};
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

HalfPictures pictures_of(const ColourPlanes& a, const ColourPlanes& b) {
  return {{{&a[0], &a[1], &a[2]}, {&b[0], &b[1], &b[2]}}};
}

Candidates filter_colour(const Halves& h, int begin, int end, const std::stop_token& stop) {
  Candidates candidates;
  for (Candidate& candidate : candidates) {
    candidate.colour.fill(Plane(h.width, h.height));
    candidate.difference.fill(Plane(h.width, h.height));
    candidate.own_weight = Plane(h.width, h.height);
  }
  const HalfPictures halves = pictures_of(h.half[0].colour, h.half[1].colour);
  filter_runs(h, begin, end, {&halves, 1}, stop, [&](size_t, const FilteredRun& run) {
    Candidate& to = candidates[run.bandwidth];
    for (size_t c = 0; c < 3; ++c) {
      std::copy_n(run.colour[c], run.columns, to.colour[c].row(run.y) + run.x);
      std::copy_n(run.difference[c], run.columns, to.difference[c].row(run.y) + run.x);
    }
    std::copy_n(run.own_weight, run.columns, to.own_weight.row(run.y) + run.x);
  });
  return candidates;
}

void add(const Plane& more, Plane& plane) {
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

Part read_part(const Halves& h, const HalfColour& colour) {
  Part part;
  for (size_t c = 0; c < 3; ++c) {
    part.channels[c] = read_channel(h, colour[c]);
    part.filtered[c] = part.channels[c].raw;
  }
  return part;
}

// The parts' raw pictures and their candidates in the shares of the whole.
std::vector<Part> filter_parts(const Halves& h, std::span<const HalfColour> colours,
                               const Blend& shares, int begin, int end,
                               const std::stop_token& stop) {
  std::vector<Part> parts;
  for (const HalfColour& colour : colours) parts.push_back(read_part(h, colour));
  std::vector<HalfPictures> halves(parts.size());
  for (size_t p = 0; p < parts.size(); ++p) {
    const std::array<Channel, 3>& of = parts[p].channels;
    for (size_t s = 0; s < 2; ++s) halves[p][s] = {&of[0].half[s], &of[1].half[s], &of[2].half[s]};
  }
  const int first = std::max(begin - kLostLightReach, 0);
  const int last = std::min(end + kLostLightReach, h.height);
  filter_runs(h, first, last, halves, stop, [&](size_t p, const FilteredRun& run) {
    const float* a = shares.shares[run.bandwidth].row(run.y) + run.x;
    for (size_t c = 0; c < 3; ++c) {
      const float* r = parts[p].channels[c].raw.row(run.y) + run.x;
      float* to = parts[p].filtered[c].row(run.y) + run.x;
      for (int x = 0; x < run.columns; ++x) to[x] += a[x] * (run.colour[c][x] - r[x]);
    }
  });
  for (Part& part : parts) {
    for (size_t c = 0; c < 3; ++c) {
      shares.lost_light->give_back(part.channels[c].raw, part.filtered[c]);
      add(part.channels[c].excess, part.filtered[c]);
    }
  }
  return parts;
}

void tell_errors(const Blend& shares, const Halves& h, int begin, int end, DenoisedPicture& out) {
  constexpr float kLeastShare = 0.01f;  // what is below is left as it was, to the eye
  const size_t width = size_t(h.width);
  out.error.resize(width * size_t(end - begin));
  for (int y = begin; y < end; ++y) {
    for (int x = 0; x < h.width; ++x) {
      const size_t i = size_t(y - begin) * width + size_t(x);
      out.error[i] = std::sqrt(shares.error.row(y)[x]);
      out.squared_error_after += double(shares.error.row(y)[x]);
      out.squared_error_before += double(shares.error_before.row(y)[x]);
      float share = 0.0f;
      for (const Plane& plane : shares.shares) share += plane.row(y)[x];
      out.kept += share < kLeastShare;
    }
  }
}

}  // namespace

DenoisedPicture denoise(const DenoiseInput& input, int begin, int end,
                        const std::stop_token& stop) {
  assert(0 <= begin && begin <= end && end <= input.height);
  if (begin == end || input.width <= 0) return {};
  const int first = std::max(begin - kDenoiseMargin, 0);
  const int last = std::min(end + kDenoiseMargin, input.height);
  const DenoiseInput rows = rows_of(input, first, last);
  begin -= first;
  end -= first;
  const Halves h = prepare_halves(rows);
  const int filter_begin = std::max(begin - kBlendReach, 0);
  const int filter_end = std::min(end + kBlendReach, h.height);
  const Candidates candidates = filter_colour(h, filter_begin, filter_end, stop);
  if (stop.stop_requested()) return {};
  Blend shares = blend(h, candidates);
  DenoisedPicture out;
  for (size_t c = 0; c < 3; ++c) add(h.excess[c], shares.colour[c]);
  out.colour = rows_of(shares.colour, begin, end);
  if (!rows.parts.empty()) {
    for (const Part& part : filter_parts(h, rows.parts, shares, begin, end, stop)) {
      out.parts.push_back(rows_of(part.filtered, begin, end));
    }
    if (stop.stop_requested()) return {};
  }
  tell_errors(shares, h, begin, end, out);
  return out;
}

DenoisedPicture denoise(const DenoiseInput& input, const std::stop_token& stop) {
  return denoise(input, 0, input.height, stop);
}

}  // namespace emberline
