#include "renderer/reconstruction/outliers.h"

#include <cmath>

#include "renderer/core/parallel.h"
#include "renderer/reconstruction/box.h"

namespace emberline {
namespace {

// A loss of so many times its own variance, as outliers do not raise it, is an outlier's.
constexpr float kSurprise = 4.0f;
// Of the squared mean deviation of a pixel to the variance; it has three channels, which
// mostly deviate together.
constexpr float kNormal = 1.5707963f * 3;  // pi / 2

BorderedPlane lost(const BorderedPlane& raw, const BorderedPlane& filtered) {
  BorderedPlane out(raw.width(), raw.height());
  for_each_row(raw.height(), [&](int y) {
    const float *r = raw.row(y), *f = filtered.row(y);
    for (int x = 0; x < raw.width(); ++x) out.row(y)[x] = r[x] - f[x];
  });
  return out;
}

}  // namespace

LostLight::LostLight(const Halves& h, const ColourPlanes& raw, const ColourPlanes& filtered)
    : halves_(h), share_(h.width, h.height) {
  BorderedPlane light(h.width, h.height), deviation(h.width, h.height);
  for (size_t c = 0; c < 3; ++c) {
    const BorderedPlane one = lost(raw[c], filtered[c]);
    for (int y = 0; y < h.height; ++y) {
      for (int x = 0; x < h.width; ++x) light.row(y)[x] += one.row(y)[x];
    }
  }
  for (int y = 0; y < h.height; ++y) {
    for (int x = 0; x < h.width; ++x) deviation.row(y)[x] = std::sqrt(h.own_noise.row(y)[x]);
  }
  light = box_sum(light, kLostLightRadius);
  deviation = box_sum(deviation, kLostLightRadius);
  const BorderedPlane noise = box_sum(h.own_noise, kLostLightRadius);
  constexpr float kArea = (2 * kLostLightRadius + 1) * (2 * kLostLightRadius + 1);
  for_each_row(h.height, [&](int y) {
    for (int x = 0; x < h.width; ++x) {
      const float loss = light.row(y)[x], v = noise.row(y)[x], d = deviation.row(y)[x];
      const float explained = kSurprise * kNormal / kArea * d * d;
      const bool outlier = loss * loss > explained && v > 0;
      share_.row(y)[x] = outlier ? (1 - explained / (loss * loss)) / (v * kArea) : 0.0f;
    }
  });
  own_share_ = box_sum(share_, kLostLightRadius);
  for_each_row(h.height, [&](int y) {
    for (int x = 0; x < h.width; ++x) {
      own_share_.row(y)[x] = std::min(own_share_.row(y)[x] * h.own_noise.row(y)[x], 1.0f);
    }
  });
}

void LostLight::give_back(const BorderedPlane& raw, BorderedPlane& filtered) const {
  BorderedPlane light = box_sum(lost(raw, filtered), kLostLightRadius);
  for_each_row(raw.height(), [&](int y) {
    for (int x = 0; x < raw.width(); ++x) light.row(y)[x] *= share_.row(y)[x];
  });
  light = box_sum(light, kLostLightRadius);
  for_each_row(raw.height(), [&](int y) {
    const float* noise = halves_.own_noise.row(y);
    for (int x = 0; x < raw.width(); ++x) filtered.row(y)[x] += noise[x] * light.row(y)[x];
  });
}

}  // namespace emberline
