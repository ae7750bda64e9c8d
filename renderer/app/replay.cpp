#include "renderer/app/replay.h"

#include <fmt/format.h>

#include <cstdio>

#include "renderer/core/errors.h"
#include "renderer/drivers/render_work_item.h"

namespace emberline {

int run_replay(const Frame& frame, const std::string& address) {
  int x = 0, y = 0;
  unsigned sample = 0;
  char rest = 0;
  if (std::sscanf(address.c_str(), "%d,%d,%u%c", &x, &y, &sample, &rest) != 3) {
    throw UsageError("--replay: '" + address + "' is not X,Y,SAMPLE");
  }
  if (x < 0 || x >= frame.width || y < 0 || y >= frame.height) {
    throw UsageError(fmt::format("--replay: pixel {},{} is outside the {} x {} frame", x, y,
                                 frame.width, frame.height));
  }
  RenderWorker worker(frame);
  Ray ray;
  const SampleValue value = worker.replay(x, y, sample, &ray);
  const RayCounters& rays = worker.counters().rays;
  // %a prints every bit, so that two replays can be compared exactly.
  fmt::print("pixel {},{} sample {} seed {}\n", x, y, sample, frame.seed);
  fmt::print("ray origin {:.9g} {:.9g} {:.9g} direction {:.9g} {:.9g} {:.9g} (internal space)\n",
             ray.origin.x, ray.origin.y, ray.origin.z, ray.direction.x, ray.direction.y,
             ray.direction.z);
  fmt::print("radiance {:.9g} {:.9g} {:.9g} ({:a} {:a} {:a})\n", value.radiance.x, value.radiance.y,
             value.radiance.z, value.radiance.x, value.radiance.y, value.radiance.z);
  fmt::print("alpha {:.9g}\nrays camera {} scatter {} shadow {}\n", value.alpha, rays.camera,
             rays.scatter, rays.shadow);
  return is_finite(value.radiance) ? kExitDone : kExitRenderFailed;
}

}  // namespace emberline
