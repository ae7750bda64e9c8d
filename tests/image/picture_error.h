// A frame's true error, measured against noisy references.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "renderer/drivers/adaptive/error_estimator.h"
#include "support/render.h"

namespace emberline::test {

// Two independent uniform renders. The product of a frame's differences to the two has the squared
// error as its expectation, because the noise of one reference is independent of the other's. So
// the two need fewer samples than a single reference with negligible noise.
struct References {
  RenderedImage a, b;
};

inline References render_references(const Scene& scene, const CameraDescription& view,
                                    RenderSettings s, uint32_t spp) {
  s.driver = "bucket";
  s.streams = StreamCount::kOne;
  s.spp = spp;
  s.seed = 0x5eed0u;
  References r;
  r.a = render(scene, view, s);
  s.seed = 0x5eed1u;
  r.b = render(scene, view, s);
  return r;
}

// Returns the squared error of the displayed picture, summed over the pixels of `part` and over R,
// G, B.
inline double squared_display_error(const RenderedImage& image, const References& r,
                                    const Rect& part) {
  double sum = 0;
  for (int y = part.y0; y < part.y1; ++y) {
    for (int x = part.x0; x < part.x1; ++x) {
      for (int c = 0; c < 3; ++c) {
        const double shown = double(display_value(image.pixel(x, y)[c]));
        sum += (shown - double(display_value(r.a.pixel(x, y)[c]))) *
               (shown - double(display_value(r.b.pixel(x, y)[c])));
      }
    }
  }
  return sum;
}

}  // namespace emberline::test
