#include "integrators/path_integrator.h"

#include "integrators/path_batch.h"

namespace emberline {

void PathIntegrator::estimate(const SampleBatch& batch, PixelSamples& samples,
                              std::span<SampleValue> values, RayCounters& counters) const {
  if (batch.scene.has_transmission()) {
    PathBatch<true>(settings_, batch, samples, counters).trace(values);
  } else {
    PathBatch<false>(settings_, batch, samples, counters).trace(values);
  }
}

}  // namespace emberline
