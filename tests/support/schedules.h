// Tests that a frame and a crop of it have the same bits with every driver and any number of
// threads (laws 1 and 2 in renderer/README.md).
#pragma once

#include <fmt/format.h>

#include "support/render.h"

namespace emberline::test {

// `image(settings)` must render the frame with these settings. This function calls it with one
// thread, then with each driver and two numbers of threads, and finally with the crop.
template <typename Image>
void expect_same_bits_with_every_driver(const RenderSettings& settings, const Rect& crop,
                                        const Image& image) {
  RenderSettings s = settings;
  s.threads = 1;
  const RenderedImage expected = image(s);
  for (const char* driver : {"bucket", "bisection", "adaptive"}) {
    for (const int threads : {2, 5}) {
      s.driver = driver;
      s.threads = threads;
      s.bucket_size = threads == 5 ? 7 : 16;
      s.adaptive.budget = s.adaptive.min_samples = s.adaptive.max_samples = s.spp;
      expect_same_bits(image(s), expected, fmt::format("{}, {} threads", driver, threads));
    }
  }
  s = settings;
  s.crop = crop;
  expect_same_bits(image(s), expected, "crop");
}

}  // namespace emberline::test
