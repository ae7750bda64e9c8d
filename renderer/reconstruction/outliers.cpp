#include "renderer/reconstruction/outliers.h"

#include <cmath>

#include "renderer/core/parallel.h"
#include "renderer/reconstruction/box.h"

namespace emberline {
namespace {

// A loss is attributed to an outlier if its square exceeds this multiple of the (robustly
// estimated) variance of the loss.
constexpr float kOutlierThreshold = 4.0f;
// Converts a squared mean absolute deviation to the variance of the sum of the channels: pi / 2 for
// a normal distribution, times 3 because the three channels mostly deviate together.
constexpr float kVarianceRatio = 1.5707963f * 3;  // pi / 2

}  // namespace

OutlierEnergy::OutlierEnergy(const Halves& h, const ColourPlanes& raw, const ColourPlanes& filtered)
    : halves_(h), share_(h.width, h.height) {
  BorderedPlane light(h.width, h.height), deviation(h.width, h.height);
  for_each_pixel(h.width, h.height, [&](int x, int y) {
    for (size_t c = 0; c < 3; ++c) light.row(y)[x] += raw[c].row(y)[x] - filtered[c].row(y)[x];
    deviation.row(y)[x] = std::sqrt(h.own_noise.row(y)[x]);
  });
  light = box_sum(light, kOutlierEnergyRadius);
  deviation = box_sum(deviation, kOutlierEnergyRadius);
  const BorderedPlane noise = box_sum(h.own_noise, kOutlierEnergyRadius);
  constexpr float kArea = (2 * kOutlierEnergyRadius + 1) * (2 * kOutlierEnergyRadius + 1);
  for_each_pixel(h.width, h.height, [&](int x, int y) {
    const float loss = light.row(y)[x], v = noise.row(y)[x], d = deviation.row(y)[x];
    const float explained = kOutlierThreshold * kVarianceRatio / kArea * d * d;
    const bool outlier = loss * loss > explained && v > 0;
    share_.row(y)[x] = outlier ? (1 - explained / (loss * loss)) / (v * kArea) : 0.0f;
  });
  own_fraction_ = box_sum(share_, kOutlierEnergyRadius);
  for_each_pixel(h.width, h.height, [&](int x, int y) {
    own_fraction_.row(y)[x] = std::min(own_fraction_.row(y)[x] * h.own_noise.row(y)[x], 1.0f);
  });
}

void OutlierEnergy::restore(const BorderedPlane& raw, BorderedPlane& filtered) const {
  BorderedPlane light(raw.width(), raw.height());
  for_each_pixel(raw.width(), raw.height(),
                 [&](int x, int y) { light.row(y)[x] = raw.row(y)[x] - filtered.row(y)[x]; });
  light = box_sum(light, kOutlierEnergyRadius);
  for_each_pixel(raw.width(), raw.height(),
                 [&](int x, int y) { light.row(y)[x] *= share_.row(y)[x]; });
  light = box_sum(light, kOutlierEnergyRadius);
  for_each_row(raw.height(), [&](int y) {
    const float* noise = halves_.own_noise.row(y);
    for (int x = 0; x < raw.width(); ++x) filtered.row(y)[x] += noise[x] * light.row(y)[x];
  });
}

}  // namespace emberline
