#include "renderer/reconstruction/feature_filter.h"

#include "renderer/core/parallel.h"
#include "renderer/reconstruction/patches.h"
#include "renderer/reconstruction/tiles.h"

namespace emberline {
namespace {

constexpr int kRadius = 3, kPatch = 1;
static_assert(kRadius + kPatch == kFeatureReach);

struct Sums {
  float weight[kTileRows][kRun], value[kTileRows][kRun], noise[kTileRows][kRun];
};

// Adds the contributions of the pixels at offset (i, j) to the sums of a tile of one half. The
// weights come from `guide`, the other half.
void add_offset(const Tile& tile, int i, int j, const BorderedPlane& guide,
                const BorderedPlane& guide_noise, const BorderedPlane& value,
                const BorderedPlane& noise, const BorderedPlane& known, Sums& sums) {
  float means[kTileRows][kRun];
  patch_means<kPatch>(
      tile.y,
      [&](int y, float* __restrict out) {
        const int x0 = tile.x - kPatchPad;
        const float *p = guide.clamped_row(y) + x0, *q = guide.clamped_row(y + j) + x0 + i;
        const float *vp = guide_noise.clamped_row(y) + x0,
                    *vq = guide_noise.clamped_row(y + j) + x0 + i;
        for (int x = 0; x < kPatchRun; ++x) {
          const float d = p[x] - q[x], v = vp[x] + vq[x];
          // Values that differ only by rounding count as equal.
          const float tolerance = 1e-10f * (p[x] * p[x] + q[x] * q[x]) + 1e-30f;
          out[x] = (d * d - v) / (v + tolerance);
        }
      },
      means);
  for (int r = 0; r < tile.rows; ++r) {
    const int y = tile.y + r + j;
    if (y < 0 || y >= value.height()) continue;
    const float *f = value.row(y) + tile.x + i, *v = noise.row(y) + tile.x + i;
    const float* there = known.row(y) + tile.x + i;
    for (int x = 0; x < kRun; ++x) {
      const float w = exp_minus(std::max(means[r][x], 0.0f)) * there[x];
      sums.weight[r][x] += w;
      sums.value[r][x] += w * f[x];
      sums.noise[r][x] += w * w * v[x];
    }
  }
}

}  // namespace

Feature filter_feature(const Halves& h, const BorderedPlane& a, const BorderedPlane& b,
                       const BorderedPlane& variance) {
  const std::array<const BorderedPlane*, 2> value = {&a, &b};
  std::array<BorderedPlane, 2> noise;
  for (size_t s = 0; s < 2; ++s) {
    noise[s] = BorderedPlane(h.width, h.height);
    for_each_row(h.height, [&](int y) {
      const float *v = variance.row(y), *n = h.half[s].count.row(y);
      for (int x = 0; x < h.width; ++x) noise[s].row(y)[x] = v[x] / std::max(n[x], 1.0f);
      noise[s].extend_row(y);
    });
  }
  Feature out = {BorderedPlane(h.width, h.height), BorderedPlane(h.width, h.height)};
  for_each_tile(h.width, 0, h.height, [&](const Tile& tile) {
    std::array<Sums, 2> sums = {};
    for (int j = -kRadius; j <= kRadius; ++j) {
      for (int i = -kRadius; i <= kRadius; ++i) {
        for (size_t s = 0; s < 2; ++s) {
          add_offset(tile, i, j, *value[1 - s], noise[1 - s], *value[s], noise[s], h.half[s].known,
                     sums[s]);
        }
      }
    }
    for (int r = 0; r < tile.rows; ++r) {
      float *f = out.value.row(tile.y + r) + tile.x, *v = out.noise.row(tile.y + r) + tile.x;
      for (int x = 0; x < tile.columns; ++x) {
        float parts = 0.0f;
        for (const Sums& sum : sums) {
          const float w = sum.weight[r][x];
          if (w <= 0.0f) continue;
          parts += 1.0f;
          f[x] += sum.value[r][x] / w;
          v[x] += sum.noise[r][x] / (w * w);
        }
        f[x] /= std::max(parts, 1.0f);
        v[x] /= std::max(parts * parts, 1.0f);
      }
    }
  });
  for (int y = 0; y < h.height; ++y) {
    out.value.extend_row(y);
    out.noise.extend_row(y);
  }
  return out;
}

}  // namespace emberline
