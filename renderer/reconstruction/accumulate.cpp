#include "renderer/reconstruction/accumulate.h"

#include "renderer/reconstruction/align.h"
#include "renderer/reconstruction/box.h"
#include "renderer/reconstruction/patches.h"

namespace emberline {
namespace {

constexpr float kAlbedoTolerance = 0.02f;
constexpr int kFeatureNoiseRadius = 1;
// The colours are compared over two neighbourhoods: a small one, to find misaligned edges, and a
// large one, to find changed light. These values were chosen on four sequences
// (tests/bench/results/denoising.md).
struct Comparison {
  int radius, power;
};
constexpr Comparison kComparisons[] = {{1, 1}, {6, 2}};
static_assert(kComparisons[1].radius + kNoiseRadius + kOutlierRadius <= kAccumulateReach);
constexpr float kMinSquaredColour = 1e-5f;  // almost black on a display
constexpr float kRoundingShare = 1e-4f;     // rounding error, relative to the squared colour
constexpr float kMinAgreement = 1e-3f;

// A feature's mean over both halves, with the variance of this mean.
Feature unfiltered_feature(const HalfPlanes& planes, int width, int height) {
  const BorderedPlane a = padded_plane(planes.a, width, height);
  const BorderedPlane b = padded_plane(planes.b, width, height);
  Feature feature = {BorderedPlane(width, height), BorderedPlane(width, height)};
  for_each_pixel(width, height, [&](int x, int y) {
    const float p = a.row(y)[x], q = b.row(y)[x];
    feature.value.row(y)[x] = 0.5f * (p + q);
    feature.noise.row(y)[x] = 0.25f * (p - q) * (p - q);
  });
  feature.noise = box_mean(feature.noise, kFeatureNoiseRadius);
  return feature;
}

struct ComparedFeature {
  Feature feature;
  float tolerance;
};
std::vector<ComparedFeature> compared_features(const DenoiseInput& input,
                                               std::span<const float> tolerances) {
  std::vector<ComparedFeature> out;
  const auto add = [&](const HalfPlanes& planes, float tolerance) {
    out.push_back({unfiltered_feature(planes, input.width, input.height), tolerance});
  };
  if (!input.albedo[0].a.empty()) {
    for (const HalfPlanes& planes : input.albedo) add(planes, kAlbedoTolerance);
  }
  for (size_t k = 0; k < std::min(tolerances.size(), input.features.size()); ++k) {
    add(input.features[k], tolerances[k]);
  }
  return out;
}

// Returns the likelihood that both frames show the same surface, or 0 where a half of either frame
// has no samples.
BorderedPlane agreement(const Halves& here, const Halves& there,
                        std::span<const ComparedFeature> own,
                        std::span<const ComparedFeature> other) {
  BorderedPlane weights(here.width, here.height);
  for_each_row(here.height, [&](int y) {
    std::vector<float> distance(size_t(here.width), 0.0f);
    for (size_t k = 0; k < own.size(); ++k) {
      const float *p = own[k].feature.value.row(y), *q = other[k].feature.value.row(y);
      const float *vp = own[k].feature.noise.row(y), *vq = other[k].feature.noise.row(y);
      const float tolerance = own[k].tolerance * own[k].tolerance;
      for (size_t x = 0; x < distance.size(); ++x) {
        const float d = p[x] - q[x], noise = vp[x] + std::min(vp[x], vq[x]);
        distance[x] = std::max(distance[x], (d * d - noise) / std::max(tolerance, vp[x]));
      }
    }
    const float *p = here.both_known.row(y), *q = there.both_known.row(y);
    for (size_t x = 0; x < distance.size(); ++x) {
      weights.row(y)[x] = exp_minus(distance[x]) * p[x] * q[x];
    }
  });
  return weights;
}

// Returns the part of the squared colour difference that noise does not explain, divided by the
// noise and multiplied by `weights`.
BorderedPlane colour_distance(const Half& here, const Half& there, const BorderedPlane& weights) {
  BorderedPlane out(weights.width(), weights.height());
  for_each_pixel(out.width(), out.height(), [&](int x, int y) {
    float squared = 0.0f, brightness = 0.0f;
    for (size_t c = 0; c < 3; ++c) {
      const float p = here.colour[c].row(y)[x], d = p - there.colour[c].row(y)[x];
      squared += d * d;
      brightness += p * p;
    }
    const float vp = here.noise.row(y)[x], vq = there.noise.row(y)[x];
    out.row(y)[x] = weights.row(y)[x] * (squared - (vp + std::min(vp, vq))) /
                    (vp + vq + kRoundingShare * brightness + kMinSquaredColour);
  });
  return out;
}

// Returns the weights for one half of a neighbouring frame, computed from the opposite halves:
// `here` is that of the denoised frame, `there` that of the neighbouring frame.
BorderedPlane half_weights(const Half& here, const Half& there, const BorderedPlane& same_surface) {
  BorderedPlane weights = same_surface;
  const BorderedPlane distance = colour_distance(here, there, same_surface);
  for (const auto& [radius, power] : kComparisons) {
    const BorderedPlane sums = box_sum(distance, radius), all = box_sum(same_surface, radius);
    for_each_pixel(weights.width(), weights.height(), [&](int x, int y) {
      const float mean = sums.row(y)[x] / std::max(all.row(y)[x], kMinAgreement);
      const float weight = 1.0f / (1.0f + std::max(mean, 0.0f));
      weights.row(y)[x] *= power == 1 ? weight : weight * weight;
    });
  }
  return weights;
}

// Calls body(planes, index) for all planes that are averaged, in a fixed order: colour, albedo,
// features, and the parts of DenoiseInput.
template <typename Input, typename Body>
void for_each_averaged(Input& input, const Body& body) {
  size_t index = 0;
  const auto visit = [&](auto& colour) {
    if (colour[0].a.empty()) return;
    for (auto& planes : colour) body(planes, index++);
  };
  visit(input.colour);
  visit(input.albedo);
  for (auto& planes : input.features) body(planes, index++);
  for (auto& part : input.parts) visit(part);
}

// The frame's planes in the order of for_each_averaged().
std::vector<std::array<BorderedPlane, 2>> own_planes(const DenoiseInput& frame, const Halves& h) {
  std::vector<std::array<BorderedPlane, 2>> out;
  for (size_t c = 0; c < 3; ++c) out.push_back({h.half[0].colour[c], h.half[1].colour[c]});
  const auto add = [&](const HalfPlanes& planes) {
    out.push_back(
        {padded_plane(planes.a, h.width, h.height), padded_plane(planes.b, h.width, h.height)});
  };
  if (!frame.albedo[0].a.empty()) {
    for (const HalfPlanes& planes : frame.albedo) add(planes);
  }
  for (const HalfPlanes& planes : frame.features) add(planes);
  for (const HalfColour& part : frame.parts) {
    for (const HalfPlanes& planes : part) out.push_back(read_channel(h, planes).half);
  }
  return out;
}

}  // namespace

AccumulatedFrames::AccumulatedFrames(const DenoiseInput& frame, const Halves& halves,
                                     std::span<const NeighbourFrame> neighbours)
    : input_(frame) {
  const int width = frame.width, height = frame.height;
  const auto row_begin = [width](int y) { return size_t(y) * size_t(width); };
  const size_t pixels = row_begin(height);
  input_.shared = {};
  {
    const std::vector<std::array<BorderedPlane, 2>> own = own_planes(frame, halves);
    planes_.assign(2 + 2 * own.size(), std::vector<float>(pixels));
    for_each_row(height, [&](int y) {
      for (size_t s = 0; s < 2; ++s) {
        const float* count = halves.half[s].count.row(y);
        std::copy_n(count, width, &planes_[s][row_begin(y)]);
        for (size_t k = 0; k < own.size(); ++k) {
          const float* value = own[k][s].row(y);
          float* to = &planes_[2 + 2 * k + s][row_begin(y)];
          for (int x = 0; x < width; ++x) to[x] = count[x] * value[x];
        }
      }
    });
  }
  frames_.assign(pixels, 1.0f);
  const std::vector<ComparedFeature> features = compared_features(frame, frame.tolerances);
  for (const NeighbourFrame& neighbour : neighbours) {
    const AlignedFrame aligned(neighbour, width, height);
    const Halves there = prepare_colour(aligned.input());
    const BorderedPlane same_surface =
        agreement(halves, there, features, compared_features(aligned.input(), frame.tolerances));
    for (size_t s = 0; s < 2; ++s) {
      const BorderedPlane weights =
          half_weights(halves.half[1 - s], there.half[1 - s], same_surface);
      for_each_row(height, [&](int y) {
        const float *weight = weights.row(y), *count = there.half[s].count.row(y);
        const size_t first = row_begin(y);
        for (int x = 0; x < width; ++x) {
          planes_[s][first + size_t(x)] += weight[x] * count[x];
          frames_[first + size_t(x)] += 0.5f * weight[x];
        }
        for_each_averaged(aligned.input(), [&](const HalfPlanes& planes, size_t k) {
          const float* value = (s == 0 ? planes.a : planes.b).data() + first;
          float* to = &planes_[2 + 2 * k + s][first];
          for (int x = 0; x < width; ++x) to[x] += weight[x] * count[x] * value[x];
        });
      });
    }
  }
  for_each_row(height, [&](int y) {
    for (size_t i = row_begin(y); i < row_begin(y + 1); ++i) {
      for (size_t p = 2; p < planes_.size(); ++p) {
        const float count = planes_[p % 2][i];
        planes_[p][i] = count > 0 ? planes_[p][i] / count : 0.0f;
      }
    }
  });
  input_.samples = {planes_[0], planes_[1]};
  for_each_averaged(input_, [&](HalfPlanes& planes, size_t k) {
    planes = {planes_[2 + 2 * k], planes_[3 + 2 * k]};
  });
}

double AccumulatedFrames::frames(int begin, int end) const {
  double sum = 0.0;
  const auto width = size_t(input_.width);
  for (size_t i = size_t(begin) * width; i < size_t(end) * width; ++i) sum += double(frames_[i]);
  return sum;
}

}  // namespace emberline
