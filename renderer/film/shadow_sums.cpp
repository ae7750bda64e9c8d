#include "renderer/film/shadow_sums.h"

#include <algorithm>
#include <cmath>

#include "renderer/film/film_sample.h"
#include "renderer/film/finite_float.h"

namespace emberline {
namespace {

// Indices into a pixel's sums.
constexpr size_t kReceived = 0, kUnshadowed = 3, kCatcher = 6, kHidden = 7, kBackground = 8;

// Returns 1 if there is no light to block.
double ratio(double received, double unshadowed) {
  return unshadowed > 0.0 ? std::clamp(received / unshadowed, 0.0, 1.0) : 1.0;
}

double luminance_of(const double* rgb) {
  return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

}  // namespace

bool is_finite(const CatcherSample& sample) {
  return is_finite(sample.received) && is_finite(sample.unshadowed) &&
         std::isfinite(sample.catcher + sample.hidden + sample.background);
}

void add_shadow(const FilmSample& sample, double* sums) {
  if (!sample.catcher) return;
  const CatcherSample& catcher_sample = *sample.catcher;
  for (int c = 0; c < 3; ++c) {
    sums[kReceived + size_t(c)] += double(catcher_sample.received[c] * sample.filter_weight);
    sums[kUnshadowed + size_t(c)] += double(catcher_sample.unshadowed[c] * sample.filter_weight);
  }
  sums[kCatcher] += double(catcher_sample.catcher * sample.filter_weight);
  sums[kHidden] += double(catcher_sample.hidden * sample.filter_weight);
  sums[kBackground] += double(catcher_sample.background * sample.filter_weight);
}

void put_shadow(const double* sums, float* rgb) {
  const double visible = shadow_weight(sums);
  const double share = visible > 0.0 ? std::clamp(sums[kCatcher] / visible, 0.0, 1.0) : 0.0;
  for (size_t c = 0; c < 3; ++c) {
    const double lit = ratio(sums[kReceived + c], sums[kUnshadowed + c]);
    rgb[c] = to_finite_float(1.0 - share * (1.0 - lit));
  }
}

double shadow_weight(const double* sums) { return sums[kCatcher] + sums[kBackground]; }

double shadow_alpha(const double* sums) {
  return sums[kHidden] *
         (1.0 - ratio(luminance_of(sums + kReceived), luminance_of(sums + kUnshadowed)));
}

}  // namespace emberline
